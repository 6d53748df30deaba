// Views of equirectangular panoramas: see is_spherical() in scene.h.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "io/scene.h"

namespace gpvc::io {

/// Squared radius of the plane up to which such a view sees: 56 degrees. A corner of the cube lies at 54.7, and a mesh's
/// face that crosses an edge of the cube lies whole in one of the two views unless it is larger than 11 degrees. It fits
/// into a frame as high as the panorama, whose half reaches to pi / 2.
inline constexpr double kSphericalReach2 = 1.5 * 1.5;

/// Columns that continue_around() adds on the left and on the right of a panorama. The view to the back is centred on its
/// right edge.
constexpr int columns_before(int panorama_width) { return panorama_width / 16; }
constexpr int columns_behind(int panorama_width) { return 3 * panorama_width / 16; }

/// Width of the photo's file, reduced as the camera is: that of the camera unless it is a panorama's.
inline int file_width(const Camera& camera) {
  if (!is_spherical(camera.distortion.model)) return camera.width;
  return static_cast<int>(std::lround(2 * std::numbers::pi * camera.fx));
}

/// A point of the plane: (X / Z, Y / Z), or (x', y') in its place.
struct PlanePoint {
  double x, y;
};

/// (x', y') of a point of the plane.
PlanePoint sphere_from_plane(LensModel model, double x, double y);

/// The inverse; nullopt for directions at and behind 90 degrees, and for longitudes beyond those that
/// sphere_from_plane() gives.
std::optional<PlanePoint> plane_from_sphere(LensModel model, double longitude, double latitude);

}  // namespace gpvc::io
