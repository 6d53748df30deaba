// Patches: connected components of equal label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/solver/label_problem.h"

namespace gpvc::labeling {

/// Calls visit(span of nodes) for each patch, in the order of their lowest nodes. Nodes without a label belong to no patch.
/// A visit may change the labels of its own nodes.
template <class Visit>
void for_each_patch(const LabelProblem& problem, std::span<const std::uint32_t> labels, Visit visit) {
  std::vector<std::uint8_t> seen(problem.nodes(), 0);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < problem.nodes(); ++seed) {
    if (seen[seed] != 0 || labels[seed] == kNoLabel) continue;
    seen[seed] = 1;
    patch.assign(1, seed);
    for (std::size_t i = 0; i < patch.size(); ++i)
      for (const LabelProblem::Neighbour& neighbour : problem.neighbours[patch[i]]) {
        if (seen[neighbour.node] != 0 || labels[neighbour.node] != labels[seed]) continue;
        seen[neighbour.node] = 1;
        patch.push_back(neighbour.node);
      }
    visit(std::span<const std::uint32_t>(patch));
  }
}

/// Merges each patch of at most `max_nodes` into the neighbouring patch whose label costs least, if all its nodes have
/// that label as a candidate and the energy rises by at most `max_rise` (>= 0). Returns the number of merged patches.
std::size_t merge_small_patches(const LabelProblem& problem, std::size_t max_nodes, double max_rise,
                                std::vector<std::uint32_t>& labels);

}  // namespace gpvc::labeling
