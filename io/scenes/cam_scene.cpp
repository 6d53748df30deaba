// mvs-texturing's folder of photos with a NAME.cam beside each: the help of its texrecon, its
// generate_texture_views.cpp and texture_view.cpp, and CameraInfo and image_undistort_* of the Multi-View
// Environment (github.com/simonfuhrmann/mve), which define what the numbers mean.
//
//   tx ty tz R00 R01 R02 R10 R11 R12 R20 R21 R22
//   f d0 d1 paspect ppx ppy
//
// Pixels   the calibration's upper left pixel centre is (0.5, 0.5): ours. f is divided by the longer side (by the
//          pixel's aspect, paspect, in portrait), ppx and ppy by width and height.
// Camera   x right, y down, z forward: ours. Pose: x_camera = R x_world + t.
// Lens     about the photo's middle, on the plane of focal length 1: d0 and d1 as k1 and k2; d0 alone is
//          VisualSFM's, which works from the photo to the plane.
#include <algorithm>
#include <cmath>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
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

/// Until the photo is known: fx = f, fy = f paspect, cx = ppx, cy = ppy.
void scale_by_photo_size(Camera& camera, int width, int height) {
  const double f = camera.fx, aspect = camera.fy / camera.fx;
  const bool portrait = width * aspect < height;
  camera.fx = portrait ? f * height / aspect : f * width;
  camera.fy = portrait ? f * height : f * width * aspect;
  camera.cx *= width;
  camera.cy *= height;
}

SceneFile parse_cam(const fs::path& file, std::string_view text) {
  SceneFile scene;
  scene.listing = file;
  scene.size_camera = scale_by_photo_size;
  const std::vector<double> out = numbers_of_line(file, next_line(text), "line 1", 12, 12);
  std::vector<double> in = numbers_of_line(file, next_line(text), "line 2", 1, 6);
  constexpr std::array<double, 6> kDefaults{0, 0, 0, 1, 0.5, 0.5};
  while (in.size() < 6) in.push_back(kDefaults[in.size()]);

  View view;
  view.name = file.stem().string();
  Camera& camera = view.camera;
  camera.fx = in[0];
  camera.fy = in[0] * in[3];
  camera.cx = in[4];
  camera.cy = in[5];
  if (!(in[3] > 0)) throw InputError(file, "line 2", "the pixel's aspect is not positive");
  if (in[1] != 0) {
    if (in[3] != 1 || in[4] != 0.5 || in[5] != 0.5)
      throw InputError(file, "line 2",
                       "distortion d0 with a pixel aspect other than 1 or a principal point other than 0.5 0.5 is "
                       "not read: it acts about the photo's middle");
    camera.distortion.model = in[2] != 0 ? LensModel::perspective : LensModel::inverse_radial;
    camera.distortion.k1 = in[1];
    camera.distortion.k2 = in[2];
  }
  finish_camera(file, "line 2", camera);

  const auto rotation = rotation_near({out[3], out[4], out[5], out[6], out[7], out[8], out[9], out[10], out[11]});
  if (!rotation) throw InputError(file, "line 1", "the matrix R00 .. R22 is no rotation");
  view.pose = finish_pose_from_translation(file, "line 1", *rotation, {out[0], out[1], out[2]});
  scene.views.push_back(std::move(view));
  return scene;
}

/// A folder with a camera file that has a photo beside it, or one of its camera files.
std::optional<fs::path> find_cam_folder(const fs::path& source) { return find_folder(source, is_cam); }

SceneFile read_cam_folder(const fs::path& folder) {
  SceneFile scene;
  scene.listing = folder / "*.cam";
  scene.size_camera = scale_by_photo_size;
  scene.image_folders = {folder};
  for (const Sidecar& sidecar : sidecars_in(folder, ".cam")) {
    const FileBytes bytes(sidecar.file);
    scene.views.push_back(std::move(parse_cam(sidecar.file, bytes.view()).views.front()));
    scene.views.back().name = sidecar.photo;
    scene.files.push_back(sidecar.file);
  }
  return scene;
}

}  // namespace

extern const SceneFormat kCam{
    "mvs-texturing", "an mvs-texturing folder of photos with .cam files", find_cam_folder, parse_cam, {},
    read_cam_folder};

}  // namespace gpvc::io
