// Bundler's bundle file, .out, which VisualSFM, COLMAP and OpenMVG write as well: "Output format and scene
// representation" of Bundler's manual, v0.3 (github.com/snavely/bundler_sfm); COLMAP's ExportBundler.
//
//   # Bundle file v0.3
//   CAMERAS POINTS
//   f k1 k2, R00 .. R22, tx ty tz a camera, in the order of the list of images; all 0 where one has no pose
//
// Pixels   the origin is the middle of the photo, x right, y up: (w / 2, h / 2) in ours.
// Camera   x right, y up, z back: y and z are turned. x_camera = R x_world + t.
// Lens     k1 and k2 as Distortion has them.
// List     a name a line, as Bundler writes it followed by "0 f". It is called as the bundle file with "list" for
//          "bundle" (list.txt, list.rd.txt, NAME.list.txt; OpenSfM's list_r000.out), or list.txt, beside it or a folder
//          above. Without one the photos are 00000000 to N, as in PMVS's folder visualize/.
#include <array>
#include <cmath>
#include <cstdio>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

void put_principal_point_in_middle(Camera& camera, int width, int height) {
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
}

bool is_bundle(const fs::path& file) {
  return lower_case(file.extension().string()) == ".out" && first_bytes(file, 13) == "# Bundle file";
}

/// Names of the images, a line each.
std::vector<std::string> names_in(const fs::path& list, std::string_view text) {
  std::vector<std::string> names;
  for (int line = 1; !text.empty(); ++line) {
    std::string_view name = trimmed(next_line(text));
    if (name.empty()) continue;
    const std::size_t last = name.find_last_of(" \t");
    if (last != name.npos && number_from(name.substr(last + 1))) {
      const std::string_view before = trimmed(name.substr(0, last));
      if (before.ends_with(" 0")) name = trimmed(before.substr(0, before.size() - 2));
    }
    names.push_back(stated_photo_name(list, "line " + std::to_string(line), with_slashes(name)));
  }
  return names;
}

class BundleReader {
 public:
  BundleReader(const fs::path& file, std::string_view text) : file_(file), text_(text) {}

  /// Cameras take their names from `names`, if it is given, by their number in the file.
  SceneFile read(const fs::path& list, const std::vector<std::string>* names) {
    SceneFile scene;
    scene.listing = file_;
    scene.size_camera = put_principal_point_in_middle;
    if (trimmed(next_line(text_)) != "# Bundle file v0.3")
      throw InputError(file_, "line 1", "expected '# Bundle file v0.3'");
    const double count = number("the number of cameras");
    number("the number of points");
    if (!(count >= 0 && count <= 1e9 && count == std::floor(count)))
      throw InputError(file_, "line 2", "expected a number of cameras");
    if (names != nullptr && static_cast<double>(names->size()) != count)
      throw InputError(list, "",
                       "names " + std::to_string(names->size()) + " images, but " + file_.filename().string() +
                           " has " + std::to_string(static_cast<long>(count)) + " cameras");
    std::size_t unposed = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      if (std::optional<View> view = read_camera(i)) {
        if (names != nullptr) view->photo = view->name = (*names)[i];
        scene.views.push_back(std::move(*view));
      } else {
        ++unposed;
      }
    scene.warn(unposed, "images without a pose are left out");
    return scene;
  }

 private:
  double number(const std::string& what) {
    const std::string_view word = next_word(text_);
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value))
      throw InputError(file_, what, word.empty() ? "ends early" : "expected a number, found " + quote(word));
    return *value;
  }

  std::optional<View> read_camera(std::size_t i) {
    const std::string place = "camera " + std::to_string(i);
    std::array<double, 15> v{};
    for (double& value : v) value = number(place);
    if (v[0] == 0) return std::nullopt;
    View view;
    std::array<char, 24> name{};
    std::snprintf(name.data(), name.size(), "%08zu", i);
    view.name = name.data();
    view.camera = {0, 0, v[0], v[0], 0, 0, {}};
    view.camera.distortion.k1 = v[1];
    view.camera.distortion.k2 = v[2];
    finish_camera(file_, place, view.camera);
    const auto rotation = rotation_near({v[3], v[4], v[5], -v[6], -v[7], -v[8], -v[9], -v[10], -v[11]});
    if (!rotation) throw InputError(file_, place, "its matrix is no rotation");
    view.pose = finish_pose_from_translation(file_, place, *rotation, {v[12], -v[13], -v[14]});
    return view;
  }

  const fs::path& file_;
  std::string_view text_;
};

std::optional<fs::path> find_bundle(const fs::path& source) {
  // Bundler leaves one file a step, bundle_001.out and so on, beside the final one.
  for (const char* below : {"bundle.out", "bundle/bundle.out"})
    if (is_bundle(source / below)) return source / below;
  return find_file(source, ".out", is_bundle);
}

std::optional<fs::path> find_list(const fs::path& bundle) {
  const fs::path folder = folder_of(bundle);
  std::string name = bundle.stem().string();
  if (const std::size_t at = name.rfind("bundle"); at != name.npos) name.replace(at, 6, "list");
  for (const fs::path& list :
       {folder / (name + ".txt"), folder / (name + ".out"), folder / "list.txt", folder / ".." / "list.txt"})
    if (list.filename() != bundle.filename() && is_file(list)) return list;
  return std::nullopt;
}

SceneFile parse_bundle(const fs::path& file, std::string_view text) {
  return BundleReader(file, text).read({}, nullptr);
}

SceneFile read_bundle(const fs::path& file) {
  const FileBytes bytes(file);
  const fs::path folder = folder_of(file);
  const std::optional<fs::path> list = find_list(file);
  SceneFile scene;
  if (list) {
    const std::vector<std::string> names = names_in(*list, FileBytes(*list).view());
    scene = BundleReader(file, bytes.view()).read(*list, &names);
    scene.listing = *list;
    scene.image_folders = {folder_of(*list) / "images"};
  } else {
    scene = parse_bundle(file, bytes.view());
    scene.warnings.push_back(
        "the list of images is missing: they are taken for 00000000 and so on, as PMVS names them");
  }
  scene.files = {file};
  if (list) scene.files.push_back(*list);
  scene.image_folders.insert(scene.image_folders.end(),
                             {folder / "images", folder / "visualize", folder, folder / ".." / "images"});
  return scene;
}

}  // namespace

extern const SceneFormat kBundler{"Bundler",   "a Bundler file, .out, with its list.txt (or a folder with them)",
                                  find_bundle, parse_bundle,
                                  {},          read_bundle};

}  // namespace gpvc::io
