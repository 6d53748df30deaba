// select_views: from costs to labels, coarse to fine, and the figures of the result.
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <functional>
#include <stdexcept>

#include "io/clock.h"
#include "labeling/labeling.h"
#include "labeling/solver/coarsening.h"
#include "labeling/solver/expansion.h"
#include "labeling/solver/patches.h"

namespace gpvc::labeling {
namespace {

/// Labels per batch. A larger batch uses more cores and wastes more cuts.
constexpr std::size_t kBatch = 8;
constexpr std::size_t kClusterSize = 4;
constexpr std::size_t kMaxDirectNodes = 2000;  ///< problems up to this size are solved without a coarser start
constexpr int kCoarseSweeps = 8;

bool differ(std::span<const ViewId> labels, const std::array<std::uint32_t, 2>& pair) {
  const ViewId a = labels[pair[0]], b = labels[pair[1]];
  return a != kNoView && b != kNoView && a != b;
}

double pair_weight(const FaceGraph& graph, std::size_t pair) {
  return graph.weights.empty() ? 1.0 : static_cast<double>(graph.weights[pair]);
}

/// Labels to improve, and how.
struct Start {
  std::vector<std::uint32_t> labels;
  bool is_good = false;  ///< only borders need to be looked at
};

/// Called after every sweep.
using AfterSweep = std::function<void()>;

/// Sweeps along borders after a good start, over whole graphs otherwise. Ends when nothing changes: after a good start only
/// `thorough` then goes on with whole graphs, to a fixpoint.
void improve(const LabelProblem& problem, bool good_start, bool thorough, int max_sweeps,
             std::vector<std::uint32_t>& labels, const AfterSweep& after_sweep) {
  Expander expander(problem, labels, kBatch);
  bool borders = good_start;
  for (int sweep = 0; sweep < max_sweeps && !expander.is_fixpoint(); ++sweep) {
    const std::size_t changes = borders ? expander.sweep_borders() : expander.sweep();
    if (after_sweep) after_sweep();
    if (changes == 0 && good_start && !thorough) return;
    borders = changes > 0;
  }
}

/// The solution of a coarser problem, which is found in the same way; each node's cheapest label where the problem is
/// small, or where its nodes form no clusters.
Start start_labels(const LabelProblem& problem) {
  if (problem.nodes() > kMaxDirectNodes) {
    const CoarseProblem coarse = coarsen(problem, kClusterSize);
    // Clusters of less than two nodes on average are not worth solving first.
    if (2 * coarse.problem.nodes() <= problem.nodes()) {
      Start start = start_labels(coarse.problem);
      improve(coarse.problem, start.is_good, false, kCoarseSweeps, start.labels, {});
      return {refine_labels(problem, coarse, start.labels), true};
    }
  }
  return {cheapest_labels(problem), false};
}

/// The given labels where they are candidates, else the cheapest.
std::vector<std::uint32_t> candidates_of(const LabelProblem& problem, std::span<const ViewId> given) {
  std::vector<std::uint32_t> labels = cheapest_labels(problem);
  for (std::size_t node = 0; node < labels.size(); ++node) {
    const auto label = static_cast<std::uint32_t>(given[node]);
    if (find_candidate(problem, node, label) != kNoCandidate) labels[node] = label;
  }
  return labels;
}

std::vector<ViewId> view_ids(const std::vector<std::uint32_t>& labels) {
  std::vector<ViewId> views(labels.size());
  std::transform(labels.begin(), labels.end(), views.begin(), [](std::uint32_t label) { return ViewId{label}; });
  return views;
}

std::vector<WeightedPair> weighted_pairs(const FaceGraph& graph, double smoothness) {
  std::vector<WeightedPair> pairs;
  pairs.reserve(graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i)
    pairs.push_back({graph.edges[i][0], graph.edges[i][1], static_cast<float>(smoothness * pair_weight(graph, i))});
  return pairs;
}

/// The table in which each fixed face has its fixed view as its only candidate. No label but that can then be given to it.
CostTable with_fixed_labels(const CostTable& table, std::span<const ViewId> fixed) {
  CostTable result;
  result.first.reserve(table.first.size());
  result.first.push_back(0);
  for (std::size_t face = 0; face < table.faces(); ++face) {
    const std::span<const std::uint32_t> views = table.views_of(face);
    const std::span<const float> costs = table.costs_of(face);
    const auto fixed_view = static_cast<std::uint32_t>(fixed[face]);
    if (fixed[face] == kNoView) {
      result.views.insert(result.views.end(), views.begin(), views.end());
      result.costs.insert(result.costs.end(), costs.begin(), costs.end());
    } else {
      const auto own = std::find(views.begin(), views.end(), fixed_view);
      result.views.push_back(fixed_view);
      result.costs.push_back(own == views.end() ? 0.0f : costs[static_cast<std::size_t>(own - views.begin())]);
    }
    result.first.push_back(result.views.size());
  }
  return result;
}

}  // namespace

double labeling_energy(const CostTable& table, const FaceGraph& graph, std::span<const ViewId> labels,
                       double smoothness) {
  double energy = 0;
  for (std::size_t face = 0; face < table.faces(); ++face)
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i)
      if (table.views[i] == index(labels[face])) energy += static_cast<double>(table.costs[i]);
  double seams = 0;
  for (std::size_t i = 0; i < graph.edges.size(); ++i)
    if (differ(labels, graph.edges[i])) seams += pair_weight(graph, i);
  return energy + smoothness * seams;
}

Selection select_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                       const Progress& progress, std::span<const ViewId> fixed, std::span<const ViewId> start) {
  const auto begin = Clock::now();
  if (!fixed.empty()) {
    if (fixed.size() != table.faces())
      throw std::invalid_argument("select_views: expected a fixed view per face, or none");
    return select_views(with_fixed_labels(table, fixed), graph, options, progress, {}, start);
  }
  if (!start.empty() && start.size() != table.faces())
    throw std::invalid_argument("select_views: expected a view per face to start with, or none");
  const LabelProblem problem = make_problem(table, weighted_pairs(graph, options.smoothness));
  Start given = start.empty() ? start_labels(problem) : Start{candidates_of(problem, start), true};
  std::vector<std::uint32_t>& labels = given.labels;

  Selection result;
  const auto report = [&] {
    const auto sweep = static_cast<int>(result.sweeps.size());
    result.sweeps.push_back(
        {sweep, static_cast<double>(fixed_energy(problem, labels)) / problem.scale, seconds_since(begin)});
    if (progress) progress(static_cast<std::size_t>(sweep), static_cast<std::size_t>(options.max_sweeps));
  };
  report();
  improve(problem, given.is_good, options.thorough, options.max_sweeps, labels, report);
  result.merged_patches = merge_small_patches(problem, static_cast<std::size_t>(options.small_patch_faces),
                                              options.small_patch_rise, labels);
  result.labels = view_ids(labels);
  tbb::parallel_invoke([&] { result.energy = labeling_energy(table, graph, result.labels, options.smoothness); },
                       [&] {
                         for (const auto& pair : graph.edges) result.differing_pairs += differ(result.labels, pair);
                         for_each_patch(problem, labels, [&](std::span<const std::uint32_t>) { ++result.patches; });
                       });
  return result;
}

}  // namespace gpvc::labeling
