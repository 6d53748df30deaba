#include "labeling/solver/coarsening.h"

#include <algorithm>
#include <utility>

namespace gpvc::labeling {
namespace {

/// Numbers the clusters, breadth-first pieces in the order of their lowest nodes, and lists the members of each.
Grouped<std::uint32_t> find_clusters(const LabelProblem& problem, std::size_t cluster_size,
                                     std::vector<std::uint32_t>& cluster_of_node) {
  Grouped<std::uint32_t> clusters;
  std::vector<std::uint32_t>& members = clusters.items;
  cluster_of_node.assign(problem.nodes(), kNoLabel);
  for (std::uint32_t seed = 0; seed < problem.nodes(); ++seed) {
    if (cluster_of_node[seed] != kNoLabel || problem.first[seed] == problem.first[seed + 1]) continue;
    const auto cluster = static_cast<std::uint32_t>(clusters.groups());
    const std::size_t begin = members.size();
    members.push_back(seed);
    cluster_of_node[seed] = cluster;
    for (std::size_t i = begin; i < members.size(); ++i)
      for (const LabelProblem::Neighbour& neighbour : problem.neighbours[members[i]]) {
        if (members.size() - begin == cluster_size || cluster_of_node[neighbour.node] != kNoLabel) continue;
        cluster_of_node[neighbour.node] = cluster;
        members.push_back(neighbour.node);
      }
    clusters.first.push_back(members.size());
  }
  return clusters;
}

/// Appends the candidates of one cluster.
void add_candidates(const LabelProblem& problem, std::span<const std::uint32_t> members, float missing_penalty,
                    CostTable& coarse) {
  struct Item {
    std::uint32_t label;
    float excess;  ///< over the node's cheapest candidate
  };
  std::vector<Item> items;
  double cheapest_sum = 0;
  for (const std::uint32_t node : members) {
    const std::span<const std::uint32_t> labels = problem.labels_of(node);
    const std::span<const float> costs = problem.costs_of(node);
    const float cheapest = *std::min_element(costs.begin(), costs.end());
    cheapest_sum += static_cast<double>(cheapest);
    for (std::size_t i = 0; i < labels.size(); ++i) items.push_back({labels[i], costs[i] - cheapest});
  }
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.label < b.label; });
  std::size_t most = 0;
  for (std::size_t i = 0, j = 0; i < items.size(); i = j) {
    while (j < items.size() && items[j].label == items[i].label) ++j;
    most = std::max(most, j - i);
  }
  const std::size_t wanted = std::min(most, (members.size() + 1) / 2);
  for (std::size_t i = 0, j = 0; i < items.size(); i = j) {
    double cost = cheapest_sum;
    for (; j < items.size() && items[j].label == items[i].label; ++j) cost += static_cast<double>(items[j].excess);
    if (j - i < wanted) continue;
    cost += static_cast<double>(missing_penalty) * static_cast<double>(members.size() - (j - i));
    coarse.views.push_back(items[i].label);
    coarse.costs.push_back(static_cast<float>(cost));
  }
  coarse.first.push_back(coarse.views.size());
}

std::vector<WeightedPair> cluster_pairs(const LabelProblem& problem, const CoarseProblem& coarse) {
  std::vector<WeightedPair> pairs;
  for (std::uint32_t node = 0; node < problem.nodes(); ++node)
    for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node]) {
      const std::uint32_t a = coarse.cluster_of_node[node], b = coarse.cluster_of_node[neighbour.node];
      if (a < b) pairs.push_back({a, b, neighbour.weight});
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const WeightedPair& x, const WeightedPair& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  std::size_t kept = 0;
  for (const WeightedPair& pair : pairs) {
    if (kept > 0 && pairs[kept - 1].a == pair.a && pairs[kept - 1].b == pair.b)
      pairs[kept - 1].weight += pair.weight;
    else
      pairs[kept++] = pair;
  }
  pairs.resize(kept);
  return pairs;
}

}  // namespace

CoarseProblem coarsen(const LabelProblem& problem, std::size_t cluster_size) {
  CoarseProblem coarse;
  const Grouped<std::uint32_t> clusters = find_clusters(problem, cluster_size, coarse.cluster_of_node);
  const std::vector<LabelProblem::Neighbour>& neighbours = problem.neighbours.items;
  double weight_sum = 0;
  for (const LabelProblem::Neighbour& neighbour : neighbours) weight_sum += static_cast<double>(neighbour.weight);
  const float mean_weight =
      neighbours.empty() ? 0.0f : static_cast<float>(weight_sum / static_cast<double>(neighbours.size()));
  coarse.table.first.push_back(0);
  for (std::size_t cluster = 0; cluster < clusters.groups(); ++cluster)
    add_candidates(problem, clusters[cluster], mean_weight, coarse.table);
  coarse.problem = make_problem(coarse.table, cluster_pairs(problem, coarse));
  return coarse;
}

std::vector<std::uint32_t> refine_labels(const LabelProblem& problem, const CoarseProblem& coarse,
                                         const std::vector<std::uint32_t>& coarse_labels) {
  std::vector<std::uint32_t> labels = cheapest_labels(problem);
  for (std::size_t node = 0; node < labels.size(); ++node) {
    if (labels[node] == kNoLabel) continue;
    const std::uint32_t wanted = coarse_labels[coarse.cluster_of_node[node]];
    const std::span<const std::uint32_t> candidates = problem.labels_of(node);
    if (std::binary_search(candidates.begin(), candidates.end(), wanted)) labels[node] = wanted;
  }
  return labels;
}

}  // namespace gpvc::labeling
