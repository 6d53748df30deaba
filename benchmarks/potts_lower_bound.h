// A lower bound on the energy, to judge how far a labeling is from the optimum.
#pragma once

#include "labeling/labeling.h"

namespace gpvc {

/// A lower bound on the energy of any labeling: `rounds` of tree-reweighted message passing (Kolmogorov 2006)
/// reparametrize the energy, then every pair with its share of its two faces' costs is minimized by itself. With 0
/// rounds, the sum of the cheapest costs. Pairs weigh 1. O(candidates) time and memory a round.
double potts_lower_bound(const labeling::CostTable& table, const labeling::FaceGraph& graph, double smoothness,
                         int rounds);

}  // namespace gpvc
