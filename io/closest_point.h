// The point of a segment or a face that is nearest to a place.
#pragma once

#include <algorithm>

#include "vector.h"

namespace gpvc {

/// Of the segment from a to b.
inline WorldPoint closest_on_segment(const WorldPoint& p, const WorldPoint& a, const WorldPoint& b) {
  const WorldPoint along = b - a;
  const double squared = dot(along, along);
  const double t = squared > 0 ? std::clamp(dot(p - a, along) / squared, 0.0, 1.0) : 0;
  return a + t * along;
}

/// Of the triangle a, b, c, which may be degenerate.
inline WorldPoint closest_on_face(const WorldPoint& p, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const WorldPoint normal = cross(b - a, c - a);
  const double squared = dot(normal, normal);
  const auto is_left_of = [&](const WorldPoint& from, const WorldPoint& to) {
    return dot(cross(to - from, p - from), normal) >= 0;
  };
  if (squared > 0 && is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a))
    return p - normal * (dot(p - a, normal) / squared);
  WorldPoint nearest = closest_on_segment(p, a, b);
  for (const WorldPoint& q : {closest_on_segment(p, b, c), closest_on_segment(p, c, a)})
    if (dot(p - q, p - q) < dot(p - nearest, p - nearest)) nearest = q;
  return nearest;
}

}  // namespace gpvc
