// The camera model that RealityCapture (RealityScan since 2025) writes into all its files: "Frontal Pinhole Camera" and
// "Lens Distortion" of Epic's "On the Coordinate Systems Employed in the Import, Estimation, and Export of Camera
// Geometry by RealityScan" (linked from "Camera Geometry in RealityScan", dev.epicgames.com).
//
// Pixels   lengths in units of the photo's longer side, about the photo's middle: u = s x + w / 2, s = max(w, h). The
//          focal length is stated as that of a longer side of 36 mm.
// Lens     Brown's on the plane of focal length 1: x' = x (1 + k1 r2 + k2 r4 + k3 r6 + k4 r8) + t1 (r2 + 2 x x) +
//          2 t2 x y, so t1 is OpenCV's p2 and t2 its p1. (The document's equation for y' repeats that for x'; its text
//          and RealityCapture's export for OpenCV name the swap, and Fraunhofer's camorph and AliceVision read it so.)
// Division is not read: the document has x' = x / (1 + k1 r2), which bends outwards for k1 < 0, but the files of wide
//          and fisheye lenses that are known have k1 < 0, as x = x' / (1 + k1 r'2) has it.
#pragma once

#include <optional>
#include <string>

#include "io/scenes/scene_file.h"

namespace gpvc::io {

struct RealityCamera {
  double focal_35mm = 0;                 ///< of a photo whose longer side is 36 mm
  double px = 0, py = 0;                 ///< principal point, from the photo's middle, in units of its longer side
  std::array<double, 6> coefficients{};  ///< k1 k2 k3 k4 t1 t2 of Brown's model
};

/// Without a size, in units of the longer side: for size_reality_camera. Not finished.
Camera camera_from(const RealityCamera& reality);

/// SceneFile::size_camera of these cameras.
void size_reality_camera(Camera& camera, int width, int height);

/// k1 .. k4 t1 t2 as terms of Brown's model.
void set_brown_terms(const std::array<double, 6>& coefficients, Camera& camera);

inline constexpr const char* kNoDivision =
    "the lens model Division is not supported, Brown's models are; align with the distortion model Brown3, or export "
    "undistorted photos";

}  // namespace gpvc::io
