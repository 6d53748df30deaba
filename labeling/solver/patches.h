// Patches: connected nodes of equal label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/solver/expansion.h"

namespace gpvc::labeling {

/// Calls visit(span of nodes) for each patch, in the order of their lowest nodes; nodes without a label are in none.
/// Labels may change during a visit, if only those of the nodes visited.
template <class Visit>
void for_each_patch(const LabelProblem& problem, std::span<const std::uint32_t> labels, Visit visit) {
  std::vector<std::uint8_t> seen(problem.nodes(), 0);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < problem.nodes(); ++seed) {
    if (seen[seed] != 0 || labels[seed] == kNoLabel) continue;
    seen[seed] = 1;
    patch.assign(1, seed);
    for (std::size_t i = 0; i < patch.size(); ++i)
      for (std::size_t k = problem.neighbour_first[patch[i]]; k < problem.neighbour_first[patch[i] + 1]; ++k) {
        const std::uint32_t other = problem.neighbours[k].node;
        if (seen[other] != 0 || labels[other] != labels[seed]) continue;
        seen[other] = 1;
        patch.push_back(other);
      }
    visit(std::span<const std::uint32_t>(patch));
  }
}

/// Gives each patch of at most `max_nodes` the label of a neighbouring patch, the one that costs least, where all its
/// nodes have that candidate and the energy rises by at most `max_rise` (>= 0). Returns how many.
std::size_t merge_small_patches(const LabelProblem& problem, std::size_t max_nodes, double max_rise,
                                std::vector<std::uint32_t>& labels);

}  // namespace gpvc::labeling
