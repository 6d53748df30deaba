// Patches: connected components of equal label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "labeling/solver/label_problem.h"

namespace gpvc::labeling {

/// Calls visit(span of nodes) for each patch, in the order of their lowest nodes. Nodes whose label is `none` belong to no
/// patch. for_neighbours(node, reach) calls reach(other) for the nodes beside a node. A visit may change the labels of its
/// own nodes.
template <class Label, class ForNeighbours, class Visit>
void for_each_patch(std::span<const Label> labels, Label none, const ForNeighbours& for_neighbours, Visit visit) {
  std::vector<std::uint8_t> seen(labels.size(), 0);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < labels.size(); ++seed) {
    if (seen[seed] != 0 || labels[seed] == none) continue;
    seen[seed] = 1;
    patch.assign(1, seed);
    const auto reach = [&](std::uint32_t other) {
      if (seen[other] != 0 || labels[other] != labels[seed]) return;
      seen[other] = 1;
      patch.push_back(other);
    };
    for (std::size_t i = 0; i < patch.size(); ++i) for_neighbours(patch[i], reach);
    visit(std::span<const std::uint32_t>(patch));
  }
}

/// The patches of a problem's labels.
template <class Visit>
void for_each_patch(const LabelProblem& problem, std::span<const std::uint32_t> labels, Visit visit) {
  const auto for_neighbours = [&](std::uint32_t node, const auto& reach) {
    for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node]) reach(neighbour.node);
  };
  for_each_patch(labels, kNoLabel, for_neighbours, visit);
}

/// Merges each patch of at most `max_nodes` into the neighbouring patch whose label costs least, if all its nodes have
/// that label as a candidate and the energy rises by at most `max_rise` (>= 0). Returns the number of merged patches.
std::size_t merge_small_patches(const LabelProblem& problem, std::size_t max_nodes, double max_rise,
                                std::vector<std::uint32_t>& labels);

}  // namespace gpvc::labeling
