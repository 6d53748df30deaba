#include "labeling/solver/label_problem.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace gpvc::labeling {
namespace {

Grouped<LabelProblem::Neighbour> weighted_neighbours(const CostTable& table, std::span<const WeightedPair> pairs) {
  const auto has_candidates = [&](std::uint32_t node) { return table.first[node] < table.first[node + 1]; };
  return group_numbered<LabelProblem::Neighbour>(table.faces(), pairs.size(), [&](std::size_t i, const auto& add) {
    const WeightedPair& pair = pairs[i];
    if (!(pair.weight > 0) || !has_candidates(pair.a) || !has_candidates(pair.b)) return;
    add(pair.a, {pair.b, pair.weight});
    add(pair.b, {pair.a, pair.weight});
  });
}

/// The solver's sums are at most the cost of all candidates and all pairs together.
double scale_for(const LabelProblem& problem) {
  double bound = 1 + problem.weight_sum;
  for (const float cost : problem.costs) bound += static_cast<double>(cost);
  return std::ldexp(1.0, std::min(40, 60 - static_cast<int>(std::ceil(std::log2(bound)))));
}

}  // namespace

LabelProblem make_problem(const CostTable& table, Grouped<LabelProblem::Neighbour> neighbours) {
  LabelProblem problem{table.first, table.views, table.costs, std::move(neighbours)};
  for (const std::uint32_t label : table.views)
    problem.label_count = std::max(problem.label_count, std::size_t{label} + 1);
  for (const LabelProblem::Neighbour& neighbour : problem.neighbours.items)
    problem.weight_sum += static_cast<double>(neighbour.weight);
  problem.scale = scale_for(problem);
  return problem;
}

LabelProblem make_problem(const CostTable& table, std::span<const WeightedPair> pairs) {
  return make_problem(table, weighted_neighbours(table, pairs));
}

std::vector<std::uint32_t> cheapest_labels(const LabelProblem& problem) {
  std::vector<std::uint32_t> result(problem.nodes(), kNoLabel);
  for (std::size_t node = 0; node < result.size(); ++node) {
    const std::span<const float> costs = problem.costs_of(node);
    if (costs.empty()) continue;
    const auto cheapest = std::min_element(costs.begin(), costs.end()) - costs.begin();
    result[node] = problem.labels_of(node)[static_cast<std::size_t>(cheapest)];
  }
  return result;
}

Capacity fixed_energy(const LabelProblem& problem, std::span<const std::uint32_t> labels) {
  using Range = tbb::blocked_range<std::size_t>;
  // Sums of integers do not depend on how the range is split.
  const auto twice = tbb::parallel_reduce(
      Range(0, problem.nodes(), 4096), Capacity{0},
      [&](const Range& range, Capacity sum) {
        for (std::size_t node = range.begin(); node != range.end(); ++node) {
          sum += 2 * cost_of(problem, node, labels[node]);
          for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node])
            if (labels[neighbour.node] != labels[node]) sum += problem.fixed_weight(neighbour.weight);
        }
        return sum;
      },
      std::plus<>());
  return twice / 2;
}

}  // namespace gpvc::labeling
