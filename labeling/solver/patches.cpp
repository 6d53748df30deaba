#include "labeling/solver/patches.h"

#include <algorithm>
#include <optional>

namespace gpvc::labeling {
namespace {

/// Cost of the patch, all of one label, if it had `label` instead, without the pairs inside the patch. No value if one of
/// its nodes lacks that candidate.
std::optional<Capacity> cost_with(const LabelProblem& problem, std::span<const std::uint32_t> patch,
                                  std::span<const std::uint32_t> labels, std::uint32_t label) {
  Capacity cost = 0;
  for (const std::uint32_t node : patch) {
    const std::span<const std::uint32_t> candidates = problem.labels_of(node);
    const auto found = std::lower_bound(candidates.begin(), candidates.end(), label);
    if (found == candidates.end() || *found != label) return std::nullopt;
    cost += problem.fixed(problem.costs_of(node)[static_cast<std::size_t>(found - candidates.begin())]);
    for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node]) {
      const bool inside = std::find(patch.begin(), patch.end(), neighbour.node) != patch.end();
      if (!inside && labels[neighbour.node] != label) cost += problem.fixed_weight(neighbour.weight);
    }
  }
  return cost;
}

}  // namespace

std::size_t merge_small_patches(const LabelProblem& problem, std::size_t max_nodes, double max_rise,
                                std::vector<std::uint32_t>& labels) {
  const auto allowed = static_cast<Capacity>(max_rise * problem.scale);
  std::size_t merged = 0;
  std::vector<std::uint32_t> around;
  for_each_patch(problem, labels, [&](std::span<const std::uint32_t> patch) {
    if (patch.size() > max_nodes) return;
    const std::uint32_t own = labels[patch[0]];
    around.clear();
    for (const std::uint32_t node : patch)
      for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node])
        if (labels[neighbour.node] != own) around.push_back(labels[neighbour.node]);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    Capacity best = *cost_with(problem, patch, labels, own) + allowed;
    std::uint32_t best_label = own;
    for (const std::uint32_t label : around)
      if (const auto cost = cost_with(problem, patch, labels, label); cost && *cost <= best) {
        // A later label must cost less, so that the lowest of equal ones is taken.
        best = *cost - 1;
        best_label = label;
      }
    if (best_label == own) return;
    for (const std::uint32_t node : patch) labels[node] = best_label;
    ++merged;
  });
  return merged;
}

}  // namespace gpvc::labeling
