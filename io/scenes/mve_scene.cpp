// A scene of the Multi-View Environment: "MVE File Formats" of github.com/simonfuhrmann/mve/wiki, and libs/mve/view.h.
//
//   DIR/views/ANY.mve/meta.ini     [view] id, name; [camera] focal_length, radial_distortion, pixel_aspect, principal_point,
//                                  rotation, translation, as in mve_camera.h
//   DIR/views/ANY.mve/NAME.EXT     a picture of the view, its embedding NAME: 'original' as taken, 'undistorted', 'undist-L1' (half
//                                  as large) ... with the lens taken out
//
// A source is DIR or DIR::NAME, as the programs of the Multi-View Environment take it. A view whose focal length is 0 or that has
// no camera was not placed.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/images.h"
#include "io/scenes/mve_camera.h"

namespace gpvc::io {

namespace {

/// The folder of a scene and the embedding that is asked for; empty: none.
struct MveSource {
  fs::path folder;
  std::string embedding;
};

MveSource mve_source(const fs::path& source) {
  const std::string text = source.string();
  const std::size_t at = text.rfind("::");
  if (at == std::string::npos) return {source, {}};
  return {text.substr(0, at), text.substr(at + 2)};
}

/// The views' folders, by name.
std::vector<fs::path> view_folders(const fs::path& scene) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(scene / "views", ignored))
    if (lower_case(entry.path().extension().string()) == ".mve" && is_file(entry.path() / "meta.ini"))
      folders.push_back(entry.path());
  std::ranges::sort(folders);
  return folders;
}

/// The picture of an embedding; empty where there is none.
fs::path picture_in(const fs::path& view, const std::string& embedding) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(view, ignored))
    if (entry.path().stem() == embedding && has_image_extension(entry.path())) found.push_back(entry.path());
  return found.empty() ? fs::path() : *std::ranges::min_element(found);
}

/// "SECTION.KEY" and values of an INI file.
using Values = std::map<std::string, std::string>;

Values read_ini(const fs::path& file) {
  const FileBytes bytes(file);
  std::string_view text = without_byte_order_mark(bytes.view());
  Values values;
  std::string section;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = trimmed(next_line(text));
    if (line.empty() || line.front() == '#' || line.front() == ';') continue;
    if (line.front() == '[' && line.back() == ']') {
      section = trimmed(line.substr(1, line.size() - 2));
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos)
      throw InputError(file, "line " + std::to_string(number),
                       "expected [SECTION] or KEY = VALUE, found " + quote(line));
    values[section + "." + std::string(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
  }
  return values;
}

/// The finite numbers of a value; none where it is missing. Throws InputError unless there are `count`.
std::vector<double> numbers_of(const fs::path& file, const Values& values, const std::string& key, std::size_t count) {
  const auto found = values.find(key);
  if (found == values.end()) return {};
  std::vector<double> numbers;
  std::string_view text = found->second;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value)) throw InputError(file, key, "expected a number, found " + quote(word));
    numbers.push_back(*value);
  }
  if (numbers.size() != count)
    throw InputError(file, key, "expected " + std::to_string(count) + (count == 1 ? " number" : " numbers"));
  return numbers;
}

/// A view that has been placed, without its photo; nullopt for another.
std::optional<View> read_view(const fs::path& file, bool as_taken) {
  const Values values = read_ini(file);
  const std::vector<double> focal = numbers_of(file, values, "camera.focal_length", 1);
  if (focal.empty() || focal[0] == 0) return std::nullopt;
  const std::vector<double> t = numbers_of(file, values, "camera.translation", 3),
                            m = numbers_of(file, values, "camera.rotation", 9);
  if (t.empty() || m.empty())
    throw InputError(file, t.empty() ? "camera.translation" : "camera.rotation",
                     "is missing: the camera has a focal length");
  MveIntrinsics in = kMveIntrinsics;
  in[0] = focal[0];
  if (as_taken) std::ranges::copy(numbers_of(file, values, "camera.radial_distortion", 2), in.begin() + 1);
  std::ranges::copy(numbers_of(file, values, "camera.pixel_aspect", 1), in.begin() + 3);
  std::ranges::copy(numbers_of(file, values, "camera.principal_point", 2), in.begin() + 4);
  View view;
  view.camera = mve_camera(file, "camera", in);
  view.pose = mve_pose(file, "camera", {t[0], t[1], t[2]}, {m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]});
  const std::vector<double> id = numbers_of(file, values, "view.id", 1);
  if (!id.empty()) view.number = static_cast<std::uint32_t>(std::clamp(id[0], 0.0, 4294967295.0));
  return view;
}

std::optional<fs::path> find_mve(const fs::path& source) {
  const MveSource asked = mve_source(source);
  if (is_folder(source) && !view_folders(source).empty()) return source;
  if (!asked.embedding.empty() && !view_folders(asked.folder).empty()) return source;
  return std::nullopt;
}

/// What `source` asks for, else the picture with the lens taken out at full size, else the one as taken.
std::string embedding_of(const MveSource& source, const std::vector<fs::path>& views) {
  if (!source.embedding.empty()) return source.embedding;
  for (const char* usual : {"undistorted", "undist-L0", "original"})
    if (std::ranges::any_of(views, [&](const fs::path& view) { return !picture_in(view, usual).empty(); }))
      return usual;
  return "undistorted";
}

SceneFile read_mve(const fs::path& found) {
  MveSource source = mve_source(found);
  if (is_folder(found)) source = {found, {}};
  const std::vector<fs::path> folders = view_folders(source.folder);
  const std::string embedding = embedding_of(source, folders);
  SceneFile scene;
  scene.listing = source.folder / "views";
  scene.size_camera = size_mve_camera;
  scene.image_folders = {source.folder};
  std::size_t without_picture = 0;
  for (const fs::path& folder : folders) {
    const fs::path file = folder / "meta.ini";
    std::optional<View> view = read_view(file, embedding == "original");
    if (!view) continue;
    const fs::path picture = picture_in(folder, embedding);
    if (picture.empty()) {
      ++without_picture;
      continue;
    }
    view->name = (folder.filename() / picture.filename()).string();
    view->photo = ("views" / folder.filename() / picture.filename()).string();
    scene.files.push_back(file);
    scene.views.push_back(std::move(*view));
  }
  if (scene.views.empty() && without_picture > 0) {
    std::set<std::string> there;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folders.front(), ignored))
      if (has_image_extension(entry.path())) there.insert(entry.path().stem().string());
    std::string names;
    for (const std::string& name : there) names += (names.empty() ? "" : ", ") + name;
    throw InputError(source.folder, "",
                     "no view has a picture " + quote(embedding) +
                         (names.empty() ? "" : "; " + folders.front().filename().string() + " has " + names));
  }
  scene.warn(without_picture, "views have no picture " + quote(embedding) + " and are left out");
  return scene;
}

}  // namespace

extern const SceneFormat kMve{
    "MVE",    "a scene of the Multi-View Environment (a folder with views/*.mve, or FOLDER::EMBEDDING)",
    find_mve, nullptr,
    {},       read_mve};

}  // namespace gpvc::io
