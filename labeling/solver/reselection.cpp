// reselect_views: labels anew where candidates have changed, and around there.
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "io/clock.h"
#include "io/grouping.h"
#include "labeling/labeling.h"
#include "labeling/solver/expansion.h"
#include "labeling/solver/patches.h"

namespace gpvc::labeling {
namespace {

static_assert(kReselectEdges == kReach);

constexpr int kFar = std::numeric_limits<int>::max();

/// Edges from each face to the nearest changed one, as far as the faces around free ones; kFar beyond.
std::vector<int> edges_to_changed(std::size_t faces, const FaceGraph& graph, std::span<const FaceId> changed) {
  const Grouped<std::uint32_t> neighbours = group_neighbours(faces, graph.edges);
  std::vector<int> distance(faces, kFar);
  std::vector<std::uint32_t> queue;
  for (const FaceId face : changed) {
    distance[index(face)] = 0;
    queue.push_back(static_cast<std::uint32_t>(index(face)));
  }
  for (std::size_t next = 0; next < queue.size(); ++next) {
    const int reached = distance[queue[next]] + 1;
    if (reached > kReselectEdges + 1) break;
    for (const std::uint32_t other : neighbours[queue[next]]) {
      if (distance[other] != kFar) continue;
      distance[other] = reached;
      queue.push_back(other);
    }
  }
  return distance;
}

/// The problem of the free faces and those around them, with their numbers in the mesh.
struct PartProblem {
  std::vector<std::uint32_t> faces;
  CostTable table;
  FaceGraph graph;
  std::vector<ViewId> around, unchanged;  ///< labels to keep: of the faces around free ones; of all unchanged ones
};

PartProblem make_part(const CostTable& table, const FaceGraph& graph, std::span<const ViewId> before,
                      std::span<const int> distance) {
  PartProblem part;
  std::vector<std::uint32_t> number(distance.size(), 0);
  part.table.first.push_back(0);
  for (std::uint32_t face = 0; face < distance.size(); ++face) {
    if (distance[face] == kFar) continue;
    number[face] = static_cast<std::uint32_t>(part.faces.size());
    part.faces.push_back(face);
    const bool is_free = distance[face] <= kReselectEdges;
    if (is_free) {
      const auto views = table.views_of(face);
      const auto costs = table.costs_of(face);
      part.table.views.insert(part.table.views.end(), views.begin(), views.end());
      part.table.costs.insert(part.table.costs.end(), costs.begin(), costs.end());
    }
    part.table.first.push_back(part.table.views.size());
    part.around.push_back(is_free ? kNoView : before[face]);
    part.unchanged.push_back(distance[face] == 0 ? kNoView : before[face]);
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const auto& [a, b] = graph.edges[i];
    if (distance[a] == kFar || distance[b] == kFar) continue;
    part.graph.edges.push_back({number[a], number[b]});
    if (!graph.weights.empty()) part.graph.weights.push_back(graph.weights[i]);
  }
  return part;
}

/// Replaces the labels of the free faces.
void solve_part(const CostTable& table, const FaceGraph& graph, const SolverOptions& options, const Progress& progress,
                std::span<const FaceId> changed, Reselection& result) {
  const std::vector<int> distance = edges_to_changed(table.faces(), graph, changed);
  const PartProblem part = make_part(table, graph, result.selection.labels, distance);
  const Selection first = select_views(part.table, part.graph, options, {}, part.unchanged);
  Selection last = select_views(part.table, part.graph, options, progress, part.around, first.labels);
  for (std::size_t n = 0; n < part.faces.size(); ++n) {
    result.selection.labels[part.faces[n]] = last.labels[n];
    result.free_faces += distance[part.faces[n]] <= kReselectEdges ? 1 : 0;
  }
  result.selection.merged_patches = first.merged_patches + last.merged_patches;
  result.selection.sweeps = std::move(last.sweeps);
}

/// Energy, pairs and patches of all labels.
void measure(const CostTable& table, const FaceGraph& graph, double smoothness, Selection& selection) {
  selection.energy = labeling_energy(table, graph, selection.labels, smoothness);
  for (const auto& [a, b] : graph.edges) {
    const ViewId here = selection.labels[a], there = selection.labels[b];
    if (here != kNoView && there != kNoView && here != there) ++selection.differing_pairs;
  }
  const Grouped<std::uint32_t> neighbours = group_neighbours(selection.labels.size(), graph.edges);
  const auto for_neighbours = [&](std::uint32_t face, const auto& reach) {
    for (const std::uint32_t other : neighbours[face]) reach(other);
  };
  for_each_patch(std::span<const ViewId>(selection.labels), kNoView, for_neighbours,
                 [&](std::span<const std::uint32_t>) { ++selection.patches; });
}

}  // namespace

Reselection reselect_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                           const Progress& progress, std::span<const ViewId> before, std::span<const FaceId> changed) {
  if (before.size() != table.faces()) throw std::invalid_argument("reselect_views: expected a view per face");
  Reselection result;
  result.selection.labels.assign(before.begin(), before.end());
  if (!changed.empty()) solve_part(table, graph, options, progress, changed, result);
  measure(table, graph, options.smoothness, result.selection);
  return result;
}

}  // namespace gpvc::labeling
