// NVM, the N-View Match of VisualSFM: "The camera model and coordinate system" and "The output format" of
// ccwu.me/vsfm/doc.html; SaveNVM and the camera of its bundle adjustment, pba (util.h and DataInterface.h), for signs
// and units.
//
//   NVM_V3 [FixedK fx cx fy cy [r]]        or NVM_V3_R9T
//   COUNT, then a line a camera: NAME f qw qx qy qz cx cy cz r 0; of R9T: NAME f R00 .. R22 tx ty tz r 0
//   COUNT, then a line a point             and further models until one has no camera
//
// Pixels   relative to the principal point, which is the photo's middle unless it is fixed: (w / 2, h / 2) in ours.
// Camera   x right, y down, z forward: ours. The quaternion takes world to camera, the position is the centre.
// Lens     acts from the photo to the plane of focal length 1: q (1 + r q^2). It is that of the line; a fixed one if the
//          line has none.
// Names    blanks are written as '"'. Other programs write them as they are, or the whole name between two '"'.
#include <algorithm>
#include <array>
#include <cmath>

#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

/// Cameras without a fixed principal point have cx and cy 0 until the photo is known.
void centre_principal_point(Camera& camera, int width, int height) {
  if (camera.cx != 0 || camera.cy != 0) return;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
}

class NvmReader {
 public:
  NvmReader(const fs::path& file, std::string_view text) : file_(file), text_(text) {
    scene_.listing = file;
    scene_.size_camera = centre_principal_point;
  }

  SceneFile read() {
    read_header();
    std::size_t models = 0;
    while (read_model()) ++models;
    if (models > 1)
      scene_.warnings.push_back("the file holds " + std::to_string(models) + " models; the largest, of " +
                                std::to_string(scene_.views.size()) +
                                " photos, is read, the others cannot be brought into its frame");
    return std::move(scene_);
  }

 private:
  /// The next line with something in it; empty at the end.
  std::string_view line() {
    std::string_view found;
    while (found.empty() && !text_.empty()) {
      found = trimmed(next_line(text_));
      ++line_;
    }
    return found;
  }
  std::string place() const { return "line " + std::to_string(line_); }

  void read_header() {
    std::string_view header = line();
    const std::string_view version = next_word(header);
    matrices_ = version == "NVM_V3_R9T";
    if (!matrices_ && version != "NVM_V3") throw InputError(file_, place(), "expected NVM_V3");
    if (next_word(header) != "FixedK") return;
    std::vector<double> values;
    for (std::string_view word = next_word(header); !word.empty(); word = next_word(header))
      values.push_back(number_from(word).value_or(NAN));
    if ((values.size() != 4 && values.size() != 5) ||
        !std::ranges::all_of(values, [](double v) { return std::isfinite(v); }))
      throw InputError(file_, place(), "expected FixedK fx cx fy cy [r]");
    values.resize(5);
    fixed_ = values;
  }

  /// Reads a model and keeps it if it has more photos than those before; false at the end.
  bool read_model() {
    const std::string_view count = line();
    const auto cameras = integer_from<std::uint32_t>(count);
    if (!cameras && scene_.views.empty()) throw InputError(file_, place(), "expected a number of cameras");
    if (!cameras || *cameras == 0) return false;  // what follows lists files of points
    std::vector<View> views;
    for (std::uint32_t i = 0; i < *cameras; ++i) {
      views.push_back(read_camera());
      views.back().number = i;
    }
    if (views.size() > scene_.views.size()) scene_.views = std::move(views);
    const std::string_view points = line();
    if (points.empty()) return true;
    const auto lines = integer_from<std::uint64_t>(points);
    if (!lines) throw InputError(file_, place(), "expected a number of points");
    for (std::uint64_t i = 0; i < *lines; ++i)
      if (line().empty())
        throw InputError(file_, place(),
                         "ends after " + std::to_string(i) + " of " + std::to_string(*lines) + " points");
    return true;
  }

  View read_camera() {
    const std::string_view whole = line();
    if (whole.empty()) throw InputError(file_, place(), "ends before its last camera");
    // The numbers are read from the end: some programs write blanks in names as they are.
    const std::size_t count = matrices_ ? 15 : 10;
    std::array<double, 15> v{};
    std::string_view name = whole;
    for (std::size_t i = count; i-- > 0;) {
      const std::size_t begin = name.find_last_of(" \t") + 1;  // 0 where there is none
      const std::optional<double> value = number_from(name.substr(begin));
      name = trimmed(name.substr(0, begin));
      if (!value || name.empty())
        throw InputError(file_, place(), "expected the name of a photo and " + std::to_string(count) + " numbers");
      v[i] = *value;
    }
    if (name.size() > 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    View view;
    view.name = stated_photo_name(file_, place(), with_slashes(name));
    std::ranges::replace(view.name, '"', ' ');
    view.photo = view.name;
    view.camera = camera_of(v[0], v[count - 2]);
    const auto rotation = matrices_ ? rotation_near({v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9]})
                                    : rotation_from_quaternion({v[1], v[2], v[3], v[4]});
    if (!rotation)
      throw InputError(file_, place(), matrices_ ? "the matrix is no rotation" : "the quaternion has no direction");
    view.pose = matrices_ ? finish_pose_from_translation(file_, place(), *rotation, {v[10], v[11], v[12]})
                          : finish_pose(file_, place(), *rotation, {v[5], v[6], v[7]});
    return view;
  }

  Camera camera_of(double focal, double radial) const {
    Camera camera{0, 0, focal, focal, 0, 0, {}};
    if (!fixed_.empty()) {
      camera.fx = fixed_[0];
      camera.cx = fixed_[1];
      camera.fy = fixed_[2];
      camera.cy = fixed_[3];
      if (radial == 0) radial = fixed_[4];
    }
    if (radial != 0) camera.distortion.model = LensModel::inverse_radial;
    camera.distortion.k1 = radial;
    finish_camera(file_, place(), camera);
    return camera;
  }

  const fs::path& file_;
  std::string_view text_;
  std::size_t line_ = 0;
  bool matrices_ = false;
  std::vector<double> fixed_;  ///< fx cx fy cy r; empty: none
  SceneFile scene_;
};

bool is_nvm(const fs::path& file) {
  return lower_case(file.extension().string()) == ".nvm" && first_bytes(file, 6) == "NVM_V3";
}

}  // namespace

extern const SceneFormat kNvm{"NVM",
                              "an NVM file of VisualSFM, .nvm (or a folder with one)",
                              [](const fs::path& source) { return find_file(source, ".nvm", is_nvm); },
                              [](const fs::path& file, std::string_view text) { return NvmReader(file, text).read(); },
                              {"images", "../images"}};

}  // namespace gpvc::io
