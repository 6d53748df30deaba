#include "visibility/raster/raster.h"

#include <utility>

namespace gpvc::visibility {
namespace {

constexpr double kDoubleRoundoff = 0x1p-53;

double largest(double a, double b, double c) { return std::max({std::abs(a), std::abs(b), std::abs(c)}); }

/// |coordinates of p x q|, weighted by how far a coordinate of the third vertex can be off, relative to its
/// size.
double cofactors(const ProjectedVertex& p, const ProjectedVertex& q, const ProjectionRounding& rounding) {
  return std::abs(p.v * q.z - p.z * q.v) + std::abs(p.z * q.u - p.u * q.z) +
         std::abs(p.u * q.v - p.v * q.u) * rounding.z_per_u;
}

double size(const ProjectedVertex& p, const ProjectionRounding& rounding) {
  return std::abs(p.u) + std::abs(p.v) + rounding.u_per_z * std::abs(p.z);
}

}  // namespace

ProjectionRounding projection_rounding(const Camera& camera) {
  return {camera.fx + camera.fy + std::abs(camera.cx) + std::abs(camera.cy), 1 / std::min(camera.fx, camera.fy)};
}

RasterFace raster_face(ProjectedVertex first, ProjectedVertex second, ProjectedVertex third,
                       const ProjectionRounding& rounding) {
  // Differences from the nearest vertex are no larger than the other two.
  const auto [a, b, c] = nearest_first(first, second, third);
  const double du1 = b.u - a.u, dv1 = b.v - a.v, dz1 = b.z - a.z;
  const double du2 = c.u - a.u, dv2 = c.v - a.v, dz2 = c.z - a.z;
  // Front faces wind clockwise in (u, v) because v runs down: hence the order of the factors.
  const double pu1 = dz1 * dv2, pu2 = dv1 * dz2, pv1 = du1 * dz2, pv2 = dz1 * du2, pz1 = dv1 * du2, pz2 = du1 * dv2;
  const double determinant = a.u * (pu1 - pu2) + a.v * (pv1 - pv2) + a.z * (pz1 - pz2);
  // A rotated coordinate is off by at most 4 r (|x| + |y| + |z|), r = 2^-53, and u = fx x + cx z by 8 r (|u| + |v| +
  // (fx + fy + |cx| + |cy|) |z|) = 8 r size, as long as fx and fy differ by no more than a factor of two; z by 4 r size
  // / min(fx, fy). To first order the determinant moves by the error of a coordinate times its cofactor. Its own
  // evaluation is off by 8 r times the sum of its terms, all taken positive. Twice all that is the margin.
  const double input = size(a, rounding) * cofactors(b, c, rounding) + size(b, rounding) * cofactors(c, a, rounding) +
                       size(c, rounding) * cofactors(a, b, rounding);
  const double terms = std::abs(a.u) * (std::abs(pu1) + std::abs(pu2)) +
                       std::abs(a.v) * (std::abs(pv1) + std::abs(pv2)) +
                       std::abs(a.z) * (std::abs(pz1) + std::abs(pz2));
  const double margin = 16 * kDoubleRoundoff * (input + terms);
  RasterFace face{{a, b, c}, Facing::edge_on};
  if (determinant > margin) {
    face.facing = Facing::front;
  } else if (determinant < -margin) {
    face.facing = Facing::back;
    std::swap(face.vertex[1], face.vertex[2]);
  }
  return face;
}

InverseDepth inverse_depth_from(const RasterFace& face, double px, double py) {
  const EdgeValues values = edge_values(face, px, py);
  double sum = 0, determinant = 0, sum_per_x = 0, sum_per_y = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Gradient gradient = edge_gradient(face, values, k);
    sum += values.e[k];
    determinant += values.e[k] * face.vertex[k].z;
    sum_per_x += gradient.x;
    sum_per_y += gradient.y;
  }
  InverseDepth plane;
  plane.x = px;
  plane.y = py;
  plane.first = sum / determinant;
  plane.per_x = sum_per_x / determinant;
  plane.per_y = sum_per_y / determinant;
  return plane;
}

PixelBox pixel_bounds(const RasterFace& face, const FaceBounds& bounds, const PixelBox& window) {
  return face.facing == Facing::edge_on ? PixelBox{} : pixel_centres(bounds, window);
}

PixelBox pixel_bounds(const RasterFace& face, const PixelBox& window) {
  const auto& v = face.vertex;
  return pixel_bounds(face, face_bounds(rounded_position(v[0]), rounded_position(v[1]), rounded_position(v[2])),
                      window);
}

SpanWalker::SpanWalker(const RasterFace& face, const PixelBox& bounds) : box_(bounds) {
  if (box_.empty()) return;
  const EdgeValues values = edge_values(face, box_.x0 + 0.5, box_.y0 + 0.5);
  for (std::size_t k = 0; k < 3; ++k) {
    const Gradient gradient = edge_gradient(face, values, k);
    lines_[k] = {gradient.x, gradient.y, values.e[k], 1 / gradient.x,
                 0.5 * (std::abs(gradient.x) + std::abs(gradient.y))};
  }
  // The tolerance. With z, a, b the largest |z|, |A|, |B| of a vertex seen from any pixel of the box, da and db the
  // rounding of A and B, and r = 2^-53, so that width * z <= a and height * z <= b:
  //
  //     a value e computed at its own pixel         off by at most  2 (a db + b da) +  4 r a b
  //     a value extrapolated from the first pixel   off by at most  4 (a db + b da) + 36 r a b
  //     (|de/dx| + |de/dy|) / 2                     off by at most  2 (a db + b da) +  8 r a b
  //     sum, rounded up                                             8 (a db + b da) + 64 r a b
  //
  // A value further from zero than that has the same sign however it is computed, and in real arithmetic.
  const double z = largest(face.vertex[0].z, face.vertex[1].z, face.vertex[2].z);
  const double width = box_.x1 - box_.x0, height = box_.y1 - box_.y0;
  const double a = largest(values.a[0], values.a[1], values.a[2]) + width * z;
  const double b = largest(values.b[0], values.b[1], values.b[2]) + height * z;
  const double farthest_x = std::max(std::abs(box_.x0), std::abs(box_.x1)) + 1.0;
  const double farthest_y = std::max(std::abs(box_.y0), std::abs(box_.y1)) + 1.0;
  const double da = kDoubleRoundoff * (farthest_x * z + a), db = kDoubleRoundoff * (farthest_y * z + b);
  tolerance_ = 8 * (a * db + b * da) + 64 * kDoubleRoundoff * (a * b);
}

}  // namespace gpvc::visibility
