// Cameras as the Multi-View Environment (github.com/simonfuhrmann/mve) describes them: CameraInfo in its libs/mve/camera.h, and
// image_undistort_* in image_tools.h, which define what the numbers mean. Its scenes and mvs-texturing's .cam files have them.
//
// Pixels   the calibration's upper left pixel centre is (0.5, 0.5): ours. f is divided by the longer side (by the
//          pixel's aspect, paspect, in portrait), ppx and ppy by width and height.
// Camera   x right, y down, z forward: ours. Pose: x_camera = R x_world + t.
// Lens     about the photo's middle, on the plane of focal length 1: d0 and d1 as k1 and k2; d0 alone is
//          VisualSFM's, which works from the photo to the plane.
#pragma once

#include <array>
#include <string>

#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// f d0 d1 paspect ppx ppy.
using MveIntrinsics = std::array<double, 6>;
inline constexpr MveIntrinsics kMveIntrinsics{0, 0, 0, 1, 0.5, 0.5};  ///< where nothing is said

/// A camera of width 0, for size_mve_camera(). Throws InputError at `place`.
Camera mve_camera(const fs::path& file, const std::string& place, const MveIntrinsics& in);
/// As SceneFile::size_camera.
void size_mve_camera(Camera& camera, int width, int height);

/// \param t, m finite: t as x y z, m row-major. Throws InputError at `place`.
Pose mve_pose(const fs::path& file, const std::string& place, const WorldPoint& t, const Matrix3& m);

}  // namespace gpvc::io
