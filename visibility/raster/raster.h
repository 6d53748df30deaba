// Coverage of pixel centres by a face: LEF and TLR in double on unsnapped coordinates; the CPU twin of
// shaders/raster.glsl.
//
// Pixel p = (x, y) has its centre at (x + 1/2, y + 1/2). With A = u - px z and B = v - py z of a vertex
// (the vertex as seen from p, times its depth), formula 6 for the edge i -> j is
//
//     e(p) = A_j B_i - A_i B_j      positive left of the edge on the screen (y runs down),
//
// the same for any depth signs: a point of the projection with z > 0 has three positive values, a point that
// only the part behind the camera would cover has three negative ones. Nothing is divided, nothing clipped.
//
// Front faces wind counter-clockwise on the screen. Back faces are stored with two vertices exchanged, so
// that inside is positive for both.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "visibility/raster/projection.h"

namespace gpvc::visibility {

enum class Facing : std::uint8_t { edge_on, front, back };

/// Which of two faces is in front where their depths are equal: one that turns its front to the camera, as the other's
/// back is not seen in any case; then the one of the lower index. Surfaces whose two sides are faces of their own are seen
/// from both.
inline bool precedes_at_equal_depth(Facing a_facing, FaceId a, Facing b_facing, FaceId b) {
  const bool a_front = a_facing == Facing::front, b_front = b_facing == Facing::front;
  return a_front != b_front ? a_front : a < b;
}

struct RasterFace {
  std::array<ProjectedVertex, 3> vertex;  ///< inside positive; the first has the least |z|
  Facing facing = Facing::edge_on;
};

/// How far projecting rounds u, v and z, in units of their sizes.
struct ProjectionRounding {
  double u_per_z = 0;  ///< fx + fy + |cx| + |cy|: what multiplies depth in u and v
  double z_per_u = 0;  ///< 1 / min(fx, fy)
};

ProjectionRounding projection_rounding(const Camera& camera);

/// The same corners in the same turn, the one of least |z| first.
inline std::array<ProjectedVertex, 3> nearest_first(const ProjectedVertex& a, const ProjectedVertex& b,
                                                    const ProjectedVertex& c) {
  const double za = std::abs(a.z), zb = std::abs(b.z), zc = std::abs(c.z);
  if (zb < za && zb <= zc) return {b, c, a};
  if (zc < za && zc < zb) return {c, a, b};
  return {a, b, c};
}

/// A face whose determinant cannot be told from zero, given that u, v and z are rounded values, is edge-on: it is
/// thinner than about 1e-11 px, covers nothing and is never seen. Degenerate faces always are.
RasterFace raster_face(ProjectedVertex a, ProjectedVertex b, ProjectedVertex c, const ProjectionRounding& rounding);

/// Edge values of a face at a pixel centre; e[k] belongs to the edge opposite vertex k.
struct EdgeValues {
  std::array<double, 3> e;
  std::array<double, 3> a, b;  ///< u and v of the vertices as seen from the centre, times depth
};

inline EdgeValues edge_values(const RasterFace& face, double px, double py) {
  EdgeValues values;
  for (std::size_t k = 0; k < 3; ++k) {
    values.a[k] = face.vertex[k].u - px * face.vertex[k].z;
    values.b[k] = face.vertex[k].v - py * face.vertex[k].z;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    values.e[k] = values.a[j] * values.b[i] - values.a[i] * values.b[j];
  }
  return values;
}

/// Gradient of e[k] along x and y.
struct Gradient {
  double x, y;
};

inline Gradient edge_gradient(const RasterFace& face, const EdgeValues& values, std::size_t k) {
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  const double zi = face.vertex[i].z, zj = face.vertex[j].z;
  return {zi * values.b[j] - zj * values.b[i], zj * values.a[i] - zi * values.a[j]};
}

/// TLR (figure 10) for a centre exactly on an edge: it belongs to the face when the inside lies to its right
/// (left edge), or below it and the edge is horizontal (top edge).
///
///     top edge        left edge
///     --x--           x          x belongs to the face that is marked #
///      ###             \###
inline bool top_left(const Gradient& inside) { return inside.x > 0 || (inside.x == 0 && inside.y > 0); }

inline bool covers(const RasterFace& face, const EdgeValues& values) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (values.e[k] < 0) return false;
    if (values.e[k] == 0 && !top_left(edge_gradient(face, values, k))) return false;
  }
  return true;
}

/// True when the line of an edge crosses the pixel around the centre: at one of the four corners, half a pixel away
/// along x and y, e reaches zero.
inline bool crossed_by_edge(const RasterFace& face, const EdgeValues& values) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Gradient gradient = edge_gradient(face, values, k);
    if (std::abs(values.e[k]) <= 0.5 * (std::abs(gradient.x) + std::abs(gradient.y))) return true;
  }
  return false;
}

/// Depth of the face's plane at the centre, as a fraction: z0 + n / s with s > 0 for a covered centre.
struct PlaneDepth {
  double z0, n, s;
};

inline PlaneDepth plane_depth(const RasterFace& face, const EdgeValues& values) {
  const auto& v = face.vertex;
  return {v[0].z, (v[1].z - v[0].z) * values.e[1] + (v[2].z - v[0].z) * values.e[2],
          values.e[0] + values.e[1] + values.e[2]};
}

/// Negative when the first is nearer, positive when farther; 0 is a tie.
inline double compare_depth(const PlaneDepth& f, const PlaneDepth& g) {
  return (f.z0 - g.z0) * (f.s * g.s) + (f.n * g.s - g.n * f.s);
}

/// 1 / z of a face's plane, which is linear over the image.
struct InverseDepth {
  double x = 0, y = 0, first = 0, per_x = 0, per_y = 0;
  double error = std::numeric_limits<double>::infinity();  ///< infinite: not known

  double at(double px, double py) const { return first + per_x * (px - x) + per_y * (py - y); }
  /// True when its face certainly lies in front of the other's at a point of both projections.
  bool before(const InverseDepth& other, double px, double py) const {
    return at(px, py) - other.at(px, py) > error + other.error;
  }
};

/// Taken from the edge values at (px, py), without an error bound: z = (sum of e z) / (sum of e), and the numerator is
/// the same everywhere. \pre not edge-on
InverseDepth inverse_depth_from(const RasterFace& face, double px, double py);

// --- spans

/// A run of covered pixels.
struct Span {
  std::int32_t y, x0, x1;
};

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelBox {
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// A rectangle that contains the projection of a face; it may reach beyond the frame.
struct FaceBounds {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< pixels
  bool ahead = false;                     ///< false: no point of the face is on the frame
  bool bounded = false;                   ///< all vertices are in front of the camera; else the rectangle is not set
};

/// True when the projection lies beyond one border of [0, W] x [0, H], or the face is behind the camera. Exact: W and H
/// are integers, and a rounded product W z orders as the product itself does with a double. u < 0 at all corners means
/// u < 0 at every point between, and x = u / z < 0 where z > 0; the same for the other sides, whatever the signs of z.
inline bool misses_frame(const Camera& camera, const std::array<ProjectedVertex, 3>& vertex) {
  const double w = camera.width, h = camera.height;
  const auto all = [&](auto&& beyond) { return beyond(vertex[0]) && beyond(vertex[1]) && beyond(vertex[2]); };
  return all([](const ProjectedVertex& p) { return !(p.z > 0); }) ||
         all([](const ProjectedVertex& p) { return p.u < 0; }) ||
         all([](const ProjectedVertex& p) { return p.v < 0; }) ||
         all([w](const ProjectedVertex& p) { return p.u > w * p.z; }) ||
         all([h](const ProjectedVertex& p) { return p.v > h * p.z; });
}

/// A rectangle that contains both. \pre b.ahead.
inline FaceBounds united(const FaceBounds& a, const FaceBounds& b) {
  if (!a.ahead) return b;
  return {std::min(a.x0, b.x0),  std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1), true,
          a.bounded && b.bounded};
}

/// From rounded positions, widened by their rounding.
inline FaceBounds face_bounds(const RoundedPosition& a, const RoundedPosition& b, const RoundedPosition& c) {
  const bool ahead_a = a.x == a.x, ahead_b = b.x == b.x, ahead_c = c.x == c.x;  // not NaN
  if (!(ahead_a && ahead_b && ahead_c)) return {0, 0, 0, 0, ahead_a || ahead_b || ahead_c, false};
  // A quotient is off by 2^-53 of itself, a position below 2^-100 by less than that.
  const auto below = [](double v) { return v - 0x1p-50 * std::abs(v) - 0x1p-99; };
  const auto above = [](double v) { return v + 0x1p-50 * std::abs(v) + 0x1p-99; };
  return {below(std::min({a.x, b.x, c.x})),
          below(std::min({a.y, b.y, c.y})),
          above(std::max({a.x, b.x, c.x})),
          above(std::max({a.y, b.y, c.y})),
          true,
          true};
}

/// True when the face certainly has no point in [0, width] x [0, height].
inline bool outside(const FaceBounds& bounds, double width, double height) {
  return !bounds.ahead ||
         (bounds.bounded && (bounds.x1 < 0 || bounds.y1 < 0 || bounds.x0 > width || bounds.y0 > height));
}

/// The pixels of `window` whose centres may lie in the projection of the face; empty for an edge-on face.
PixelBox pixel_bounds(const RasterFace& face, const FaceBounds& bounds, const PixelBox& window);
PixelBox pixel_bounds(const RasterFace& face, const PixelBox& window);

/// floor() and ceil() of a value that an int32 holds; without SSE4 the library's are function calls.
inline std::int32_t floor_int(double v) {
  const auto truncated = static_cast<std::int32_t>(v);
  return truncated - (static_cast<double>(truncated) > v ? 1 : 0);
}
inline std::int32_t ceil_int(double v) {
  const auto truncated = static_cast<std::int32_t>(v);
  return truncated + (static_cast<double>(truncated) < v ? 1 : 0);
}

/// The pixels of `window` whose centres may lie within the bounds.
inline PixelBox pixel_centres(const FaceBounds& bounds, const PixelBox& window) {
  if (!bounds.ahead) return {};
  if (!bounds.bounded) return window;
  const auto first = [](double low, std::int32_t from, std::int32_t to) {
    return ceil_int(std::clamp<double>(low - 0.5, from, to));
  };
  const auto end = [](double high, std::int32_t from, std::int32_t to) {
    return floor_int(std::clamp<double>(high + 0.5, from, to));
  };
  return {first(bounds.x0, window.x0, window.x1), first(bounds.y0, window.y0, window.y1),
          end(bounds.x1, window.x0, window.x1), end(bounds.y1, window.y0, window.y1)};
}

/// The pixels of `window` that the face may touch.
inline PixelBox touched_pixels(const FaceBounds& bounds, const PixelBox& window) {
  if (!bounds.ahead) return {};
  if (!bounds.bounded) return window;
  const auto pixel = [](double position, std::int32_t from, std::int32_t to) {
    return floor_int(std::clamp<double>(position, from, to));
  };
  return {pixel(bounds.x0, window.x0, window.x1), pixel(bounds.y0, window.y0, window.y1),
          std::min(pixel(bounds.x1, window.x0, window.x1) + 1, window.x1),
          std::min(pixel(bounds.y1, window.y0, window.y1) + 1, window.y1)};
}

/// Finds the runs of pixels that a face covers, row by row. Edge values are linear along a row, so the ends of its run
/// are computed from them and then confirmed: the values at the pixel inside and at the pixel outside of an end must
/// differ from zero by more than tolerance_. A row that cannot be confirmed is decided pixel by pixel.
class SpanWalker {
 public:
  /// `bounds`: pixel_bounds of the face in the window to be walked.
  SpanWalker(const RasterFace& face, const PixelBox& bounds);

  /// Calls span(y, x0, x1) for each run of covered pixels, top to bottom, left to right. `inside(x, y)` decides single
  /// pixels.
  template <class Inside, class Callback>
  void walk(Inside&& inside, Callback&& span) const {
    for (std::int32_t y = box_.y0; y < box_.y1; ++y) {
      if (const std::optional<Span> run = certain_run(y, 0.0)) {
        if (run->x0 < run->x1) span(y, run->x0, run->x1);
        continue;
      }
      for (std::int32_t x = box_.x0; x < box_.x1;) {
        if (!inside(x, y)) {
          ++x;
          continue;
        }
        std::int32_t end = x + 1;
        while (end < box_.x1 && inside(end, y)) ++end;
        span(y, x, end);
        x = end;
      }
    }
  }

  /// The pixels of row y that are covered and that no edge crosses (crossed_by_edge is false): x1 <= x0 where there are
  /// none. Nothing when that is not certain.
  std::optional<Span> inner_run(std::int32_t y) const { return certain_run(y, 1.0); }

 private:
  struct Line {
    double x, y, c;   ///< e = x dx + y dy + c from the centre of the box's first pixel
    double per_x;     ///< 1 / x
    double crossing;  ///< (|x| + |y|) / 2
  };

  std::optional<Span> certain_run(std::int32_t y, double crossing_factor) const;

  PixelBox box_;
  std::array<Line, 3> lines_;
  double tolerance_ = 0;
};

/// The pixels of row y where every edge value exceeds `crossing_factor` times its line's crossing.
inline std::optional<Span> SpanWalker::certain_run(std::int32_t y, double crossing_factor) const {
  const std::int32_t dy = y - box_.y0, width = box_.x1 - box_.x0;
  const double limit = width;
  std::int32_t first = 0, last = width;
  for (const Line& line : lines_) {
    const double c = line.y * dy + (line.c - crossing_factor * line.crossing);
    const double zero = -c * line.per_x;
    const double clamped = zero > 0 ? (zero < limit ? zero : limit) : 0.0;  // NaN becomes 0
    const auto floor = static_cast<std::int32_t>(clamped);
    if (line.x > 0) {
      const std::int32_t begin = floor + (clamped > floor ? 1 : 0);
      if (begin < width && !(line.x * begin + c > tolerance_)) return std::nullopt;
      if (begin > 0 && !(line.x * (begin - 1) + c < -tolerance_)) return std::nullopt;
      if (begin > first) first = begin;
    } else if (line.x < 0) {
      const std::int32_t end = zero < 0 ? 0 : (floor + 1 < width ? floor + 1 : width);
      if (end > 0 && !(line.x * (end - 1) + c > tolerance_)) return std::nullopt;
      if (end < width && !(line.x * end + c < -tolerance_)) return std::nullopt;
      if (end < last) last = end;
    } else {
      if (!(std::abs(c) > tolerance_)) return std::nullopt;
      if (c < 0) last = 0;
    }
  }
  return Span{y, box_.x0 + first, box_.x0 + last};
}

}  // namespace gpvc::visibility
