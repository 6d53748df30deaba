// COLMAP's sparse model, binary and text: https://colmap.github.io/format.html COLMAP's upper left pixel centre is
// (0.5, 0.5), its camera frame x right, y down, z forward: both are ours. Poses are world-to-camera, x_camera = R
// x_world + t, so the centre is -R^T t. EQUIRECTANGULAR (sensor/models.h) shows longitude 0, which is forward, in the
// middle, right at its right, and up at the top.
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <span>
#include <unordered_map>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/colmap_models.h"
#include "io/scenes/colmap_scene.h"
#include "io/scenes/panorama_views.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

std::string supported_models() {
  std::string names;
  for (const ColmapModel& model : kColmapModels) {
    if (!names.empty()) names += ", ";
    names += model.name;
  }
  return "supported are " + names;
}

struct ColmapCamera {
  const ColmapModel* model = nullptr;
  std::uint64_t width = 0, height = 0;
  std::vector<double> parameters;
  std::string place;  ///< where in the cameras' file it stands
};

using ColmapCameras = std::map<std::uint64_t, ColmapCamera>;

Camera camera_from(const fs::path& file, const ColmapCamera& in) {
  const auto width = image_side(static_cast<double>(in.width)), height = image_side(static_cast<double>(in.height));
  if (!width || !height)
    throw InputError(file, in.place,
                     "an image size of " + std::to_string(in.width) + " x " + std::to_string(in.height));
  if (in.model->focal_lengths == 0) {
    if (in.parameters[0] != *width || in.parameters[1] != *height)
      throw InputError(file, in.place, "the parameters of a panorama are not its width and height");
    return panorama_camera(file, in.place, *width, *height, *height / std::numbers::pi);
  }
  Camera out;
  out.width = *width;
  out.height = *height;
  auto parameter = in.parameters.begin();
  out.fx = *parameter++;
  out.fy = in.model->focal_lengths == 1 ? out.fx : *parameter++;
  out.cx = *parameter++;
  out.cy = *parameter++;
  out.distortion.model = in.model->lens;
  for (const DistortionTerm term : in.model->terms()) out.distortion.*term = *parameter++;
  finish_camera(file, in.place, out);
  return out;
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
  // COLMAP writes '/' on every system; programs for Windows that write its format do not.
  const bool slashes = image.name.find('/') != std::string_view::npos;
  view.name = stated_photo_name(images_file, place, slashes ? std::string(image.name) : with_slashes(image.name));
  const auto camera = cameras.find(image.camera_id);
  if (camera == cameras.end())
    throw InputError(images_file, place,
                     "image " + quote(image.name) + " refers to camera " + std::to_string(image.camera_id) +
                         ", which " + cameras_file.filename().string() + " does not list");
  view.camera = camera_from(cameras_file, camera->second);
  const std::string of_image = place + ": image " + quote(image.name);
  const std::optional<Matrix3> rotation = rotation_from_quaternion(image.quaternion);
  if (!rotation) throw InputError(images_file, of_image, "the rotation quaternion has no direction");
  const auto& [tx, ty, tz] = image.translation;
  view.pose = finish_pose_from_translation(images_file, of_image, *rotation, {tx, ty, tz});
  return view;
}

/// Throws InputError when another camera has the number.
void add_camera(const fs::path& file, std::uint64_t number, ColmapCamera camera, ColmapCameras& cameras) {
  const std::string place = camera.place;
  const auto [first, fresh] = cameras.try_emplace(number, std::move(camera));
  if (!fresh)
    throw InputError(file, place,
                     "the camera number " + std::to_string(number) + " is taken, see " + first->second.place);
}

/// The numbers of a model's images. Views are ordered by name; a number that comes twice tells of lists that were put
/// together by hand or damaged.
class ImageNumbers {
 public:
  void add(const fs::path& file, const std::string& place, std::uint64_t number) {
    const auto [first, fresh] = places_.try_emplace(number, place);
    if (!fresh)
      throw InputError(file, place, "the image number " + std::to_string(number) + " is taken, see " + first->second);
  }

 private:
  std::unordered_map<std::uint64_t, std::string> places_;
};

// --- binary

ColmapCameras read_cameras_bin(const fs::path& file, std::string_view bytes) {
  ByteReader reader(file, bytes);
  constexpr const char* kWhat = "the camera list";
  const auto count = reader.read<std::uint64_t>(kWhat);
  ColmapCameras cameras;
  for (std::uint64_t i = 0; i < count; ++i) {
    ColmapCamera camera;
    camera.place = "byte " + std::to_string(bytes.size() - reader.remaining());
    const auto id = reader.read<std::uint32_t>(kWhat);
    const auto model = reader.read<std::int32_t>(kWhat);
    if (model < 0 || static_cast<std::size_t>(model) >= kColmapModels.size())
      reader.fail("camera model number " + std::to_string(model) + " is unknown; " + supported_models());
    camera.model = &kColmapModels[static_cast<std::size_t>(model)];
    camera.width = reader.read<std::uint64_t>(kWhat);
    camera.height = reader.read<std::uint64_t>(kWhat);
    for (std::size_t p = 0; p < camera.model->parameters(); ++p)
      camera.parameters.push_back(reader.read<double>(kWhat));
    add_camera(file, id, std::move(camera), cameras);
  }
  return cameras;
}

void read_images_bin(const fs::path& file, std::string_view bytes, const fs::path& cameras_file,
                     const ColmapCameras& cameras, SceneFile& scene) {
  ByteReader reader(file, bytes);
  constexpr const char* kWhat = "the image list";
  const auto count = reader.read<std::uint64_t>(kWhat);
  ImageNumbers numbers;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string place = "byte " + std::to_string(bytes.size() - reader.remaining());
    ColmapImage image;
    const auto number = reader.read<std::uint32_t>(kWhat);
    numbers.add(file, place, number);
    for (double& q : image.quaternion) q = reader.read<double>(kWhat);
    for (double& t : image.translation) t = reader.read<double>(kWhat);
    image.camera_id = reader.read<std::uint32_t>(kWhat);
    image.name = reader.take_text(kWhat);
    const auto points = reader.read<std::uint64_t>(kWhat);
    constexpr std::uint64_t kPointBytes = 24;  // x, y, 3D point number
    if (points > reader.remaining() / kPointBytes) reader.fail("the file ends inside the points of an image");
    reader.take(points * kPointBytes, kWhat);
    View& view = scene.views.emplace_back(view_from(file, place, image, cameras_file, cameras));
    view.number = number;
  }
}

// --- text

/// Lines of a text model with their numbers. COLMAP's own "Number of ...: N" comment is no part of the model, but it
/// tells of files that were cut: COLMAP ends every line, so there a last line without an end is doubtful.
class ModelLines {
 public:
  ModelLines(const fs::path& file, std::string_view text, const char* what)
      : file_(file), rest_(without_byte_order_mark(text)), what_(what) {
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
    ended_ = rest_.find('\n') != std::string_view::npos;
    line = next_line(rest_);
    return true;
  }
  /// The line read last has an end.
  bool ended() const { return ended_; }
  /// To be called at the end of the file. Entries that are missing were taken out by hand, or the file was cut between
  /// two lines. `last_ended`: the last entry has a line end; otherwise its `last_part` may be a shorter one than was
  /// written.
  void check_count(std::uint64_t found, bool last_ended, const char* last_part,
                   std::vector<std::string>& warnings) const {
    if (!announced_) return;
    if (found < *announced_ && !ended_) fail("the file ends inside this line");
    const std::string name = file_.filename().string();
    if (found != *announced_)
      warnings.push_back(name + " announces " + std::to_string(*announced_) + ' ' + what_ + " and holds " +
                         std::to_string(found));
    if (!last_ended) warnings.push_back("the last line of " + name + " has no end; " + last_part + " may be cut short");
  }
  std::string place() const { return "line " + std::to_string(number_); }
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file_, place(), reason); }

  double number(std::string_view& line, const char* what) const {
    const std::string_view word = next_word(line);
    const std::optional<double> value = number_from(word);
    if (!value) fail(std::string("expected ") + what + ", found " + quote(word));
    return *value;
  }
  std::uint64_t integer(std::string_view& line, const char* what) const {
    const std::string_view word = next_word(line);
    const std::optional<std::uint64_t> value = integer_from<std::uint64_t>(word);
    if (!value) fail(std::string("expected ") + what + ", found " + quote(word));
    return *value;
  }

 private:
  const fs::path& file_;
  std::string_view rest_;
  const char* what_;
  std::size_t number_ = 0;
  bool ended_ = true;
  std::optional<std::uint64_t> announced_;
};

ColmapCameras read_cameras_txt(const fs::path& file, std::string_view text, std::vector<std::string>& warnings) {
  ModelLines lines(file, text, "cameras");
  ColmapCameras cameras;
  for (std::string_view line; lines.next(line);) {
    ColmapCamera camera;
    camera.place = lines.place();
    const std::uint64_t id = lines.integer(line, "a camera number");
    const std::string_view name = next_word(line);
    for (const ColmapModel& model : kColmapModels)
      if (model.name == name) camera.model = &model;
    if (camera.model == nullptr) lines.fail("camera model " + quote(name) + " is unknown; " + supported_models());
    camera.width = lines.integer(line, "an image width");
    camera.height = lines.integer(line, "an image height");
    for (std::size_t p = 0; p < camera.model->parameters(); ++p)
      camera.parameters.push_back(lines.number(line, "a camera parameter"));
    if (const std::string_view extra = next_word(line); !extra.empty())
      lines.fail("camera model " + std::string(name) + " has " + std::to_string(camera.model->parameters()) +
                 " parameters, found a further " + quote(extra));
    add_camera(file, id, std::move(camera), cameras);
  }
  lines.check_count(cameras.size(), lines.ended(), "its last number", warnings);
  return cameras;
}

/// True for X Y POINT3D_ID triples and for an empty line: numbers, every third of them whole, however it is written
/// (other programs write -1.0). The pose of a photo whose name is three numbers is such a line if QX and TX are whole.
bool reads_as_points(std::string_view line) {
  std::size_t words = 0;
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line), ++words) {
    const std::optional<double> value = number_from(word);
    if (!value || (words % 3 == 2 && *value != std::floor(*value))) return false;
  }
  return words % 3 == 0;
}

/// Each image has two lines, its pose and its points, which are not used here. One in the other's place is refused:
/// files without lines of points, or with single lines taken out, would lose images or gain some in silence.
void read_images_txt(const fs::path& file, std::string_view text, const fs::path& cameras_file,
                     const ColmapCameras& cameras, SceneFile& scene) {
  ModelLines lines(file, text, "images");
  ImageNumbers numbers;
  std::uint64_t count = 0;
  bool pose_ended = true;
  for (std::string_view line; lines.next(line);) {
    if (reads_as_points(line))
      lines.fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, found what reads as the points of an image");
    ++count;
    pose_ended = lines.ended();
    ColmapImage image;
    const std::uint64_t number = lines.integer(line, "an image number");
    numbers.add(file, lines.place(), number);
    for (double& q : image.quaternion) q = lines.number(line, "a quaternion");
    for (double& t : image.translation) t = lines.number(line, "a translation");
    image.camera_id = lines.integer(line, "a camera number");
    image.name = trimmed(line);
    View& view = scene.views.emplace_back(view_from(file, lines.place(), image, cameras_file, cameras));
    view.number = static_cast<std::uint32_t>(number);  // COLMAP's are no larger
    if (lines.next_raw(line) && !reads_as_points(line))
      lines.fail("expected the points of the image above (X Y POINT3D_ID triples) or an empty line");
  }
  lines.check_count(count, pose_ended, "the name of the last image", scene.warnings);
}

bool holds_model(const fs::path& folder, const char* extension) {
  std::error_code ignored;
  return fs::exists(folder / (std::string("cameras") + extension), ignored) &&
         fs::exists(folder / (std::string("images") + extension), ignored);
}

/// The models that COLMAP's mapper numbers in a folder, one for each group of images it could not bring into the frame
/// of another, by number.
std::map<std::uint32_t, fs::path> numbered_models(const fs::path& folder) {
  std::map<std::uint32_t, fs::path> models;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const auto number = integer_from<std::uint32_t>(name);
    if (number && (holds_model(entry.path(), ".bin") || holds_model(entry.path(), ".txt")))
      models.emplace(*number, entry.path());
  }
  return models;
}

/// The number of images that a model's list claims, without reading it; 0 for a broken list.
std::uint64_t count_images(const fs::path& model) {
  std::uint64_t count = 0;
  if (holds_model(model, ".bin")) {
    const std::string head = first_bytes(model / "images.bin", sizeof count);
    if (head.size() == sizeof count) std::memcpy(&count, head.data(), sizeof count);
    return count;
  }
  const FileBytes bytes(model / "images.txt");
  std::string_view rest = bytes.view();
  while (!rest.empty()) {
    std::string_view line = next_line(rest);
    const std::string_view word = next_word(line);
    if (word.empty() || word.front() == '#') continue;
    ++count;
    next_line(rest);  // its points
  }
  return count;
}

/// A model itself, one of its files, or a data set's root as COLMAP and its users lay it out; the folder above several
/// numbered models.
std::optional<fs::path> find_model(const fs::path& source) {
  if (is_file(source)) {
    const std::string name = source.stem().string(), extension = source.extension().string();
    if ((name != "cameras" && name != "images") || (extension != ".bin" && extension != ".txt")) return std::nullopt;
    const fs::path folder = folder_of(source);
    return holds_model(folder, extension.c_str()) ? std::optional(folder) : std::nullopt;
  }
  for (const char* below : {"", "sparse", "colmap"}) {
    const fs::path folder = *below == '\0' ? source : source / below;
    if (holds_model(folder, ".bin") || holds_model(folder, ".txt")) return folder;
    const auto models = numbered_models(folder);
    if (!models.empty()) return models.size() == 1 ? models.begin()->second : folder;
  }
  return std::nullopt;
}

/// The numbered model in a folder with the most images: number 0 is the first that was begun, often a fragment.
fs::path largest_model(const fs::path& folder, std::vector<std::string>& warnings) {
  const auto models = numbered_models(folder);
  fs::path best;
  std::uint64_t most = 0;
  for (const auto& [number, model] : models)
    if (const std::uint64_t count = count_images(model); best.empty() || count > most) {
      best = model;
      most = count;
    }
  warnings.push_back("the folder holds " + std::to_string(models.size()) + " models; the largest, " +
                     best.filename().string() + ", of " + std::to_string(most) +
                     " images, is read, the others cannot be brought into its frame");
  return best;
}

SceneFile read_model(const fs::path& found) {
  std::vector<std::string> warnings;
  const fs::path model =
      holds_model(found, ".bin") || holds_model(found, ".txt") ? found : largest_model(found, warnings);
  const bool binary = holds_model(model, ".bin");
  const std::string extension = binary ? ".bin" : ".txt";
  const fs::path cameras = model / ("cameras" + extension), images = model / ("images" + extension);
  SceneFile scene = parse_colmap(binary, cameras, FileBytes(cameras).view(), images, FileBytes(images).view());
  scene.warnings.insert(scene.warnings.begin(), warnings.begin(), warnings.end());
  for (const char* part : {"cameras", "images", "points3D", "rigs", "frames"})
    if (const fs::path file = model / (part + extension); is_file(file)) scene.files.push_back(file);
  fs::path folder = fs::absolute(model).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  for (int level = 0; level <= 2; ++level, folder = folder.parent_path())
    if (scene.image_folders.empty() || folder / "images" != scene.image_folders.back())
      scene.image_folders.push_back(folder / "images");
  return scene;
}

}  // namespace

SceneFile parse_colmap(bool binary, const fs::path& cameras_file, std::string_view cameras_bytes,
                       const fs::path& images_file, std::string_view images_bytes) {
  SceneFile scene;
  scene.listing = images_file;
  const ColmapCameras cameras = binary ? read_cameras_bin(cameras_file, cameras_bytes)
                                       : read_cameras_txt(cameras_file, cameras_bytes, scene.warnings);
  binary ? read_images_bin(images_file, images_bytes, cameras_file, cameras, scene)
         : read_images_txt(images_file, images_bytes, cameras_file, cameras, scene);
  return scene;
}

extern const SceneFormat kColmap{"COLMAP",
                                 "a COLMAP model (a folder with cameras.bin and images.bin or cameras.txt and "
                                 "images.txt, there or in sparse/NUMBER, "
                                 "sparse or colmap below it)",
                                 find_model,
                                 nullptr,
                                 {},
                                 read_model};

}  // namespace gpvc::io
