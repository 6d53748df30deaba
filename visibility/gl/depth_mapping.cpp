// Window depth under both projections.
#include <algorithm>
#include <cmath>

#include "visibility/gl/ivm_gl.h"

namespace gpvc::visibility {
namespace {

/// Least and greatest depth of a bounding box along the view direction.
struct Range {
  double low = 0, high = 0;
};

Range depths_of(const Box& box, const Pose& pose) {
  const auto& r = pose.rotation;
  const auto along = [](double axis, double low, double high) {
    return Range{std::min(axis * low, axis * high), std::max(axis * low, axis * high)};
  };
  const Range x = along(r[6], box.low.x - pose.centre.x, box.high.x - pose.centre.x);
  const Range y = along(r[7], box.low.y - pose.centre.y, box.high.y - pose.centre.y);
  const Range z = along(r[8], box.low.z - pose.centre.z, box.high.z - pose.centre.z);
  return {x.low + y.low + z.low, x.high + y.high + z.high};
}

}  // namespace

Box box_around(const Mesh& mesh) { return mesh.positions.empty() ? Box{{}, {}} : box_of(mesh); }

DepthMapping depth_mapping(Projection projection, double near, const Box& box, const Pose& pose) {
  if (projection == Projection::apc) return {projection, {0, near}};
  const Range depths = depths_of(box, pose);
  if (!(depths.high > 0)) return {projection, {2, -2}};  // nothing lies in front of the camera: planes at 1 and 2
  // Clip coordinates are floats: z and w have relative errors of 2^-24, so a vertex in the near plane is not clipped once
  // the plane is moved by 2^-20 of its distance. At the far plane z - w is smaller by the ratio of the planes' distances,
  // so the margin is larger by that ratio.
  constexpr double kMargin = 0x1p-20, kNearest = 0x1p-14;
  const double n = std::max(depths.low, depths.high * kNearest) * (1 - kMargin);
  const double f = depths.high * (1 + kMargin * depths.high / n);
  return {projection, {f / (f - n), -f * n / (f - n)}};
}

}  // namespace gpvc::visibility
