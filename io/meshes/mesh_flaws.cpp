// Counts flaws of a mesh: degenerate and repeated faces, unused vertices.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "io/mesh.h"
#include "io/vector.h"

namespace gpvc::io {

namespace {

bool has_no_area(const Mesh& mesh, const Triangle& face) {
  const WorldPoint& a = mesh.positions[face[0]];
  return cross(mesh.positions[face[1]] - a, mesh.positions[face[2]] - a) == WorldPoint{};
}

/// How many items equal the one before them, once sorted by `less`.
template <typename Item, typename Less>
std::size_t repeated(std::vector<Item>& items, const Less& less) {
  std::sort(items.begin(), items.end(), less);
  std::size_t count = 0;
  for (std::size_t i = 1; i < items.size(); ++i) count += !less(items[i - 1], items[i]) ? 1 : 0;
  return count;
}

}  // namespace

MeshFlaws mesh_flaws(const Mesh& mesh) {
  MeshFlaws flaws;
  std::vector<bool> used(mesh.positions.size(), false);
  std::vector<Triangle> sorted = mesh.faces;
  for (Triangle& face : sorted) {
    for (const std::uint32_t v : face) used[v] = true;
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0])
      ++flaws.degenerate_faces;
    else if (has_no_area(mesh, face))
      ++flaws.flat_faces;
    std::sort(face.begin(), face.end());
  }
  flaws.duplicate_faces = repeated(sorted, std::less<Triangle>());
  flaws.unreferenced_vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  std::vector<std::uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  flaws.duplicate_vertices = repeated(order, [&](std::uint32_t a, std::uint32_t b) {
    const WorldPoint &p = mesh.positions[a], &q = mesh.positions[b];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  });
  return flaws;
}

}  // namespace gpvc::io
