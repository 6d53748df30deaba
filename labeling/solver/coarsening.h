// A smaller labeling problem whose solution is a good start for the larger one.
#pragma once

#include <cstdint>
#include <vector>

#include "labeling/solver/expansion.h"

namespace gpvc::labeling {

/// Clusters of neighbouring nodes as nodes. Owns what its problem borrows.
struct CoarseProblem {
  std::vector<std::uint32_t> cluster_of_node;  ///< kNoLabel for nodes without candidates
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> labels;
  std::vector<float> costs;
  LabelProblem problem;
};

/// Connected clusters of at most `cluster_size` nodes. A cluster's candidates are the labels that at least half of its
/// nodes have; a node that lacks the label counts with its cheapest cost and one pair's weight. Pairs between two
/// clusters become one of the sum of their weights. Deterministic; O(candidates log candidates a cluster).
CoarseProblem coarsen(const LabelProblem& problem, std::size_t cluster_size);

/// Labels of the fine problem: the cluster's where it is a candidate, else the cheapest.
std::vector<std::uint32_t> refine_labels(const LabelProblem& problem, const CoarseProblem& coarse,
                                         const std::vector<std::uint32_t>& coarse_labels);

}  // namespace gpvc::labeling
