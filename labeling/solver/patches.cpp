#include "labeling/solver/patches.h"

#include <algorithm>
#include <optional>

namespace gpvc::labeling {
namespace {

/// What the patch, connected and of one label, costs with `label` instead, pairs within it left out.
std::optional<Capacity> cost_with(const LabelProblem& problem, std::span<const std::uint32_t> patch,
                                  std::span<const std::uint32_t> labels, std::uint32_t label) {
  Capacity cost = 0;
  for (const std::uint32_t node : patch) {
    const auto begin = problem.labels.begin() + static_cast<std::ptrdiff_t>(problem.first[node]);
    const auto end = problem.labels.begin() + static_cast<std::ptrdiff_t>(problem.first[node + 1]);
    const auto found = std::lower_bound(begin, end, label);
    if (found == end || *found != label) return std::nullopt;
    cost += problem.fixed(problem.costs[static_cast<std::size_t>(found - problem.labels.begin())]);
    for (std::size_t k = problem.neighbour_first[node]; k < problem.neighbour_first[node + 1]; ++k) {
      const LabelProblem::Neighbour& neighbour = problem.neighbours[k];
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
      for (std::size_t k = problem.neighbour_first[node]; k < problem.neighbour_first[node + 1]; ++k)
        if (const std::uint32_t label = labels[problem.neighbours[k].node]; label != own) around.push_back(label);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    Capacity best = *cost_with(problem, patch, labels, own) + allowed;
    std::uint32_t best_label = own;
    for (const std::uint32_t label : around)
      if (const auto cost = cost_with(problem, patch, labels, label); cost && *cost <= best) {
        // Strictly less from the second on, so that the lowest label of equals is taken.
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
