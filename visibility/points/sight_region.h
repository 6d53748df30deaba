// The places from which something may stand between a camera and what it looks at. Conservative: what misses a region by less
// than a billionth of the distance counts as meeting it. Positions in the frame are rounded by some 1e-11 px, far less than a
// billionth of a radian for any focal length above a pixel's hundredth.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "io/box.h"
#include "io/vector.h"

namespace gpvc::visibility {

inline constexpr double kSightSlack = 1e-9;

inline Box box_of(const std::array<WorldPoint, 3>& corners) {
  Box box;
  for (const WorldPoint& p : corners) box.add(p);
  return box;
}

/// The segment from a camera to a point.
class SightLine {
 public:
  SightLine(const WorldPoint& camera, const WorldPoint& point)
      : camera_(camera), way_(point - camera), slack_(kSightSlack * length(way_)) {}

  bool misses(const Box& box) const {
    double from = -kSightSlack, to = 1 + kSightSlack;  // along the way
    const auto clip = [&](double start, double step, double low, double high) {
      low -= slack_ + start;
      high += slack_ - start;
      if (step == 0) return low <= 0 && high >= 0;
      const double a = low / step, b = high / step;
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
      return from <= to;
    };
    return !(clip(camera_.x, way_.x, box.low.x, box.high.x) && clip(camera_.y, way_.y, box.low.y, box.high.y) &&
             clip(camera_.z, way_.z, box.low.z, box.high.z));
  }
  bool misses(const std::array<WorldPoint, 3>& corners) const { return misses(box_of(corners)); }

 private:
  WorldPoint camera_, way_;
  double slack_;
};

/// What lies between a camera and a face.
class SightPyramid {
 public:
  SightPyramid(const WorldPoint& camera, const std::array<WorldPoint, 3>& face) {
    const WorldPoint a = face[0] - camera, b = face[1] - camera, c = face[2] - camera;
    slack_ = kSightSlack * std::max({length(a), length(b), length(c)});
    planes_ = {through(camera, cross(a, b), c), through(camera, cross(b, c), a), through(camera, cross(c, a), b),
               through(face[0], cross(b - a, c - a), a * -1.0)};
  }

  bool misses(const Box& box) const {
    return std::ranges::any_of(planes_, [&](const Plane& plane) {
      const WorldPoint farthest{plane.inwards.x > 0 ? box.high.x : box.low.x,
                                plane.inwards.y > 0 ? box.high.y : box.low.y,
                                plane.inwards.z > 0 ? box.high.z : box.low.z};
      return dot(farthest - plane.at, plane.inwards) < -slack_;
    });
  }
  bool misses(const std::array<WorldPoint, 3>& corners) const {
    return std::ranges::any_of(planes_, [&](const Plane& plane) {
      return std::ranges::all_of(corners,
                                 [&](const WorldPoint& p) { return dot(p - plane.at, plane.inwards) < -slack_; });
    });
  }

 private:
  struct Plane {
    WorldPoint at, inwards;  ///< of length 1, or 0 where the face is too thin to have one
  };
  static Plane through(const WorldPoint& at, const WorldPoint& normal, const WorldPoint& inside) {
    return {at, unit(dot(normal, inside) < 0 ? normal * -1.0 : normal)};
  }

  std::array<Plane, 4> planes_;
  double slack_ = 0;
};

}  // namespace gpvc::visibility
