// Arithmetic on points and directions of the world and of a camera.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "scene.h"

namespace gpvc {

inline WorldPoint operator+(const WorldPoint& a, const WorldPoint& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline WorldPoint operator-(const WorldPoint& a, const WorldPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline WorldPoint operator*(const WorldPoint& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline WorldPoint operator*(double s, const WorldPoint& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const WorldPoint& a, const WorldPoint& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline WorldPoint cross(const WorldPoint& a, const WorldPoint& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const WorldPoint& a) { return std::sqrt(dot(a, a)); }
/// Scaled to length 1; a vector of length 0 stays as it is.
inline WorldPoint unit(const WorldPoint& a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : a;
}

/// Equal for equal points, such as those with 0 and with -0.
inline std::uint64_t position_hash(const WorldPoint& p) {
  // The finalizer of splitmix64 (Steele, Lea, Flood 2014).
  const auto mixed = [](std::uint64_t word) {
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9U;
    word = (word ^ (word >> 27)) * 0x94D049BB133111EBU;
    return word ^ (word >> 31);
  };
  // The sum makes -0 and 0 the same bits.
  const auto bits = [](double coordinate) { return std::bit_cast<std::uint64_t>(coordinate + 0.0); };
  return mixed(bits(p.x) + mixed(bits(p.y) + mixed(bits(p.z))));
}

/// rotation * v: a direction in camera axes from one in world axes.
inline CameraPoint to_camera_axes(const Pose& pose, const WorldPoint& v) {
  const auto& r = pose.rotation;
  return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
          r[6] * v.x + r[7] * v.y + r[8] * v.z};
}

/// Its inverse: a direction in world axes from one in camera axes.
inline WorldPoint to_world_axes(const Pose& pose, const CameraPoint& v) {
  const auto& r = pose.rotation;
  return {r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
          r[2] * v.x + r[5] * v.y + r[8] * v.z};
}

/// World direction of the ray from the camera's centre through a position of the undistorted frame; its depth is 1.
inline WorldPoint ray_of(const View& view, const PixelPoint& p) {
  const Camera& c = view.camera;
  return to_world_axes(view.pose, {(p.x - c.cx) / c.fx, (p.y - c.cy) / c.fy, 1});
}

}  // namespace gpvc
