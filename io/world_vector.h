// Arithmetic on points and directions of the world.
#pragma once

#include <cmath>

#include "io/scene.h"

namespace gpvc {

inline WorldPoint operator+(const WorldPoint& a, const WorldPoint& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline WorldPoint operator-(const WorldPoint& a, const WorldPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline WorldPoint operator*(const WorldPoint& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline double dot(const WorldPoint& a, const WorldPoint& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline WorldPoint cross(const WorldPoint& a, const WorldPoint& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const WorldPoint& a) { return std::sqrt(dot(a, a)); }
/// Of length 1; a vector of length 0 stays as it is.
inline WorldPoint unit(const WorldPoint& a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : a;
}

}  // namespace gpvc
