#include "labeling/solver/coarsening.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace gpvc::labeling {
namespace {

/// The cluster beside the members that most weight joins them to; kNoLabel if there is none.
std::uint32_t nearest_cluster(const LabelProblem& problem, std::span<const std::uint32_t> members, std::uint32_t own,
                              std::span<const std::uint32_t> cluster_of_node) {
  std::uint32_t best = kNoLabel;
  float most = 0;
  for (const std::uint32_t node : members)
    for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node]) {
      const std::uint32_t cluster = cluster_of_node[neighbour.node];
      if (cluster == own || cluster == kNoLabel || neighbour.weight <= most) continue;
      most = neighbour.weight;
      best = cluster;
    }
  return best;
}

/// The members of the clusters: breadth-first pieces in the order of their lowest nodes. A piece of at most half a cluster,
/// which is what is left over between others, joins one of these, or clusters would lose size with every level.
Grouped<std::uint32_t> find_clusters(const LabelProblem& problem, std::size_t cluster_size,
                                     std::vector<std::uint32_t>& cluster_of_node) {
  std::vector<std::uint32_t> members;
  cluster_of_node.assign(problem.nodes(), kNoLabel);
  std::uint32_t clusters = 0;
  for (std::uint32_t seed = 0; seed < problem.nodes(); ++seed) {
    if (cluster_of_node[seed] != kNoLabel || problem.first[seed] == problem.first[seed + 1]) continue;
    members.assign(1, seed);
    cluster_of_node[seed] = clusters;
    for (std::size_t i = 0; i < members.size(); ++i)
      for (const LabelProblem::Neighbour& neighbour : problem.neighbours[members[i]]) {
        if (members.size() == cluster_size || cluster_of_node[neighbour.node] != kNoLabel) continue;
        cluster_of_node[neighbour.node] = clusters;
        members.push_back(neighbour.node);
      }
    const std::uint32_t other =
        2 * members.size() > cluster_size ? kNoLabel : nearest_cluster(problem, members, clusters, cluster_of_node);
    if (other == kNoLabel)
      ++clusters;
    else
      for (const std::uint32_t node : members) cluster_of_node[node] = other;
  }
  return group_items<std::uint32_t>(clusters, [&](const auto& add) {
    for (std::uint32_t node = 0; node < problem.nodes(); ++node)
      if (cluster_of_node[node] != kNoLabel) add(cluster_of_node[node], node);
  });
}

/// Sums the candidates of a cluster's members by label.
class CandidateSums {
 public:
  explicit CandidateSums(std::size_t labels) : slot_(labels, 0) {}

  void append(const LabelProblem& problem, std::span<const std::uint32_t> members, float missing_penalty,
              CostTable& coarse) {
    sums_.clear();
    double cheapest_sum = 0;
    for (const std::uint32_t node : members) cheapest_sum += add(problem.labels_of(node), problem.costs_of(node));
    std::ranges::sort(sums_, {}, &Sum::label);
    const std::size_t most = std::ranges::max_element(sums_, {}, &Sum::nodes)->nodes;
    const std::size_t wanted = std::min(most, (members.size() + 1) / 2);
    for (const Sum& sum : sums_) {
      if (sum.nodes < wanted) continue;
      coarse.views.push_back(sum.label);
      coarse.costs.push_back(
          static_cast<float>(cheapest_sum + sum.excess +
                             static_cast<double>(missing_penalty) * static_cast<double>(members.size() - sum.nodes)));
    }
    coarse.first.push_back(coarse.views.size());
  }

 private:
  struct Sum {
    std::uint32_t label;
    std::size_t nodes;
    double excess;  ///< over the nodes' cheapest candidates
  };

  /// Returns the lowest cost.
  double add(std::span<const std::uint32_t> labels, std::span<const float> costs) {
    const float cheapest = *std::ranges::min_element(costs);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      // A slot that points to another label's sum, or beyond the sums, is left over from another cluster.
      std::uint32_t& slot = slot_[labels[i]];
      if (slot >= sums_.size() || sums_[slot].label != labels[i]) {
        slot = static_cast<std::uint32_t>(sums_.size());
        sums_.push_back({labels[i], 0, 0});
      }
      ++sums_[slot].nodes;
      sums_[slot].excess += static_cast<double>(costs[i] - cheapest);
    }
    return static_cast<double>(cheapest);
  }

  std::vector<std::uint32_t> slot_;  ///< per label, its place in sums_
  std::vector<Sum> sums_;
};

/// The clusters beside one cluster with the summed weights, ascending.
void add_neighbours(const LabelProblem& problem, std::span<const std::uint32_t> members,
                    std::span<const std::uint32_t> cluster_of_node, std::vector<LabelProblem::Neighbour>& neighbours) {
  const auto begin = neighbours.size();
  const std::uint32_t own = cluster_of_node[members[0]];
  for (const std::uint32_t node : members)
    for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node])
      if (const std::uint32_t cluster = cluster_of_node[neighbour.node]; cluster != own)
        neighbours.push_back({cluster, neighbour.weight});
  const auto first = neighbours.begin() + static_cast<std::ptrdiff_t>(begin);
  std::stable_sort(first, neighbours.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  auto last = first;
  for (auto i = first; i != neighbours.end(); ++i) {
    if (last != first && (last - 1)->node == i->node)
      (last - 1)->weight += i->weight;
    else
      *last++ = *i;
  }
  neighbours.erase(last, neighbours.end());
}

/// Candidates and neighbours of a run of clusters.
struct CoarsePart {
  CostTable table{{}, {}, {}};  ///< `first` without the leading 0
  Grouped<LabelProblem::Neighbour> neighbours;
};

template <class Item>
void append(std::vector<Item>& to, const std::vector<Item>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Appends the ends of a part's rows to `first`, which begins with 0.
void append_ends(std::vector<std::size_t>& first, std::span<const std::size_t> ends) {
  const std::size_t offset = first.back();
  for (const std::size_t end : ends) first.push_back(offset + end);
}

}  // namespace

CoarseProblem coarsen(const LabelProblem& problem, std::size_t cluster_size) {
  CoarseProblem coarse;
  const Grouped<std::uint32_t> clusters = find_clusters(problem, cluster_size, coarse.cluster_of_node);
  const auto pairs = static_cast<double>(std::max<std::size_t>(1, problem.neighbours.items.size()));
  const auto mean_weight = static_cast<float>(problem.weight_sum / pairs);
  constexpr std::size_t kPartClusters = 4096;
  std::vector<CoarsePart> parts((clusters.groups() + kPartClusters - 1) / kPartClusters);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t n) {
    CoarsePart& part = parts[n];
    CandidateSums sums(problem.label_count);
    const std::size_t end = std::min(clusters.groups(), (n + 1) * kPartClusters);
    for (std::size_t cluster = n * kPartClusters; cluster < end; ++cluster) {
      sums.append(problem, clusters[cluster], mean_weight, part.table);
      add_neighbours(problem, clusters[cluster], coarse.cluster_of_node, part.neighbours.items);
      part.neighbours.first.push_back(part.neighbours.items.size());
    }
  });
  coarse.table.first.push_back(0);
  Grouped<LabelProblem::Neighbour> all;
  for (CoarsePart& part : parts) {
    append_ends(coarse.table.first, part.table.first);
    append(coarse.table.views, part.table.views);
    append(coarse.table.costs, part.table.costs);
    append_ends(all.first, std::span(part.neighbours.first).subspan(1));
    append(all.items, part.neighbours.items);
    part = {};
  }
  coarse.problem = make_problem(coarse.table, std::move(all));
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
