// How finely and how steeply a view looks at a surface.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "../../io/scene.h"
#include "../../io/vector.h"

namespace gpvc::query {

struct Sharpness {
  double distance = 0;  ///< from the camera's centre
  /// Ground sampling distance: the edge of the square on the surface that is as large as what a pixel of the photo as taken shows
  /// there, in units of the scene. Infinite for a surface that is seen from the side.
  double gsd = 0;
  double angle = 0;  ///< between the line of sight and the surface's normal, degrees, 0 to 90
};

/// Of a point of a plane in front of the camera, in the undistorted frame. \param normal of any length; 0: as if faced squarely
inline Sharpness sharpness_of(const View& view, const WorldPoint& point, const WorldPoint& normal) {
  const WorldPoint sight = point - view.pose.centre;
  const double z = camera_from_world(view.pose, point).z, distance = length(sight);
  const double across = length(normal) > 0 ? std::abs(dot(unit(normal), sight)) : distance;
  // Per area of the plane the frame has f_x f_y across / z^3 pixels.
  const double pixels = view.camera.fx * view.camera.fy * across / (z * z * z);
  const double cosine = distance > 0 ? std::min(1.0, across / distance) : 1;
  return {distance, 1 / (std::sqrt(pixels) * view.reduction), std::acos(cosine) * 180 / std::numbers::pi};
}

inline WorldPoint normal_of(const Mesh& mesh, FaceId face) {
  const auto [a, b, c] = mesh.faces[index(face)];
  return cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
}

inline WorldPoint middle_of(const Mesh& mesh, FaceId face) {
  const auto [a, b, c] = mesh.faces[index(face)];
  return (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1.0 / 3);
}

/// Its area, in squared units of the scene.
inline double surface_of(const Mesh& mesh, FaceId face) { return length(normal_of(mesh, face)) / 2; }

}  // namespace gpvc::query
