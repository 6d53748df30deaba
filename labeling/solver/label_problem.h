// The labeling problem as the solver holds it: candidates by node, weighted pairs of nodes, costs as integers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/grouping.h"
#include "labeling/labeling.h"
#include "labeling/solver/graph_cut.h"

namespace gpvc::labeling {

inline constexpr std::uint32_t kNoLabel = 0xFFFFFFFFu;

/// Nodes with candidate labels, and pairs of nodes that cost their weight if their labels differ. A node without
/// candidates has no label, and its pairs are left out.
struct LabelProblem {
  // Candidates by node, labels ascending; borrowed.
  std::span<const std::size_t> first;  ///< nodes + 1
  std::span<const std::uint32_t> labels;
  std::span<const float> costs;

  struct Neighbour {
    std::uint32_t node;
    float weight;
  };
  Grouped<Neighbour> neighbours;  ///< by node; every pair twice

  std::size_t label_count = 0;  ///< the highest label + 1
  double weight_sum = 0;        ///< of all neighbours: every pair counts twice

  /// Costs are held as integers in units of 1 / scale, a power of two: the finest in which no sum overflows.
  double scale = 1;

  std::size_t nodes() const { return first.size() - 1; }
  std::span<const std::uint32_t> labels_of(std::size_t node) const {
    return labels.subspan(first[node], first[node + 1] - first[node]);
  }
  std::span<const float> costs_of(std::size_t node) const {
    return costs.subspan(first[node], first[node + 1] - first[node]);
  }
  Capacity fixed(float cost) const { return static_cast<Capacity>(static_cast<double>(cost) * scale + 0.5); }
  /// Even, because the weight of a pair whose labels differ already is split into halves.
  Capacity fixed_weight(float weight) const {
    return 2 * static_cast<Capacity>(static_cast<double>(weight) * (scale / 2) + 0.5);
  }
};

struct WeightedPair {
  std::uint32_t a, b;
  float weight;
};

/// Borrows the arrays of the table. O(candidates + pairs).
LabelProblem make_problem(const CostTable& table, std::span<const WeightedPair> pairs);

/// The same with the pairs grouped already: every pair twice, weights > 0, none with a node without candidates.
LabelProblem make_problem(const CostTable& table, Grouped<LabelProblem::Neighbour> neighbours);

/// The place of the node's candidate in `labels` and `costs`; kNoCandidate if the node does not have it. O(candidates of
/// the node).
inline constexpr std::size_t kNoCandidate = static_cast<std::size_t>(-1);
inline std::size_t find_candidate(const LabelProblem& problem, std::size_t node, std::uint32_t label) {
  for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i)
    if (problem.labels[i] == label) return i;
  return kNoCandidate;
}

/// 0 for a label that the node does not have.
inline Capacity cost_of(const LabelProblem& problem, std::size_t node, std::uint32_t label) {
  const std::size_t i = find_candidate(problem, node, label);
  return i == kNoCandidate ? 0 : problem.fixed(problem.costs[i]);
}

/// Each node's cheapest candidate, the lowest label of equals; kNoLabel for nodes without candidates.
std::vector<std::uint32_t> cheapest_labels(const LabelProblem& problem);

/// Energy in units of 1 / scale.
Capacity fixed_energy(const LabelProblem& problem, std::span<const std::uint32_t> labels);

}  // namespace gpvc::labeling
