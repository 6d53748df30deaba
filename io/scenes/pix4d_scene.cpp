// The calibrated_camera_parameters.txt that Pix4Dmapper writes in 1_initial/params: "What does the Output Params Folder
// contain?" and "How are the Internal and External Camera Parameters defined?" of support.pix4d.com, and the file's own
// first lines:
//
//   fileName imageWidth imageHeight
//   camera matrix K [3x3]
//   radial distortion [3x1]
//   tangential distortion [2x1]
//   camera position t [3x1]
//   camera rotation R [3x3]
//   camera model m = K [R|-Rt] X
//
// Pixels   the origin is the upper left corner of the image, x right, y down: ours. PREFIX_calibrated_internal_camera_
//          parameters.cam states the same principal point from the middle of the sensor, which is (w / 2, h / 2) less.
// Camera   x right, y down, z forward: ours. R takes world to camera, t is the centre.
// Lens     Brown's with OpenCV's order and signs: x (1 + R1 r2 + R2 r4 + R3 r6) + 2 T1 x y + T2 (r2 + 2 x x). Fisheyes
//          have but t and R here, as the readers of Parrot Sequoia's files show; their polynomial with even powers of
//          the angle is none of ours.
// World    PREFIX_wkt.prj less PREFIX_offset.xyz. Pix4Dmapper writes meshes in these coordinates, too, unless told not.
#include <algorithm>
#include <array>
#include <cmath>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

constexpr std::string_view kPix4dFirstLine = "fileName imageWidth imageHeight";

class Pix4dReader {
 public:
  Pix4dReader(const fs::path& file, std::string_view text) : file_(file), text_(text) { scene_.listing = file; }

  SceneFile read() {
    if (line() != kPix4dFirstLine) fail("expected '" + std::string(kPix4dFirstLine) + "'");
    while (!line().starts_with("camera model"))
      if (text_.empty()) fail("the lines before the first camera do not end with its 'camera model'");
    if (line().empty()) fail("ends before its first camera");
    for (; !current_.empty(); line()) read_camera();
    omitted_.report(scene_);
    return std::move(scene_);
  }

 private:
  /// The next line with something in it, which `current_` holds from then on; empty at the end.
  std::string_view line() {
    current_ = {};
    while (current_.empty() && !text_.empty()) {
      current_ = trimmed(next_line(text_));
      ++line_;
    }
    return current_;
  }
  std::string place() const { return "line " + std::to_string(line_); }
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file_, place(), reason); }

  std::vector<double> row(std::size_t count, const char* what) {
    std::string_view rest = line();
    std::vector<double> values;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
      values.push_back(number_from(word).value_or(NAN));
    bool fits = values.size() == count;
    for (const double value : values) fits = fits && std::isfinite(value);
    if (!fits) fail("expected " + std::to_string(count) + " numbers: " + what);
    return values;
  }

  /// Removes and returns the last word of `text`.
  static std::string_view last_word(std::string_view& text) {
    const std::size_t begin = text.find_last_of(" \t") + 1;  // 0 where there is none
    const std::string_view word = text.substr(begin);
    text = trimmed(text.substr(0, begin));
    return word;
  }

  void read_camera() {
    std::string_view name = current_;  // may have blanks
    const auto height = number_from(last_word(name)), width = number_from(last_word(name));
    const auto w = image_side(width.value_or(NAN)), h = image_side(height.value_or(NAN));
    if (!w || !h || name.empty()) fail("expected the name of a photo, its width and its height");
    View view;
    view.name = stated_photo_name(file_, place(), with_slashes(name));
    view.camera.width = *w;
    view.camera.height = *h;
    const std::string at = place() + ", " + quote(name);

    const char* const kFirst = "a row of the camera matrix";
    const std::vector<double> a = row(3, kFirst), b = row(3, kFirst), c = row(3, kFirst), d = row(3, "the lens");
    if (rotation_near({b[0], b[1], b[2], c[0], c[1], c[2], d[0], d[1], d[2]})) {
      omitted_.add("fisheye", InputError(file_, at, "has no camera matrix: photos of fisheye lenses are not read"));
      return;
    }
    const std::vector<double> tangential = row(2, "the tangential distortion");
    view.camera.fx = a[0];
    view.camera.cx = a[2];
    view.camera.fy = b[1];
    view.camera.cy = b[2];
    if (a[1] != 0 || b[0] != 0 || c[0] != 0 || c[1] != 0 || c[2] != 1)
      throw InputError(file_, at, "the camera matrix is not fx 0 cx, 0 fy cy, 0 0 1");
    Distortion& lens = view.camera.distortion;
    lens.k1 = d[0];
    lens.k2 = d[1];
    lens.k3 = d[2];
    lens.p1 = tangential[0];
    lens.p2 = tangential[1];
    finish_camera(file_, at, view.camera);

    const std::vector<double> t = row(3, "the camera position");
    Matrix3 r{};
    for (std::size_t i = 0; i < 9; i += 3) {
      const std::vector<double> values = row(3, "a row of the camera rotation");
      std::copy(values.begin(), values.end(), r.begin() + static_cast<std::ptrdiff_t>(i));
    }
    const auto rotation = rotation_near(r);
    if (!rotation) throw InputError(file_, at, "the camera rotation is none");
    view.pose = finish_pose(file_, at, *rotation, {t[0], t[1], t[2]});
    scene_.views.push_back(std::move(view));
  }

  const fs::path& file_;
  std::string_view text_, current_;
  std::size_t line_ = 0;
  SceneFile scene_;
  OmittedLenses omitted_;
};

bool is_pix4d(const fs::path& file) {
  return lower_case(file.extension().string()) == ".txt" &&
         first_bytes(file, kPix4dFirstLine.size()) == kPix4dFirstLine;
}

std::optional<fs::path> find_pix4d(const fs::path& source) {
  for (const char* below : {"", "params", "1_initial/params"})
    if (const auto found = find_file(*below == '\0' ? source : source / below, ".txt", is_pix4d)) return found;
  return std::nullopt;
}

SceneFile parse_pix4d(const fs::path& file, std::string_view text) { return Pix4dReader(file, text).read(); }

/// What the files beside it say of the world.
void read_pix4d_world(const fs::path& prefix, SceneFile& scene) {
  const fs::path offset = prefix.string() + "offset.xyz", definition = prefix.string() + "wkt.prj";
  std::string srs;
  if (is_file(definition)) {
    srs = reference_system(FileBytes(definition).view());
    scene.files.push_back(definition);
  }
  if (!is_file(offset)) {
    if (!srs.empty())
      scene.warnings.push_back("the positions are in a reference system less an offset, which is not known: " +
                               offset.string() + " is missing");
    return;
  }
  const FileBytes bytes(offset);
  scene.files.push_back(offset);
  std::string_view text = bytes.view();
  std::array<double, 3> o{};
  for (double& value : o) {
    value = number_from(next_word(text)).value_or(NAN);
    if (!std::isfinite(value)) throw InputError(offset, "", "expected three numbers");
  }
  scene.offset = {o[0], o[1], o[2]};
  scene.srs = srs;
  if (scene.offset == WorldPoint{}) return;
  SceneFrame whole;
  whole.name = "the coordinates with the offset of " + offset.filename().string();
  whole.origin = {-o[0], -o[1], -o[2]};
  whole.srs = srs;
  scene.other_frames = {whole};
}

SceneFile read_pix4d(const fs::path& found) {
  SceneFile scene = parse_pix4d(found, FileBytes(found).view());
  scene.files = {found};
  constexpr std::string_view kSuffix = "calibrated_camera_parameters.txt";
  const std::string path = found.string();
  if (path.ends_with(kSuffix)) read_pix4d_world(path.substr(0, path.size() - kSuffix.size()), scene);
  // Photos are not part of the project. Not its folder, though: it has undistorted ones of the same names.
  const fs::path folder = folder_of(found);
  scene.image_folders = {folder / "images", folder / "../../images", folder / "../../../images", folder};
  return scene;
}

}  // namespace

extern const SceneFormat kPix4d{
    "Pix4D",
    "a Pix4Dmapper *_calibrated_camera_parameters.txt (or a folder with it, or with 1_initial/params/ in it)",
    find_pix4d,
    parse_pix4d,
    {},
    read_pix4d};

}  // namespace gpvc::io
