// Parts of a mesh seen from above: in cells of a grid, and as polygons around those cells.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"

namespace gpvc::query {

/// Square cells over the ground, x east and y north; row 0 is the southernmost.
struct CellGrid {
  double x0 = 0, y0 = 0, cell = 1;
  int width = 0, height = 0;

  int column(double x) const { return std::clamp(static_cast<int>(std::floor((x - x0) / cell)), 0, width - 1); }
  int row(double y) const { return std::clamp(static_cast<int>(std::floor((y - y0) / cell)), 0, height - 1); }
  WorldPoint centre(int i, int j) const { return {x0 + (i + 0.5) * cell, y0 + (j + 0.5) * cell, 0}; }
  double x(int i) const { return x0 + i * cell; }
  double y(int j) const { return y0 + j * cell; }
};

/// Over the mesh, with at most so many cells along its longer side and one more around it.
CellGrid grid_over(const Box& box, int most);

/// Calls use(i, j, z) for the cells whose centre lies in the triangle as seen from above, with its height there.
template <class Use>
void for_each_cell_in(const CellGrid& grid, const std::array<WorldPoint, 3>& corners, const Use& use) {
  const auto& [a, b, c] = corners;
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (area == 0) return;
  const int i0 = grid.column(std::min({a.x, b.x, c.x})), i1 = grid.column(std::max({a.x, b.x, c.x}));
  const int j0 = grid.row(std::min({a.y, b.y, c.y})), j1 = grid.row(std::max({a.y, b.y, c.y}));
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const WorldPoint p = grid.centre(i, j);
      const double of_b = ((p.x - a.x) * (c.y - a.y) - (p.y - a.y) * (c.x - a.x)) / area;
      const double of_c = ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / area;
      if (of_b >= 0 && of_c >= 0 && of_b + of_c <= 1) use(i, j, a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z));
    }
}

using GroundRing = std::vector<std::array<double, 2>>;  ///< closed: the last corner is the first

struct GroundPolygon {
  GroundRing outer;               ///< counter-clockwise
  std::vector<GroundRing> holes;  ///< clockwise
};

/// Around the cells that the faces touch. A wall, which has no area from above, is a row of cells; faces above each other are
/// one area. Cells that meet in a corner alone are joined by a third one, so that no ring touches itself. \param faces of the
/// mesh O(cells of the faces' bounding box).
std::vector<GroundPolygon> outline_of(const Mesh& mesh, std::span<const FaceId> faces, const CellGrid& grid);

}  // namespace gpvc::query
