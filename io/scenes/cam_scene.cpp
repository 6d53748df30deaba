// mvs-texturing's folder of photos with a NAME.cam beside each: the help of its texrecon, its
// generate_texture_views.cpp and texture_view.cpp. mve_camera.h says what the numbers mean.
//
//   tx ty tz R00 R01 R02 R10 R11 R12 R20 R21 R22
//   f d0 d1 paspect ppx ppy
#include <algorithm>
#include <cmath>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/mve_camera.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

bool is_cam(const fs::path& file) {
  const std::string name = lower_case(file.filename().string());
  return name.ends_with(".cam") && !name.ends_with("calibrated_internal_camera_parameters.cam");  // which is Pix4D's
}

/// Numbers of one line, all of them finite.
std::vector<double> numbers_of_line(const fs::path& file, std::string_view line, const char* place, std::size_t least,
                                    std::size_t most) {
  std::vector<double> values;
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value)) throw InputError(file, place, "expected a number, found " + quote(word));
    values.push_back(*value);
    if (values.size() > most) break;
  }
  if (values.size() < least || values.size() > most)
    throw InputError(file, place,
                     "expected " + std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) +
                         " numbers" + (most == 12 ? ", tx ty tz R00 .. R22" : ", f d0 d1 paspect ppx ppy"));
  return values;
}

SceneFile parse_cam(const fs::path& file, std::string_view text) {
  SceneFile scene;
  scene.listing = file;
  scene.size_camera = size_mve_camera;
  const std::vector<double> out = numbers_of_line(file, next_line(text), "line 1", 12, 12);
  const std::vector<double> in = numbers_of_line(file, next_line(text), "line 2", 1, 6);
  MveIntrinsics intrinsics = kMveIntrinsics;
  std::ranges::copy(in, intrinsics.begin());

  View view;
  view.name = file.stem().string();
  view.camera = mve_camera(file, "line 2", intrinsics);
  view.pose = mve_pose(file, "line 1", {out[0], out[1], out[2]},
                       {out[3], out[4], out[5], out[6], out[7], out[8], out[9], out[10], out[11]});
  scene.views.push_back(std::move(view));
  return scene;
}

/// A folder with a camera file that has a photo beside it, or one of its camera files.
std::optional<fs::path> find_cam_folder(const fs::path& source) { return find_folder(source, is_cam); }

SceneFile read_cam_folder(const fs::path& folder) {
  SceneFile scene;
  scene.listing = folder / "*.cam";
  scene.size_camera = size_mve_camera;
  scene.image_folders = {folder};
  for (const Sidecar& sidecar : sidecars_in(folder, ".cam")) {
    const FileBytes bytes(sidecar.file);
    scene.views.push_back(std::move(parse_cam(sidecar.file, bytes.view()).views.front()));
    scene.views.back().name = sidecar.photo;
    scene.views.back().number = static_cast<std::uint32_t>(scene.views.size() - 1);
    scene.files.push_back(sidecar.file);
  }
  return scene;
}

}  // namespace

extern const SceneFormat kCam{
    "mvs-texturing", "an mvs-texturing folder of photos with .cam files", find_cam_folder, parse_cam, {},
    read_cam_folder};

}  // namespace gpvc::io
