#include "app/checks/mesh_shift.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "app/checks/frame_check.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

// Cells of a grid over the mesh's bounding box, those that the surface passes through being set.
class SurfaceCells {
 public:
  SurfaceCells(const Mesh& mesh, const Box& box, double edge) : low_(box.low), edge_(edge) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      size_[axis] = static_cast<std::int64_t>(std::floor((part(box.high, axis) - part(box.low, axis)) / edge)) + 1;
    cells_.resize(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]), 0);
    for (const Triangle& face : mesh.faces)
      add(mesh.positions[face[0]], mesh.positions[face[1]], mesh.positions[face[2]]);
  }

  bool has(const WorldPoint& p) const {
    const std::int64_t at = cell(p);
    return at >= 0 && cells_[static_cast<std::size_t>(at)] != 0;
  }

 private:
  static double part(const WorldPoint& p, std::size_t axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  std::int64_t cell(const WorldPoint& p) const {
    std::int64_t at = 0;
    for (std::size_t axis = 3; axis-- > 0;) {
      const double place = std::floor((part(p, axis) - part(low_, axis)) / edge_);
      if (!(place >= 0 && place < static_cast<double>(size_[axis]))) return -1;
      at = at * size_[axis] + static_cast<std::int64_t>(place);
    }
    return at;
  }

  // Points half a cell apart leave out only cells that the face cuts a corner off.
  void add(const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
    const double longest = std::max({length(b - a), length(c - a), length(c - b)});
    const auto steps = static_cast<int>(std::min(1e4, std::ceil(2 * longest / edge_)));
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j) {
        const double u = steps > 0 ? double(i) / steps : 0, v = steps > 0 ? double(j) / steps : 0;
        if (const std::int64_t at = cell(a + (b - a) * u + (c - a) * v); at >= 0)
          cells_[static_cast<std::size_t>(at)] = 1;
      }
  }

  WorldPoint low_;
  double edge_;
  std::array<std::int64_t, 3> size_{};
  std::vector<std::uint8_t> cells_;
};

double share_on(const SurfaceCells& cells, std::span<const WorldPoint> points, const WorldPoint& shift) {
  const auto on = std::ranges::count_if(points, [&](const WorldPoint& p) { return cells.has(p - shift); });
  return static_cast<double>(on) / static_cast<double>(points.size());
}

// The best of some moves; of equally good ones the first.
WorldPoint best_of(const SurfaceCells& cells, std::span<const WorldPoint> points, std::span<const WorldPoint> moves) {
  std::vector<double> shares(moves.size());
  tbb::parallel_for(std::size_t{0}, moves.size(),
                    [&](std::size_t n) { shares[n] = share_on(cells, points, moves[n]); });
  return moves[static_cast<std::size_t>(std::ranges::max_element(shares) - shares.begin())];
}

// Those that differ from `from` by up to `reach` steps along each axis.
std::vector<WorldPoint> moves_around(const WorldPoint& from, double step, int reach) {
  std::vector<WorldPoint> moves;
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) moves.push_back(from + WorldPoint{x * step, y * step, z * step});
  return moves;
}

}  // namespace

std::optional<MeshShift> find_shift(const Mesh& mesh, std::span<const io::TiePoint> points) {
  // A share of a half has a standard error of 0.035 then.
  constexpr std::size_t kLeastPoints = 200, kMostPoints = 1000;
  if (points.size() < kLeastPoints) return std::nullopt;
  std::vector<WorldPoint> sample;
  const std::size_t count = std::min(kMostPoints, points.size());
  for (std::size_t i = 0; i < count; ++i) sample.push_back(points[i * points.size() / count].position);
  const Box box = box_of(mesh);
  const double size = std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
  if (!(size > 0)) return std::nullopt;
  // From moves of a fiftieth within a fifth, halved three times. Heights above the geoid differ by up to 107 m from those
  // above the ellipsoid, so heights alone may differ by twice the size of a small site.
  constexpr int kReach = 10, kHeights = 100, kHalvings = 3;
  double step = size / 50;
  std::vector<WorldPoint> moves = moves_around({}, step, kReach);
  for (int z = kReach + 1; z <= kHeights; ++z)
    for (const double height : {-z * step, z * step}) moves.push_back({0, 0, height});
  WorldPoint by = best_of(SurfaceCells(mesh, box, step), sample, moves);
  for (int halving = 0; halving < kHalvings; ++halving) {
    step /= 2;
    by = best_of(SurfaceCells(mesh, box, step), sample, moves_around(by, step, 2));
  }
  const SurfaceCells finest(mesh, box, step);
  const MeshShift shift{by, share_on(finest, sample, by), share_on(finest, sample, {})};
  constexpr double kLeastShare = 0.5, kClearly = 2;
  return shift.share >= kLeastShare && shift.share >= kClearly * shift.share_as_is ? std::optional(shift)
                                                                                   : std::nullopt;
}

}  // namespace gpvc::checks
