// The cells of a unit grid that a triangle touches, row by row.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gpvc::atlas {

/// A position in the texels of a chart: the centre of the chart's first texel is (0.5, 0.5), y down.
struct TexelPoint {
  double x = 0, y = 0;
};

using TexelTriangle = std::array<TexelPoint, 3>;

/// Twice the area, positive if the corners turn clockwise as drawn (y down).
inline double doubled_area(const TexelTriangle& t) {
  return (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[1].y - t[0].y) * (t[2].x - t[0].x);
}

/// True strictly inside: a centre of a texel or pixel on the edge may belong to the neighbour.
inline bool contains(const TexelTriangle& t, double x, double y) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const TexelPoint &a = t[i], &b = t[(i + 1) % 3];
    const double side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    left += side > 0;
    right += side < 0;
  }
  return left == 3 || right == 3;
}

/// The weights of the corners at a place, those of a place outside moved onto the triangle; a third each without area.
inline std::array<double, 3> shares_at(const TexelTriangle& t, double x, double y) {
  const double area = doubled_area(t);
  if (area == 0) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
  const double b = std::clamp(doubled_area({t[0], {x, y}, t[2]}) / area, 0.0, 1.0);
  const double c = std::clamp(doubled_area({t[0], t[1], {x, y}}) / area, 0.0, 1.0);
  const double a = std::max(0.0, 1 - b - c), sum = a + b + c;
  return {a / sum, b / sum, c / sum};
}

/// Half-open box of cells.
struct CellBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Bounding box of positions.
struct FrameBox {
  double x0 = std::numeric_limits<double>::infinity(), y0 = x0, x1 = -x0, y1 = -x0;
  void add(double x, double y) {
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  void add(const TexelTriangle& t) {
    for (const auto& p : t) add(p.x, p.y);
  }
  void add(const FrameBox& other) {
    add(other.x0, other.y0);
    add(other.x1, other.y1);
  }
  /// Columns and rows of texels that the box touches.
  int width() const { return std::max(1, static_cast<int>(std::ceil(x1) - std::floor(x0))); }
  int height() const { return std::max(1, static_cast<int>(std::ceil(y1) - std::floor(y0))); }
};

namespace detail {

/// The inside of a triangle as a x + b y + c >= 0, whatever its winding.
struct HalfPlane {
  double a, b, c;
};

inline std::array<HalfPlane, 3> half_planes(const TexelTriangle& t) {
  const double sign = doubled_area(t) < 0 ? -1.0 : 1.0;
  std::array<HalfPlane, 3> planes{};
  for (std::size_t i = 0; i < 3; ++i) {
    const TexelPoint &p = t[i], &q = t[(i + 1) % 3];
    const double a = -(q.y - p.y) * sign, b = (q.x - p.x) * sign;
    planes[i] = {a, b, -(a * p.x + b * p.y)};
  }
  return planes;
}

}  // namespace detail

/// Calls visit(y, first, last) for every row y of `box` with the cells first..last (inclusive) whose square of
/// half-size `half` around the cell's centre (x + 0.5, y + 0.5) meets the triangle. half = 0: the centre lies inside or
/// on the border; half = 0.5: the cell touches the triangle. A separating-axis test with the triangle's three normals
/// and the two axes, exact up to rounding. Works for degenerate triangles, whose edges bound both sides of their line.
/// O(rows).
template <typename Visit>
void triangle_spans(const TexelTriangle& t, double half, const CellBox& box, Visit&& visit) {
  const auto planes = detail::half_planes(t);
  const double min_x = std::min({t[0].x, t[1].x, t[2].x}) - half;
  const double max_x = std::max({t[0].x, t[1].x, t[2].x}) + half;
  const double min_y = std::min({t[0].y, t[1].y, t[2].y}) - half;
  const double max_y = std::max({t[0].y, t[1].y, t[2].y}) + half;
  // Clamped to the box first: far outside it the casts would overflow.
  const int first_row = static_cast<int>(std::ceil(std::clamp(min_y - 0.5, box.y0 - 1.0, box.y1 + 1.0)));
  const int last_row = static_cast<int>(std::floor(std::clamp(max_y - 0.5, box.y0 - 1.0, box.y1 + 1.0)));
  for (int y = std::max(first_row, box.y0); y <= std::min(last_row, box.y1 - 1); ++y) {
    const double centre_y = y + 0.5;
    double low = min_x, high = max_x;
    for (const auto& p : planes) {
      const double rest = p.b * centre_y + p.c + half * (std::abs(p.a) + std::abs(p.b));
      if (p.a > 0) low = std::max(low, -rest / p.a);
      if (p.a < 0) high = std::min(high, -rest / p.a);
      if (p.a == 0 && rest < 0) high = low - 1;
    }
    if (!(low <= high)) continue;
    const int first = std::max(box.x0, static_cast<int>(std::ceil(std::clamp(low - 0.5, box.x0 - 1.0, box.x1 + 1.0))));
    const int last =
        std::min(box.x1 - 1, static_cast<int>(std::floor(std::clamp(high - 0.5, box.x0 - 1.0, box.x1 + 1.0))));
    if (first <= last) visit(y, first, last);
  }
}

}  // namespace gpvc::atlas
