// Faces that share an edge, found by bucketing half-edges by their lower vertex: linear work, no hashing, and an order
// that no thread can disturb.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "labeling/labeling.h"
#include "labeling/offsets.h"

namespace gpvc::labeling {
namespace {

/// A triangle's edge seen from its lower vertex.
struct HalfEdge {
  std::uint32_t other_vertex;
  std::uint32_t face;
  auto operator<=>(const HalfEdge&) const = default;
};

/// Calls visit(lower vertex, higher vertex) for the edges of a triangle; one from a vertex to itself is none.
template <class Visit>
void for_each_edge(const Triangle& triangle, Visit visit) {
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t a = triangle[corner], b = triangle[(corner + 1) % 3];
    if (a != b) visit(std::min(a, b), std::max(a, b));
  }
}

/// Turns counts (one bucket each, a spare at the end) into the buckets' first offsets.
template <class Body>
void parallel_over(std::size_t count, Body body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
  });
}

struct Buckets {
  std::vector<std::size_t> first;  ///< buckets + 1
  std::vector<HalfEdge> items;     ///< ascending within a bucket
};

Buckets half_edges_by_lower_vertex(const Mesh& mesh) {
  Buckets buckets;
  buckets.first.assign(mesh.positions.size() + 1, 0);
  for (const Triangle& triangle : mesh.faces)
    for_each_edge(triangle, [&](std::uint32_t low, std::uint32_t) { ++buckets.first[low]; });
  buckets.items.resize(offsets_from_counts(buckets.first));
  std::vector<std::size_t> next = buckets.first;
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face)
    for_each_edge(mesh.faces[face], [&](std::uint32_t low, std::uint32_t high) {
      buckets.items[next[low]++] = {high, face};
    });
  parallel_over(mesh.positions.size(), [&](std::size_t vertex) {
    std::sort(buckets.items.begin() + static_cast<std::ptrdiff_t>(buckets.first[vertex]),
              buckets.items.begin() + static_cast<std::ptrdiff_t>(buckets.first[vertex + 1]));
  });
  return buckets;
}

/// Calls visit(lower face, higher face) for consecutive faces around each edge of one bucket. A face that has the edge
/// twice (its third vertex is one of the edge's) counts once.
template <class Visit>
void for_each_pair(const HalfEdge* begin, const HalfEdge* end, Visit visit) {
  for (const HalfEdge* item = begin; item + 1 < end; ++item)
    if (item[0].other_vertex == item[1].other_vertex && item[0].face != item[1].face) visit(item[0].face, item[1].face);
}

}  // namespace

FaceGraph face_graph(const Mesh& mesh) {
  const Buckets buckets = half_edges_by_lower_vertex(mesh);
  const auto bucket_begin = [&](std::size_t vertex) { return buckets.items.data() + buckets.first[vertex]; };

  // The same trick once more, by lower face, puts the pairs in ascending order.
  std::vector<std::size_t> first(mesh.faces.size() + 1, 0);
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex)
    for_each_pair(bucket_begin(vertex), bucket_begin(vertex + 1),
                  [&](std::uint32_t low, std::uint32_t) { ++first[low]; });
  std::vector<std::uint32_t> higher(offsets_from_counts(first));
  std::vector<std::size_t> next = first;
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex)
    for_each_pair(bucket_begin(vertex), bucket_begin(vertex + 1),
                  [&](std::uint32_t low, std::uint32_t high) { higher[next[low]++] = high; });

  FaceGraph graph;
  graph.edges.reserve(higher.size());
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    const auto begin = higher.begin() + static_cast<std::ptrdiff_t>(first[face]);
    const auto end = higher.begin() + static_cast<std::ptrdiff_t>(first[face + 1]);
    std::sort(begin, end);
    for (auto it = begin; it != end; ++it)
      if (it == begin || *it != it[-1]) graph.edges.push_back({face, *it});
  }
  return graph;
}

}  // namespace gpvc::labeling
