// Finds faces that share an edge by grouping half-edges by their lower vertex: almost linear work, no hashing, and an
// order that does not depend on threads.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "io/grouping.h"
#include "io/validate.h"
#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

/// A triangle's edge seen from its lower vertex.
struct HalfEdge {
  std::uint32_t other_vertex;
  std::uint32_t face;
  auto operator<=>(const HalfEdge&) const = default;
};

/// Ascending within a vertex; without edges from a vertex to itself.
Grouped<HalfEdge> half_edges_by_lower_vertex(const Mesh& mesh) {
  const auto add_edges = [&](std::size_t face, const auto& add) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t a = mesh.faces[face][corner], b = mesh.faces[face][(corner + 1) % 3];
      if (a != b) add(std::min(a, b), HalfEdge{std::max(a, b), static_cast<std::uint32_t>(face)});
    }
  };
  auto half_edges = group_numbered<HalfEdge>(mesh.positions.size(), mesh.faces.size(), add_edges);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, half_edges.groups(), 4096), [&](const auto& vertices) {
    for (std::size_t vertex = vertices.begin(); vertex != vertices.end(); ++vertex)
      std::sort(half_edges[vertex].begin(), half_edges[vertex].end());
  });
  return half_edges;
}

/// Calls visit(lower face, higher face) for the pairs of faces around each edge of one vertex that are kFaceGraphReach
/// apart at most. A face that has the edge twice (its third vertex is one of the edge's) counts once.
template <class Visit>
void for_each_pair(std::span<const HalfEdge> half_edges, Visit visit) {
  const auto repeats = [&](std::size_t i) { return i > 0 && half_edges[i] == half_edges[i - 1]; };
  for (std::size_t i = 0; i < half_edges.size(); ++i) {
    if (repeats(i)) continue;
    std::size_t reached = 0;
    for (std::size_t j = i + 1; j < half_edges.size() && reached < kFaceGraphReach; ++j) {
      if (half_edges[j].other_vertex != half_edges[i].other_vertex) break;
      if (repeats(j)) continue;
      visit(half_edges[i].face, half_edges[j].face);
      ++reached;
    }
  }
}

}  // namespace

FaceGraph face_graph(const Mesh& mesh) {
  validate_faces(mesh);
  const Grouped<HalfEdge> half_edges = half_edges_by_lower_vertex(mesh);
  // Grouped by lower face and sorted, the pairs are in ascending order.
  auto higher_faces = group_numbered<std::uint32_t>(
      mesh.faces.size(), half_edges.groups(),
      [&](std::size_t vertex, const auto& add) { for_each_pair(half_edges[vertex], add); });
  FaceGraph graph;
  graph.edges.reserve(higher_faces.items.size());
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    const std::span<std::uint32_t> others = higher_faces[face];
    std::sort(others.begin(), others.end());
    const auto end = std::unique(others.begin(), others.end());
    for (auto other = others.begin(); other != end; ++other) graph.edges.push_back({face, *other});
  }
  return graph;
}

}  // namespace gpvc::labeling
