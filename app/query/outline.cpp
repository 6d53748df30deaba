#include "app/query/outline.h"

#include <cstddef>
#include <map>
#include <utility>

namespace gpvc::query {
namespace {

using Corner = std::array<int, 2>;

// Cells of a window of a grid, with an empty one all around.
class Cells {
 public:
  Cells(int i0, int j0, int i1, int j1) : i0_(i0 - 1), j0_(j0 - 1), width_(i1 - i0 + 3), height_(j1 - j0 + 3) {
    filled_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  }
  void fill(int i, int j) { filled_[place(i - i0_, j - j0_)] = 1; }

  // Where two cells meet in a corner alone, a third one joins them; that may make another such place.
  void join_corners() {
    for (bool joined = true; joined;) {
      joined = false;
      for (int j = 0; j + 1 < height_; ++j)
        for (int i = 0; i + 1 < width_; ++i) {
          std::uint8_t &a = filled_[place(i, j)], &b = filled_[place(i + 1, j)], &c = filled_[place(i, j + 1)],
                       &d = filled_[place(i + 1, j + 1)];
          if (a != d || b != c || a == b) continue;
          (a != 0 ? b : a) = 1;
          joined = true;
        }
    }
  }

  std::vector<GroundPolygon> polygons(const CellGrid& grid) {
    number_parts();
    std::vector<GroundPolygon> all(static_cast<std::size_t>(parts_));
    for (const auto& [corners, part] : rings()) {
      GroundRing ring;
      for (const Corner& corner : corners) ring.push_back({grid.x(corner[0] + i0_), grid.y(corner[1] + j0_)});
      ring.push_back(ring.front());
      GroundPolygon& polygon = all[static_cast<std::size_t>(part)];
      if (twice_area(corners) > 0)
        polygon.outer = std::move(ring);
      else
        polygon.holes.push_back(std::move(ring));
    }
    return all;
  }

 private:
  struct PartRing {
    std::vector<Corner> corners;
    int part;
  };

  std::size_t place(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i);
  }
  bool filled(int i, int j) const { return filled_[place(i, j)] != 0; }

  // Numbers cells that are neighbours by their sides.
  void number_parts() {
    part_.assign(filled_.size(), -1);
    std::vector<Corner> open;
    for (int j = 1; j + 1 < height_; ++j)
      for (int i = 1; i + 1 < width_; ++i) {
        if (!filled(i, j) || part_[place(i, j)] >= 0) continue;
        part_[place(i, j)] = parts_;
        open.assign(1, {i, j});
        while (!open.empty()) {
          const Corner at = open.back();
          open.pop_back();
          for (const Corner& step : {Corner{1, 0}, Corner{-1, 0}, Corner{0, 1}, Corner{0, -1}}) {
            const Corner next{at[0] + step[0], at[1] + step[1]};
            if (!filled(next[0], next[1]) || part_[place(next[0], next[1])] >= 0) continue;
            part_[place(next[0], next[1])] = parts_;
            open.push_back(next);
          }
        }
        ++parts_;
      }
  }

  // Sides between filled cells and empty ones, with the filled one on their left, joined to rings.
  std::vector<PartRing> rings() const {
    std::map<Corner, std::pair<Corner, int>> side_from;  // to where, and of which part
    for (int j = 1; j + 1 < height_; ++j)
      for (int i = 1; i + 1 < width_; ++i) {
        if (!filled(i, j)) continue;
        const int part = part_[place(i, j)];
        if (!filled(i, j - 1)) side_from[{i, j}] = {{i + 1, j}, part};
        if (!filled(i + 1, j)) side_from[{i + 1, j}] = {{i + 1, j + 1}, part};
        if (!filled(i, j + 1)) side_from[{i + 1, j + 1}] = {{i, j + 1}, part};
        if (!filled(i - 1, j)) side_from[{i, j + 1}] = {{i, j}, part};
      }
    std::vector<PartRing> found;
    while (!side_from.empty()) {
      PartRing ring{{}, side_from.begin()->second.second};
      Corner at = side_from.begin()->first;
      for (auto side = side_from.find(at); side != side_from.end(); side = side_from.find(at)) {
        ring.corners.push_back(at);
        at = side->second.first;
        side_from.erase(side);
      }
      remove_straight(ring.corners);
      found.push_back(std::move(ring));
    }
    return found;
  }

  static void remove_straight(std::vector<Corner>& corners) {
    std::vector<Corner> bent;
    for (std::size_t n = 0; n < corners.size(); ++n) {
      const Corner &before = corners[(n + corners.size() - 1) % corners.size()], &at = corners[n],
                   &after = corners[(n + 1) % corners.size()];
      if ((before[0] == at[0]) != (at[0] == after[0])) bent.push_back(at);
    }
    corners = std::move(bent);
  }

  static std::int64_t twice_area(const std::vector<Corner>& corners) {
    std::int64_t sum = 0;
    for (std::size_t n = 0; n < corners.size(); ++n) {
      const Corner &a = corners[n], &b = corners[(n + 1) % corners.size()];
      sum += std::int64_t{a[0]} * b[1] - std::int64_t{a[1]} * b[0];
    }
    return sum;
  }

  int i0_, j0_, width_, height_, parts_ = 0;
  std::vector<std::uint8_t> filled_;
  std::vector<int> part_;
};

std::array<WorldPoint, 3> corners_of(const Mesh& mesh, FaceId face) {
  const auto [a, b, c] = mesh.faces[index(face)];
  return {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
}

}  // namespace

CellGrid grid_over(const Box& box, int most) {
  const double side = std::max({box.high.x - box.low.x, box.high.y - box.low.y, 1e-9});
  CellGrid grid;
  grid.cell = side / most;
  grid.x0 = box.low.x - grid.cell;
  grid.y0 = box.low.y - grid.cell;
  grid.width = static_cast<int>(std::ceil((box.high.x - box.low.x) / grid.cell)) + 2;
  grid.height = static_cast<int>(std::ceil((box.high.y - box.low.y) / grid.cell)) + 2;
  return grid;
}

std::vector<GroundPolygon> outline_of(const Mesh& mesh, std::span<const FaceId> faces, const CellGrid& grid) {
  Box box;
  for (const FaceId face : faces)
    for (const WorldPoint& p : corners_of(mesh, face)) box.add(p);
  Cells cells(grid.column(box.low.x), grid.row(box.low.y), grid.column(box.high.x), grid.row(box.high.y));
  for (const FaceId face : faces) {
    const std::array<WorldPoint, 3> corners = corners_of(mesh, face);
    for_each_cell_in(grid, corners, [&](int i, int j, double) { cells.fill(i, j); });
    for (std::size_t k = 0; k < 3; ++k) {
      // Along its edges in steps of half a cell.
      const WorldPoint &a = corners[k], &b = corners[(k + 1) % 3];
      const int steps = 1 + static_cast<int>(2 * std::max(std::abs(b.x - a.x), std::abs(b.y - a.y)) / grid.cell);
      for (int step = 0; step <= steps; ++step) {
        const double t = static_cast<double>(step) / steps;
        cells.fill(grid.column(a.x + t * (b.x - a.x)), grid.row(a.y + t * (b.y - a.y)));
      }
    }
  }
  cells.join_corners();
  return cells.polygons(grid);
}

}  // namespace gpvc::query
