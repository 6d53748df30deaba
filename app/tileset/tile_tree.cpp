#include "app/tileset/tile_tree.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "app/tileset/simplify.h"
#include "io/grouping.h"
#include "io/vector.h"

namespace gpvc::tileset {
namespace {

constexpr std::size_t kChildren = 4;

// Three times a face's middle, on the two axes of the ground.
using GroundPoint = std::array<double, 2>;

std::vector<GroundPoint> middles_on_ground(const Mesh& mesh, io::UpAxis up) {
  const auto vertical = static_cast<std::size_t>(up) / 2;  // of UpAxis, two values an axis
  std::vector<GroundPoint> middles(mesh.faces.size());
  tbb::parallel_for(std::size_t{0}, middles.size(), [&](std::size_t f) {
    std::array<double, 3> sum{};
    for (const std::uint32_t v : mesh.faces[f]) {
      const WorldPoint& p = mesh.positions[v];
      sum = {sum[0] + p.x, sum[1] + p.y, sum[2] + p.z};
    }
    middles[f] = {sum[vertical == 0 ? 1 : 0], sum[vertical == 2 ? 1 : 2]};
  });
  return middles;
}

class Divider {
 public:
  explicit Divider(std::vector<GroundPoint> middles) : middles_(std::move(middles)), leaf_(middles_.size(), 0) {}

  std::vector<std::uint32_t> divide(int depth, std::size_t leaves) {
    std::vector<std::uint32_t> faces(middles_.size());
    std::iota(faces.begin(), faces.end(), 0u);
    divide(faces, 0, 2 * depth, leaves);
    return std::move(leaf_);
  }

 private:
  // \param halvings of the tree still to be made \param leaves to divide the faces among
  void divide(std::span<std::uint32_t> faces, std::uint32_t number, int halvings, std::size_t leaves) {
    if (halvings == 0) {
      for (const std::uint32_t face : faces) leaf_[face] = number;
      return;
    }
    const std::size_t first = (leaves + 1) / 2, part = faces.size() * first / leaves;
    if (first == leaves) return divide(faces, 2 * number, halvings - 1, leaves);
    const std::size_t axis = longer_axis(faces);
    // Faces of one middle are told apart by their number, so that the result does not depend on the order here.
    std::ranges::nth_element(faces, faces.begin() + static_cast<std::ptrdiff_t>(part), {},
                             [&](std::uint32_t face) { return std::pair(middles_[face][axis], face); });
    tbb::parallel_invoke([&] { divide(faces.first(part), 2 * number, halvings - 1, first); },
                         [&] { divide(faces.subspan(part), 2 * number + 1, halvings - 1, leaves - first); });
  }

  std::size_t longer_axis(std::span<const std::uint32_t> faces) const {
    std::array<double, 2> low{}, high{};
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (const std::uint32_t face : faces)
      for (std::size_t a = 0; a < 2; ++a) {
        low[a] = std::min(low[a], middles_[face][a]);
        high[a] = std::max(high[a], middles_[face][a]);
      }
    return high[0] - low[0] >= high[1] - low[1] ? 0 : 1;
  }

  std::vector<GroundPoint> middles_;
  std::vector<std::uint32_t> leaf_;
};

// Leaves out the vertices of no face. \param kept the vertices of the others
Mesh compact(const Mesh& all, std::vector<Triangle> faces, std::vector<std::uint32_t>& kept) {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
  std::vector<std::uint32_t> place(all.positions.size(), kUnused);
  for (const Triangle& face : faces)
    for (const std::uint32_t v : face) place[v] = 0;
  Mesh mesh;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] == kUnused) continue;
    place[v] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(all.positions[v]);
    kept.push_back(static_cast<std::uint32_t>(v));
  }
  for (Triangle& face : faces)
    for (std::uint32_t& v : face) v = place[v];
  mesh.faces = std::move(faces);
  return mesh;
}

}  // namespace

std::size_t leaf_count(std::size_t faces, std::size_t faces_per_tile) {
  const std::size_t most = std::max<std::size_t>(1, faces_per_tile);
  return std::max<std::size_t>(1, (faces + most - 1) / most);
}

int tree_depth(std::size_t leaves) {
  int depth = 0;
  for (std::size_t places = 1; places < leaves; places *= kChildren) ++depth;
  return depth;
}

std::vector<std::uint32_t> leaf_of_faces(const Mesh& mesh, io::UpAxis up, std::size_t leaves) {
  return Divider(middles_on_ground(mesh, up)).divide(tree_depth(leaves), leaves);
}

LevelMesh coarser_level(const Mesh& finer, std::span<const std::uint32_t> tile, std::span<const double> error) {
  const std::size_t tiles = error.size() / kChildren;
  const Grouped<std::uint32_t> children = group_items<std::uint32_t>(tiles, [&](const auto& add) {
    for (std::uint32_t f = 0; f < tile.size(); ++f) add(tile[f] / kChildren, f);
  });
  std::vector<Simplified> made(tiles);
  tbb::parallel_for(std::size_t{0}, tiles, [&](std::size_t t) { made[t] = simplified(finer, children[t]); });
  LevelMesh level;
  std::vector<Triangle> faces;
  for (std::size_t t = 0; t < tiles; ++t) {
    faces.insert(faces.end(), made[t].faces.begin(), made[t].faces.end());
    level.tile.insert(level.tile.end(), made[t].faces.size(), static_cast<std::uint32_t>(t));
    level.error.push_back(made[t].error +
                          *std::max_element(error.begin() + static_cast<std::ptrdiff_t>(kChildren * t),
                                            error.begin() + static_cast<std::ptrdiff_t>(kChildren * (t + 1))));
  }
  level.mesh = compact(finer, std::move(faces), level.vertex);
  return level;
}

}  // namespace gpvc::tileset
