// Makes a smaller labeling problem whose solution is a good start for the larger one.
#pragma once

#include <cstdint>
#include <vector>

#include "labeling/solver/label_problem.h"

namespace gpvc::labeling {

/// The problem whose nodes are clusters of the larger problem's nodes, with the table that it borrows.
struct CoarseProblem {
  std::vector<std::uint32_t> cluster_of_node;  ///< kNoLabel for nodes without candidates
  CostTable table;
  LabelProblem problem;
};

/// Makes connected clusters of up to `cluster_size` nodes, which pieces of at most half that size join where they are left
/// over between clusters. A cluster's candidates are the labels that at least half of its nodes have, or the most frequent
/// ones where no label reaches half; a node that lacks the label counts with its cheapest cost and the mean weight of a
/// pair. The pairs between two clusters become one pair with the sum of their weights. O(candidates * log(candidates of a
/// cluster)), TBB inside.
CoarseProblem coarsen(const LabelProblem& problem, std::size_t cluster_size);

/// Labels of the finer problem: the cluster's label where the node has it as a candidate, else the cheapest.
std::vector<std::uint32_t> refine_labels(const LabelProblem& problem, const CoarseProblem& coarse,
                                         const std::vector<std::uint32_t>& coarse_labels);

}  // namespace gpvc::labeling
