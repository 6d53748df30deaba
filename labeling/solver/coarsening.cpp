#include "labeling/solver/coarsening.h"

#include <algorithm>
#include <utility>

namespace gpvc::labeling {
namespace {

/// Breadth-first pieces, in the order of the lowest node of each.
std::size_t find_clusters(const LabelProblem& problem, std::size_t cluster_size,
                          std::vector<std::uint32_t>& cluster_of_node, std::vector<std::uint32_t>& members,
                          std::vector<std::size_t>& member_first) {
  cluster_of_node.assign(problem.nodes(), kNoLabel);
  member_first.assign(1, 0);
  std::uint32_t clusters = 0;
  for (std::uint32_t seed = 0; seed < problem.nodes(); ++seed) {
    if (cluster_of_node[seed] != kNoLabel || problem.first[seed] == problem.first[seed + 1]) continue;
    const std::size_t begin = members.size();
    members.push_back(seed);
    cluster_of_node[seed] = clusters;
    for (std::size_t i = begin; i < members.size(); ++i)
      for (std::size_t k = problem.neighbour_first[members[i]]; k < problem.neighbour_first[members[i] + 1]; ++k) {
        const std::uint32_t other = problem.neighbours[k].node;
        if (members.size() - begin == cluster_size || cluster_of_node[other] != kNoLabel) continue;
        cluster_of_node[other] = clusters;
        members.push_back(other);
      }
    member_first.push_back(members.size());
    ++clusters;
  }
  return clusters;
}

/// Appends one cluster's candidates.
void add_candidates(const LabelProblem& problem, std::span<const std::uint32_t> members, float missing_penalty,
                    CoarseProblem& coarse) {
  struct Item {
    std::uint32_t label;
    float excess;  ///< over the node's cheapest
  };
  std::vector<Item> items;
  double cheapest_sum = 0;
  for (const std::uint32_t node : members) {
    const auto begin = problem.costs.begin() + static_cast<std::ptrdiff_t>(problem.first[node]);
    const auto end = problem.costs.begin() + static_cast<std::ptrdiff_t>(problem.first[node + 1]);
    const float cheapest = *std::min_element(begin, end);
    cheapest_sum += static_cast<double>(cheapest);
    for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i)
      items.push_back({problem.labels[i], problem.costs[i] - cheapest});
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
    coarse.labels.push_back(items[i].label);
    coarse.costs.push_back(static_cast<float>(cost));
  }
  coarse.first.push_back(coarse.labels.size());
}

std::vector<WeightedPair> cluster_pairs(const LabelProblem& problem, const CoarseProblem& coarse) {
  std::vector<WeightedPair> pairs;
  for (std::uint32_t node = 0; node < problem.nodes(); ++node)
    for (std::size_t i = problem.neighbour_first[node]; i < problem.neighbour_first[node + 1]; ++i) {
      const std::uint32_t a = coarse.cluster_of_node[node], b = coarse.cluster_of_node[problem.neighbours[i].node];
      if (a < b) pairs.push_back({a, b, problem.neighbours[i].weight});
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
  std::vector<std::uint32_t> members;
  std::vector<std::size_t> member_first;
  const std::size_t clusters = find_clusters(problem, cluster_size, coarse.cluster_of_node, members, member_first);
  double weight_sum = 0;
  for (const auto& neighbour : problem.neighbours) weight_sum += static_cast<double>(neighbour.weight);
  const auto mean_weight = problem.neighbours.empty()
                               ? 0.0f
                               : static_cast<float>(weight_sum / static_cast<double>(problem.neighbours.size()));
  coarse.first.push_back(0);
  for (std::size_t cluster = 0; cluster < clusters; ++cluster)
    add_candidates(problem, {members.data() + member_first[cluster], member_first[cluster + 1] - member_first[cluster]},
                   mean_weight, coarse);
  coarse.problem = make_problem(coarse.first, coarse.labels, coarse.costs, cluster_pairs(problem, coarse));
  return coarse;
}

std::vector<std::uint32_t> refine_labels(const LabelProblem& problem, const CoarseProblem& coarse,
                                         const std::vector<std::uint32_t>& coarse_labels) {
  std::vector<std::uint32_t> labels = cheapest_labels(problem);
  for (std::size_t node = 0; node < labels.size(); ++node) {
    if (labels[node] == kNoLabel) continue;
    const std::uint32_t wanted = coarse_labels[coarse.cluster_of_node[node]];
    const auto begin = problem.labels.begin() + static_cast<std::ptrdiff_t>(problem.first[node]);
    const auto end = problem.labels.begin() + static_cast<std::ptrdiff_t>(problem.first[node + 1]);
    if (std::binary_search(begin, end, wanted)) labels[node] = wanted;
  }
  return labels;
}

}  // namespace gpvc::labeling
