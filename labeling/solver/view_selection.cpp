// select_views: from costs to labels, coarse to fine, and what is to be said about the result.
#include <algorithm>

#include "io/clock.h"
#include "labeling/labeling.h"
#include "labeling/solver/coarsening.h"
#include "labeling/solver/expansion.h"
#include "labeling/solver/patches.h"

namespace gpvc::labeling {
namespace {

/// Labels that one batch cuts at a time on the full graph. More would use more cores and waste more cuts.
constexpr std::size_t kBatch = 8;
constexpr std::size_t kClusterSize = 16;
constexpr std::size_t kSmallEnough = 2000;  ///< nodes that need no coarser start
constexpr int kCoarseSweeps = 8;

std::size_t count_patches(const LabelProblem& problem, std::span<const std::uint32_t> labels) {
  std::size_t patches = 0;
  for_each_patch(problem, labels, [&](std::span<const std::uint32_t>) { ++patches; });
  return patches;
}

std::size_t count_differing_pairs(const FaceGraph& graph, std::span<const ViewId> labels) {
  std::size_t differing = 0;
  for (const auto& [a, b] : graph.edges)
    differing += labels[a] != kNoView && labels[b] != kNoView && labels[a] != labels[b];
  return differing;
}

double pair_weight(const FaceGraph& graph, std::size_t pair) {
  return graph.weights.empty() ? 1.0 : static_cast<double>(graph.weights[pair]);
}

/// Solves a chain of smaller problems, the smallest first, each from the one before.
std::vector<std::uint32_t> coarse_start(const LabelProblem& problem) {
  if (problem.nodes() <= kSmallEnough) return cheapest_labels(problem);
  const CoarseProblem coarse = coarsen(problem, kClusterSize);
  // Clusters hardly smaller than nodes: nothing to gain.
  if (2 * coarse.problem.nodes() > problem.nodes()) return cheapest_labels(problem);
  std::vector<std::uint32_t> labels = coarse_start(coarse.problem);
  Expander expander(coarse.problem, labels, 1);
  for (int sweep = 0; sweep < kCoarseSweeps && !expander.is_fixpoint(); ++sweep) expander.sweep();
  return refine_labels(problem, coarse, labels);
}

std::vector<ViewId> view_ids(const std::vector<std::uint32_t>& labels) {
  std::vector<ViewId> views(labels.size());
  std::transform(labels.begin(), labels.end(), views.begin(), [](std::uint32_t label) { return ViewId{label}; });
  return views;
}

}  // namespace

double labeling_energy(const CostTable& table, const FaceGraph& graph, std::span<const ViewId> labels,
                       double smoothness) {
  double energy = 0;
  for (std::size_t face = 0; face < table.faces(); ++face)
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i)
      if (table.views[i] == index(labels[face])) energy += static_cast<double>(table.costs[i]);
  if (graph.weights.empty()) return energy + smoothness * static_cast<double>(count_differing_pairs(graph, labels));
  double seams = 0;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const auto [a, b] = graph.edges[i];
    if (labels[a] != kNoView && labels[b] != kNoView && labels[a] != labels[b]) seams += pair_weight(graph, i);
  }
  return energy + smoothness * seams;
}

Selection select_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                       const Progress& progress) {
  const auto start = Clock::now();
  std::vector<WeightedPair> pairs;
  pairs.reserve(graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i)
    pairs.push_back(
        {graph.edges[i][0], graph.edges[i][1], static_cast<float>(options.smoothness * pair_weight(graph, i))});
  const LabelProblem problem = make_problem(table.first, table.views, table.costs, pairs);
  pairs = {};
  std::vector<std::uint32_t> labels = coarse_start(problem);

  Selection result;
  const auto report = [&](int sweep) {
    result.labels = view_ids(labels);
    result.sweeps.push_back(
        {sweep, labeling_energy(table, graph, result.labels, options.smoothness), seconds_since(start)});
    if (progress) progress(static_cast<std::size_t>(sweep), static_cast<std::size_t>(options.max_sweeps));
  };
  report(0);
  Expander expander(problem, labels, kBatch);
  for (int sweep = 1; sweep <= options.max_sweeps && !expander.is_fixpoint(); ++sweep) {
    expander.sweep();
    report(sweep);
  }
  result.merged_patches = merge_small_patches(problem, static_cast<std::size_t>(options.small_patch_faces),
                                              options.small_patch_rise, labels);
  result.labels = view_ids(labels);
  result.energy = labeling_energy(table, graph, result.labels, options.smoothness);
  result.differing_pairs = count_differing_pairs(graph, result.labels);
  result.patches = count_patches(problem, labels);
  return result;
}

}  // namespace gpvc::labeling
