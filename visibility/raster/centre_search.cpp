// A convex figure wider than 1 + 2 / sqrt(3) in every direction of the grid contains a point of it (flatness theorem in
// the plane, Hurkens 1990). So the directions need to be gone through, from the axes on, only until the face is found
// to be thin along one, by Gauss' reduction of a basis under the norm "width of the face along an integer vector": then
// few lines of the grid cross it that way, and on each the centres inside an edge are a half-line, whose end the exact
// predicate finds by halving.
#include "visibility/raster/centre_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

/// Of the grid whose points are the pixel centres.
struct GridVector {
  std::int64_t x, y;
};

struct Range {
  double low, high;
};

/// The corners of the projection in the grid's coordinates, from a centre close to the first on.
struct GridFace {
  const RasterFace& face;
  double origin_x, origin_y;  ///< whole
  std::array<double, 3> x, y;

  explicit GridFace(const RasterFace& f) : face(f) {
    origin_x = std::floor(f.vertex[0].u / f.vertex[0].z);
    origin_y = std::floor(f.vertex[0].v / f.vertex[0].z);
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = f.vertex[k].u / f.vertex[k].z - origin_x - 0.5;
      y[k] = f.vertex[k].v / f.vertex[k].z - origin_y - 0.5;
    }
  }

  Range along(const GridVector& d) const {
    const auto dx = static_cast<double>(d.x), dy = static_cast<double>(d.y);
    const double a = dx * x[0] + dy * y[0], b = dx * x[1] + dy * y[1], c = dx * x[2] + dy * y[2];
    return {std::min({a, b, c}), std::max({a, b, c})};
  }
  double width(const GridVector& d) const {
    const Range range = along(d);
    return range.high - range.low;
  }
  bool inside_edge(const GridVector& p, std::size_t k) const {
    const FacePoint point =
        face_point(face, origin_x + static_cast<double>(p.x) + 0.5, origin_y + static_cast<double>(p.y) + 0.5);
    return inside_edge_exactly(point, k);
  }
};

GridVector plus(const GridVector& a, std::int64_t times, const GridVector& b) {
  return {a.x + times * b.x, a.y + times * b.y};
}

/// The multiple of `b` that makes the face narrowest along `a` + it. The width is convex in it, and beyond twice
/// width(a) / width(b) larger than width(a).
std::int64_t best_multiple(const GridFace& face, const GridVector& a, const GridVector& b) {
  std::int64_t high = static_cast<std::int64_t>(std::ceil(2 * face.width(a) / face.width(b))) + 1, low = -high;
  while (low < high) {
    const std::int64_t middle = low + (high - low) / 2;
    if (face.width(plus(a, middle, b)) <= face.width(plus(a, middle + 1, b)))
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

/// Widths are sums of products of a corner and a vector, both below 2^26 here: rounding takes less than 2^-1 of what
/// lies between 1 + 2 / sqrt(3) = 2.155 and this.
constexpr double kThin = 3;

/// A direction along which the face is no wider than kThin; none where it is wider in all of them.
std::optional<GridVector> thin_direction(const GridFace& face) {
  GridVector a{1, 0}, b{0, 1};
  if (face.width(b) < face.width(a)) std::swap(a, b);
  while (face.width(a) > kThin) {
    b = plus(b, best_multiple(face, b, a), a);
    // The narrowest of the vectors that are not multiples of a, and they are all wider.
    if (!(face.width(b) < face.width(a))) return std::nullopt;
    std::swap(a, b);
  }
  return a;
}

/// A vector s with d . s = 1, no longer than d. \pre coordinates without a common divisor
GridVector with_product_one(const GridVector& d) {
  std::int64_t r = std::abs(d.x), next_r = std::abs(d.y), s = 1, next_s = 0, t = 0,
               next_t = 1;  // r = s |x| + t |y|
  while (next_r != 0) {
    const std::int64_t quotient = r / next_r;
    r = std::exchange(next_r, r - quotient * next_r);
    s = std::exchange(next_s, s - quotient * next_s);
    t = std::exchange(next_t, t - quotient * next_t);
  }
  return {d.x < 0 ? -s : s, d.y < 0 ? -t : t};
}

/// Whether one of the grid's points on { p : d . p = m } lies in the face.
bool line_has_centre(const GridFace& face, const GridVector& d, std::int64_t m) {
  const GridVector s = with_product_one(d), first{m * s.x, m * s.y}, step{-d.y, d.x};
  const auto dx = static_cast<double>(step.x), dy = static_cast<double>(step.y);
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < 3; ++k) {
    const double at =
        ((face.x[k] - static_cast<double>(first.x)) * dx + (face.y[k] - static_cast<double>(first.y)) * dy) /
        (dx * dx + dy * dy);
    range = {std::min(range.low, at), std::max(range.high, at)};
  }
  // Places along the line are known to far less than a step.
  auto low = static_cast<std::int64_t>(std::floor(range.low)) - 1,
       high = static_cast<std::int64_t>(std::ceil(range.high)) + 1;
  for (std::size_t k = 0; k < 3 && low <= high; ++k) {
    const auto inside = [&](std::int64_t n) { return face.inside_edge(plus(first, n, step), k); };
    const bool at_low = inside(low), at_high = inside(high);
    if (at_low && at_high) continue;
    if (!at_low && !at_high) return false;
    std::int64_t in = at_low ? low : high, out = at_low ? high : low;
    while (std::abs(in - out) > 1) {
      const std::int64_t middle = (in + out) / 2;
      (inside(middle) ? in : out) = middle;
    }
    (at_low ? high : low) = in;
  }
  return low <= high;
}

}  // namespace

bool covers_a_pixel(const RasterFace& face) {
  for (const ProjectedVertex& v : face.vertex)
    if (!(v.z > 0) || std::abs(v.u) > kFarthestCentre * v.z || std::abs(v.v) > kFarthestCentre * v.z) return true;
  const GridFace grid(face);
  const std::optional<GridVector> d = thin_direction(grid);
  if (!d) return true;
  // A corner is off by what dividing and subtracting round, 2^-28 at 2^24, and a product by 2^-52 of itself. A line too
  // many does no harm.
  const Range range = grid.along(*d);
  const double slack = 0x1p-26 * static_cast<double>(std::abs(d->x) + std::abs(d->y));
  const auto last = static_cast<std::int64_t>(std::floor(range.high + slack));
  for (auto m = static_cast<std::int64_t>(std::ceil(range.low - slack)); m <= last; ++m)
    if (line_has_centre(grid, *d, m)) return true;
  return false;
}

}  // namespace gpvc::visibility
