// Weights the pairs of the face adjacency graph by the shape of the mesh.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "labeling/labeling.h"

namespace gpvc::labeling {
namespace {

constexpr double kMaxLength = 4, kMinFold = 0.05;

glm::dvec3 at(const Mesh& mesh, std::uint32_t vertex) {
  const WorldPoint& p = mesh.positions[vertex];
  return {p.x, p.y, p.z};
}

/// Distance of two corners that the faces share; of the first two where they share three.
double shared_length(const Mesh& mesh, const Triangle& a, const Triangle& b) {
  std::array<std::uint32_t, 3> shared{};
  std::size_t count = 0;
  for (const std::uint32_t vertex : a)
    if (std::find(b.begin(), b.end(), vertex) != b.end()) shared[count++] = vertex;
  return count < 2 ? 0 : glm::distance(at(mesh, shared[0]), at(mesh, shared[1]));
}

glm::dvec3 normal(const Mesh& mesh, const Triangle& face) {
  const glm::dvec3 origin = at(mesh, face[0]);
  const glm::dvec3 n = glm::cross(at(mesh, face[1]) - origin, at(mesh, face[2]) - origin);
  const double length = glm::length(n);
  return length > 0 ? n / length : glm::dvec3(0);
}

/// Degenerate faces have no normal; their pairs count as half folded.
double flatness(const Mesh& mesh, const Triangle& a, const Triangle& b) {
  return std::max(kMinFold, (1 + glm::dot(normal(mesh, a), normal(mesh, b))) / 2);
}

}  // namespace

void weigh_edges(const Mesh& mesh, EdgeWeights weights, FaceGraph& graph) {
  graph.weights.clear();
  if (weights == EdgeWeights::uniform) return;
  const bool by_length = weights != EdgeWeights::dihedral, by_fold = weights != EdgeWeights::length;
  std::vector<double> lengths(graph.edges.size(), 1.0);
  graph.weights.resize(graph.edges.size());
  const auto each_pair = [&](const auto& visit) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, graph.edges.size(), 4096), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        visit(i, mesh.faces[graph.edges[i][0]], mesh.faces[graph.edges[i][1]]);
    });
  };
  double mean = 0;
  if (by_length) {
    each_pair([&](std::size_t i, const Triangle& a, const Triangle& b) { lengths[i] = shared_length(mesh, a, b); });
    for (const double length : lengths)
      mean += length / static_cast<double>(lengths.size());  // not in parallel: the sum depends on the order
  }
  each_pair([&](std::size_t i, const Triangle& a, const Triangle& b) {
    const double length = mean > 0 ? std::min(kMaxLength, lengths[i] / mean) : 1.0;
    graph.weights[i] = static_cast<float>(length * (by_fold ? flatness(mesh, a, b) : 1.0));
  });
}

}  // namespace gpvc::labeling
