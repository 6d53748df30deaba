// A triangle that is wider than 1 + 2 / sqrt(3) in every direction of the grid contains a point of it (the flatness
// theorem in the plane, Hurkens 1990). So it is enough to find the direction it is thinnest in, by Gauss' reduction of
// a basis under the norm "width of the triangle along an integer vector", and either to be content with the width or to
// look along the few lines of the grid that cross the triangle that way.
#include "visibility/oracle/oracle_grid.h"

#include <algorithm>
#include <cmath>

namespace gpvc::visibility::truth {
namespace {

using Real = long double;

struct Point {
  Real x, y;
};

/// Corners in units of pixels, centres at whole numbers.
struct Triangle2 {
  std::array<Point, 3> corner;

  /// Distance to the nearest edge's line, positive inside.
  Real margin(Real x, Real y) const {
    const auto side = [&](std::size_t k, Real px, Real py) {
      const Point &a = corner[k], &b = corner[(k + 1) % 3];
      return (b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x);
    };
    const Real turn = side(0, corner[2].x, corner[2].y) < 0 ? -1 : 1;
    Real least = std::numeric_limits<Real>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
      const Point &a = corner[k], &b = corner[(k + 1) % 3];
      const Real length = std::hypot(b.x - a.x, b.y - a.y);
      least = std::min(least, length == 0 ? 0 : turn * side(k, x, y) / length);
    }
    return least;
  }
};

struct Direction {
  std::int64_t x, y;
};

struct Range {
  Real low, high;
};

Range along(const Triangle2& t, const Direction& d) {
  Range range{std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity()};
  for (const Point& c : t.corner) {
    const Real value = static_cast<Real>(d.x) * c.x + static_cast<Real>(d.y) * c.y;
    range = {std::min(range.low, value), std::max(range.high, value)};
  }
  return range;
}

Real width(const Triangle2& t, const Direction& d) {
  const Range range = along(t, d);
  return range.high - range.low;
}

Direction less(const Direction& a, const Direction& b, std::int64_t times) {
  return {a.x - times * b.x, a.y - times * b.y};
}

/// The multiple of `b` that leaves the thinnest `a`; the width is convex in it, with a minimum within width(a) /
/// width(b) of zero.
std::int64_t best_multiple(const Triangle2& t, const Direction& a, const Direction& b) {
  const auto bound = static_cast<std::int64_t>(std::ceil(2 * width(t, a) / width(t, b))) + 1;
  std::int64_t low = -bound, high = bound;
  while (low < high) {
    const std::int64_t middle = low + (high - low) / 2;
    if (width(t, less(a, b, middle)) <= width(t, less(a, b, middle + 1)))
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

/// Basis of the grid with the thinnest direction first.
std::array<Direction, 2> reduced_basis(const Triangle2& t) {
  Direction a{1, 0}, b{0, 1};
  if (width(t, b) < width(t, a)) std::swap(a, b);
  for (int step = 0; step < 64 && width(t, a) > 0; ++step) {
    b = less(b, a, best_multiple(t, b, a));
    if (!(width(t, b) < width(t, a))) break;
    std::swap(a, b);
  }
  return {a, b};
}

/// The stretch of a line { position along `across` is m } inside the triangle, as positions along `other`.
Range crossing(const Triangle2& t, const Direction& across, const Direction& other, Real m) {
  Range range{std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity()};
  const auto value = [](const Direction& d, const Point& p) {
    return static_cast<Real>(d.x) * p.x + static_cast<Real>(d.y) * p.y;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const Point &p = t.corner[k], &q = t.corner[(k + 1) % 3];
    const Real from = value(across, p) - m, to = value(across, q) - m;
    if ((from > 0 && to > 0) || (from < 0 && to < 0)) continue;
    const Real share = from == to ? 0 : from / (from - to);
    const Real n = value(other, p) + share * (value(other, q) - value(other, p));
    range = {std::min(range.low, n), std::max(range.high, n)};
    if (from == to) range = {std::min(range.low, value(other, q)), std::max(range.high, value(other, q))};
  }
  return range;
}

}  // namespace

Answer contains_a_centre(const Corners& corners, std::vector<GridPosition>& near_edges) {
  Triangle2 t{};
  Real largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    t.corner[k] = {corners[k].x / corners[k].z - 0.5L, corners[k].y / corners[k].z - 0.5L};
    largest = std::max({largest, std::abs(t.corner[k].x), std::abs(t.corner[k].y)});
  }
  // Widths are products of a corner and a direction of about its size: beyond 2^24 px these leave less than kTiePx of a
  // long double.
  if (!(largest < 0x1p24L)) return Answer::maybe;
  const auto [across, other] = reduced_basis(t);
  // 1 + 2 / sqrt(3) is 2.155; the rest leaves room for kTiePx at the edges.
  if (width(t, across) > 3) return Answer::yes;
  // x = (m, n) in the basis; its inverse has the same determinant, 1 or -1.
  const std::int64_t determinant = across.x * other.y - across.y * other.x;
  const Range lines = along(t, across);
  constexpr Real kSlack = 1e-6L;
  for (Real m = std::ceil(lines.low - kSlack); m <= std::floor(lines.high + kSlack); ++m) {
    const Range run = crossing(t, across, other, std::clamp(m, lines.low, lines.high));
    const Real middle = std::round((run.low + run.high) / 2);
    for (const Real n : {middle, middle - 1, middle + 1}) {
      const Real x =
          (m * static_cast<Real>(other.y) - n * static_cast<Real>(across.y)) * static_cast<Real>(determinant);
      const Real y =
          (n * static_cast<Real>(across.x) - m * static_cast<Real>(other.x)) * static_cast<Real>(determinant);
      const Real margin = t.margin(x, y);
      if (margin > kTiePx) return Answer::yes;
      if (margin >= -kTiePx) near_edges.push_back({static_cast<double>(x + 0.5L), static_cast<double>(y + 0.5L)});
    }
  }
  return near_edges.empty() ? Answer::no : Answer::maybe;
}

}  // namespace gpvc::visibility::truth
