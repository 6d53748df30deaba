// The little vector algebra that charts and baking need on points of scene.h.
#pragma once

#include <array>
#include <cmath>

#include "io/scene.h"

namespace gpvc::atlas {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};

inline Vector3 operator-(const WorldPoint& a, const WorldPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector3 operator+(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector3 operator-(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector3 operator*(double s, const Vector3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double norm(const Vector3& a) { return std::sqrt(dot(a, a)); }
inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// rotation * v, camera axes from world axes.
inline Vector3 rotate(const std::array<double, 9>& r, const Vector3& v) {
  return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
          r[6] * v.x + r[7] * v.y + r[8] * v.z};
}

/// Its inverse, world axes from camera axes.
inline Vector3 rotate_back(const std::array<double, 9>& r, const Vector3& v) {
  return {r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
          r[2] * v.x + r[5] * v.y + r[8] * v.z};
}

/// Direction, in world axes, of the ray through a frame position; its depth component is 1.
inline Vector3 ray_direction(const View& view, const PixelPoint& p) {
  const Camera& c = view.camera;
  return rotate_back(view.pose.rotation, {(p.x - c.cx) / c.fx, (p.y - c.cy) / c.fy, 1});
}

}  // namespace gpvc::atlas
