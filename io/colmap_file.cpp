// COLMAP's sparse model, binary and text: https://colmap.github.io/format.html
// COLMAP's upper left pixel centre is (0.5, 0.5), its camera frame x right, y down, z forward: both are ours.
// Poses are world-to-camera, x_camera = R x_world + t, so the centre is -R^T t.
#include <array>
#include <cmath>
#include <map>
#include <span>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/scene_file.h"
#include "io/text_scan.h"

namespace gpvc {

namespace {

namespace fs = std::filesystem;

/// COLMAP's camera models by their number; those without a conversion are known only to be skipped.
struct Model {
  std::string_view name;
  std::size_t parameters;
  bool supported;
};
constexpr std::array<Model, 12> kModels{{{"SIMPLE_PINHOLE", 3, true},
                                         {"PINHOLE", 4, true},
                                         {"SIMPLE_RADIAL", 4, true},
                                         {"RADIAL", 5, true},
                                         {"OPENCV", 8, true},
                                         {"OPENCV_FISHEYE", 8, false},
                                         {"FULL_OPENCV", 12, false},
                                         {"FOV", 5, false},
                                         {"SIMPLE_RADIAL_FISHEYE", 4, false},
                                         {"RADIAL_FISHEYE", 5, false},
                                         {"THIN_PRISM_FISHEYE", 12, false},
                                         {"RAD_TAN_THIN_PRISM_FISHEYE", 16, false}}};
constexpr const char* kSupported = "supported are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV";

struct ColmapCamera {
  const Model* model = nullptr;
  std::uint64_t width = 0, height = 0;
  std::vector<double> parameters;
  std::string place;  ///< where in the cameras' file it stands
};

using ColmapCameras = std::map<std::uint64_t, ColmapCamera>;

Camera camera_from(const fs::path& file, const ColmapCamera& in) {
  const auto fail = [&](const std::string& reason) { throw InputError(file, in.place, reason); };
  if (!in.model->supported)
    fail("camera model " + std::string(in.model->name) + " is not supported; " + kSupported);
  constexpr std::uint64_t kMaxSide =
      1u << 24;  // far beyond any sensor, and safe in every int product of two sides
  if (in.width < 1 || in.height < 1 || in.width > kMaxSide || in.height > kMaxSide)
    fail("an image size of " + std::to_string(in.width) + " x " + std::to_string(in.height));
  const std::vector<double>& p = in.parameters;
  for (const double parameter : p)
    if (!std::isfinite(parameter)) fail("a camera parameter is not finite");
  Camera out;
  out.width = static_cast<int>(in.width);
  out.height = static_cast<int>(in.height);
  const bool two_focal = in.model->name == "PINHOLE" || in.model->name == "OPENCV";
  const std::size_t c = two_focal ? 2 : 1;
  out.fx = p[0];
  out.fy = p[two_focal ? 1 : 0];
  out.cx = p[c];
  out.cy = p[c + 1];
  if (p.size() > c + 2) out.distortion.k1 = p[c + 2];
  if (p.size() > c + 3) out.distortion.k2 = p[c + 3];
  if (p.size() > c + 5) {
    out.distortion.p1 = p[c + 4];
    out.distortion.p2 = p[c + 5];
  }
  if (!(out.fx > 0 && out.fy > 0)) fail("the focal length is not positive");
  limit_distortion(out);
  return out;
}

/// \throws std::string (the reason) when the quaternion is none
Pose pose_from(const std::array<double, 4>& quaternion, const std::array<double, 3>& t) {
  const double norm =
      std::hypot(std::hypot(quaternion[0], quaternion[1]), std::hypot(quaternion[2], quaternion[3]));
  if (!(norm > 0) || !std::isfinite(norm)) throw std::string("the rotation quaternion has no direction");
  if (!std::isfinite(t[0]) || !std::isfinite(t[1]) || !std::isfinite(t[2]))
    throw std::string("the translation is not finite");
  const double w = quaternion[0] / norm, x = quaternion[1] / norm, y = quaternion[2] / norm,
               z = quaternion[3] / norm;
  Pose pose;
  pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                   2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                   2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  const auto& r = pose.rotation;
  pose.centre = {-(r[0] * t[0] + r[3] * t[1] + r[6] * t[2]), -(r[1] * t[0] + r[4] * t[1] + r[7] * t[2]),
                 -(r[2] * t[0] + r[5] * t[1] + r[8] * t[2])};
  if (!std::isfinite(pose.centre.x) || !std::isfinite(pose.centre.y) || !std::isfinite(pose.centre.z))
    throw std::string("the camera centre is not finite");
  return pose;
}

struct ColmapImage {
  std::array<double, 4> quaternion;
  std::array<double, 3> translation;
  std::uint64_t camera_id = 0;
  std::string_view name;
};

View view_from(const fs::path& images_file, const std::string& place, const ColmapImage& image,
               const fs::path& cameras_file, const ColmapCameras& cameras) {
  View view;
  view.name = image.name;
  if (view.name.empty()) throw InputError(images_file, place, "an image without a name");
  const auto camera = cameras.find(image.camera_id);
  if (camera == cameras.end())
    throw InputError(images_file, place,
                     "image " + in_quotes(image.name) + " refers to camera " +
                         std::to_string(image.camera_id) + ", which " + cameras_file.filename().string() +
                         " does not list");
  view.camera = camera_from(cameras_file, camera->second);
  try {
    view.pose = pose_from(image.quaternion, image.translation);
  } catch (const std::string& reason) {
    throw InputError(images_file, place, "image " + in_quotes(image.name) + ": " + reason);
  }
  return view;
}

// --- binary

ColmapCameras read_cameras_bin(const fs::path& file) {
  const FileBytes bytes(file);
  ByteReader reader(file, bytes.view());
  constexpr const char* kWhat = "the camera list";
  const auto count = reader.read<std::uint64_t>(kWhat);
  ColmapCameras cameras;
  for (std::uint64_t i = 0; i < count; ++i) {
    ColmapCamera camera;
    camera.place = "byte " + std::to_string(bytes.view().size() - reader.remaining());
    const auto id = reader.read<std::uint32_t>(kWhat);
    const auto model = reader.read<std::int32_t>(kWhat);
    if (model < 0 || static_cast<std::size_t>(model) >= kModels.size())
      reader.fail("camera model number " + std::to_string(model) + " is unknown; " + kSupported);
    camera.model = &kModels[static_cast<std::size_t>(model)];
    camera.width = reader.read<std::uint64_t>(kWhat);
    camera.height = reader.read<std::uint64_t>(kWhat);
    for (std::size_t p = 0; p < camera.model->parameters; ++p)
      camera.parameters.push_back(reader.read<double>(kWhat));
    cameras[id] = std::move(camera);
  }
  return cameras;
}

std::vector<View> read_images_bin(const fs::path& file, const fs::path& cameras_file,
                                  const ColmapCameras& cameras) {
  const FileBytes bytes(file);
  ByteReader reader(file, bytes.view());
  constexpr const char* kWhat = "the image list";
  const auto count = reader.read<std::uint64_t>(kWhat);
  std::vector<View> views;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string place = "byte " + std::to_string(bytes.view().size() - reader.remaining());
    ColmapImage image;
    reader.read<std::uint32_t>(kWhat);  // the image's number: views are ordered by name
    for (double& q : image.quaternion) q = reader.read<double>(kWhat);
    for (double& t : image.translation) t = reader.read<double>(kWhat);
    image.camera_id = reader.read<std::uint32_t>(kWhat);
    image.name = reader.take_text(kWhat);
    const auto points = reader.read<std::uint64_t>(kWhat);
    constexpr std::uint64_t kPointBytes = 24;  // x, y, 3D point number
    if (points > reader.remaining() / kPointBytes) reader.fail("the file ends inside the points of an image");
    reader.take(points * kPointBytes, kWhat);
    views.push_back(view_from(file, place, image, cameras_file, cameras));
  }
  return views;
}

// --- text

/// Lines of a text model with their numbers. Where COLMAP's own "Number of ...: N" comment stands, the file
/// was written by a program that ends every line: a last line without an end was cut off.
class ModelLines {
 public:
  ModelLines(const fs::path& file, std::string_view text, std::string_view what) : file_(file), rest_(text) {
    const std::string comment = "# Number of " + std::string(what) + ": ";
    const std::size_t at = text.substr(0, 1000).find(comment);
    if (at == std::string_view::npos) return;
    std::string_view digits = text.substr(at + comment.size(), 20);
    digits = digits.substr(0, digits.find_first_not_of("0123456789"));
    if (const auto number = integer_from<std::uint64_t>(digits)) announced_ = *number;
  }
  /// The next line that is neither blank nor a comment.
  bool next(std::string_view& line) {
    while (next_raw(line)) {
      std::string_view copy = line;
      const std::string_view word = next_word(copy);
      if (!word.empty() && word.front() != '#') return true;
    }
    return false;
  }
  bool next_raw(std::string_view& line) {
    if (rest_.empty()) return false;
    ++number_;
    if (announced_ && rest_.find('\n') == std::string_view::npos) fail("the file ends inside this line");
    line = next_line(rest_);
    return true;
  }
  void check_count(std::uint64_t found, const char* what) const {
    if (announced_ && found != *announced_)
      fail("the file announces " + std::to_string(*announced_) + ' ' + what + " and holds " +
           std::to_string(found));
  }
  std::string place() const { return "line " + std::to_string(number_); }
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file_, place(), reason); }

  double number(std::string_view& line, const char* what) const {
    const std::string_view word = next_word(line);
    const std::optional<double> value = number_from(word);
    if (!value) fail(std::string("expected ") + what + ", found " + in_quotes(word));
    return *value;
  }
  std::uint64_t integer(std::string_view& line, const char* what) const {
    const std::string_view word = next_word(line);
    const std::optional<std::uint64_t> value = integer_from<std::uint64_t>(word);
    if (!value) fail(std::string("expected ") + what + ", found " + in_quotes(word));
    return *value;
  }

 private:
  const fs::path& file_;
  std::string_view rest_;
  std::size_t number_ = 0;
  std::optional<std::uint64_t> announced_;
};

ColmapCameras read_cameras_txt(const fs::path& file) {
  const FileBytes bytes(file);
  ModelLines lines(file, bytes.view(), "cameras");
  ColmapCameras cameras;
  for (std::string_view line; lines.next(line);) {
    ColmapCamera camera;
    camera.place = lines.place();
    const std::uint64_t id = lines.integer(line, "a camera number");
    const std::string_view name = next_word(line);
    for (const Model& model : kModels)
      if (model.name == name) camera.model = &model;
    if (camera.model == nullptr) lines.fail("camera model " + in_quotes(name) + " is unknown; " + kSupported);
    camera.width = lines.integer(line, "an image width");
    camera.height = lines.integer(line, "an image height");
    for (std::size_t p = 0; p < camera.model->parameters; ++p)
      camera.parameters.push_back(lines.number(line, "a camera parameter"));
    if (const std::string_view extra = next_word(line); !extra.empty())
      lines.fail("camera model " + std::string(name) + " has " + std::to_string(camera.model->parameters) +
                 " parameters, found a further " + in_quotes(extra));
    cameras[id] = std::move(camera);
  }
  lines.check_count(cameras.size(), "cameras");
  return cameras;
}

/// The second line of an image holds X Y POINT3D_ID triples. It is not read, but a file written without it
/// must not lose every other image in silence: the line has to be empty or to end in an integer.
void check_points(const ModelLines& lines, std::string_view line) {
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  if (line.empty()) return;
  const std::size_t blank = line.find_last_of(" \t");
  if (!integer_from(line.substr(blank == std::string_view::npos ? 0 : blank + 1)))
    lines.fail("expected the points of the image above (X Y POINT3D_ID triples) or an empty line");
}

std::vector<View> read_images_txt(const fs::path& file, const fs::path& cameras_file,
                                  const ColmapCameras& cameras) {
  const FileBytes bytes(file);
  ModelLines lines(file, bytes.view(), "images");
  std::vector<View> views;
  for (std::string_view line; lines.next(line);) {
    ColmapImage image;
    lines.integer(line, "an image number");
    for (double& q : image.quaternion) q = lines.number(line, "a quaternion");
    for (double& t : image.translation) t = lines.number(line, "a translation");
    image.camera_id = lines.integer(line, "a camera number");
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    image.name = line;
    views.push_back(view_from(file, lines.place(), image, cameras_file, cameras));
    if (lines.next_raw(line)) check_points(lines, line);
  }
  lines.check_count(views.size(), "images");
  return views;
}

bool holds_model(const fs::path& folder, const char* extension) {
  std::error_code ignored;
  return fs::exists(folder / (std::string("cameras") + extension), ignored) &&
         fs::exists(folder / (std::string("images") + extension), ignored);
}

}  // namespace

std::optional<SceneFile> read_colmap(const fs::path& source) {
  // A model itself, or a data set's root as COLMAP and its users lay it out.
  for (const char* below : {"", "0", "sparse/0", "sparse", "colmap"}) {
    fs::path folder = fs::absolute(source / below).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();
    for (const char* extension : {".bin", ".txt"}) {
      if (!holds_model(folder, extension)) continue;
      const bool binary = std::string_view(extension) == ".bin";
      const fs::path shown = below[0] == '\0' ? source : source / below;
      const fs::path cameras_file = shown / (std::string("cameras") + extension);
      SceneFile scene;
      scene.listing = shown / (std::string("images") + extension);
      const ColmapCameras cameras = binary ? read_cameras_bin(cameras_file) : read_cameras_txt(cameras_file);
      scene.views = binary ? read_images_bin(scene.listing, cameras_file, cameras)
                           : read_images_txt(scene.listing, cameras_file, cameras);
      for (int level = 0; level <= 2; ++level, folder = folder.parent_path())
        if (scene.image_folders.empty() || folder / "images" != scene.image_folders.back())
          scene.image_folders.push_back(folder / "images");
      return scene;
    }
  }
  return std::nullopt;
}

}  // namespace gpvc
