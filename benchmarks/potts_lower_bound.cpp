#include "benchmarks/potts_lower_bound.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "io/grouping.h"

namespace gpvc {
namespace {

/// A message per pair and direction, one value per candidate of the face it goes to.
class Messages {
 public:
  Messages(const labeling::CostTable& table, const labeling::FaceGraph& graph, double smoothness)
      : table_(table), smoothness_(smoothness) {
    std::size_t values = 0;
    neighbours_ = group_items<Neighbour>(table.faces(), [&](const auto& add) {
      values = 0;
      for (const auto& [a, b] : graph.edges) {
        if (candidates(a) == 0 || candidates(b) == 0) continue;
        const std::size_t to_a = values, to_b = values + candidates(a);
        values = to_b + candidates(b);
        add(a, {b, to_a, to_b});
        add(b, {a, to_b, to_a});
      }
    });
    values_.assign(values, 0);
  }

  void round() {
    for (std::uint32_t face = 0; face < table_.faces(); ++face) send(face, true);
    for (std::uint32_t face = static_cast<std::uint32_t>(table_.faces()); face-- > 0;) send(face, false);
  }

  double bound() {
    double sum = 0;
    std::vector<double> other_belief;
    for (std::uint32_t face = 0; face < table_.faces(); ++face) {
      if (candidates(face) == 0) continue;
      gather(face, belief_);
      const double degree = static_cast<double>(neighbours_[face].size());
      if (degree == 0) sum += *std::min_element(belief_.begin(), belief_.end());
      for (const Neighbour& neighbour : neighbours_[face]) {
        if (neighbour.face < face) continue;
        gather(neighbour.face, other_belief);
        const double other_degree = static_cast<double>(neighbours_[neighbour.face].size());
        for (std::size_t i = 0; i < belief_.size(); ++i)
          here_.push_back(belief_[i] / degree - values_[neighbour.from + i]);
        for (std::size_t i = 0; i < other_belief.size(); ++i)
          there_.push_back(other_belief[i] / other_degree - values_[neighbour.to + i]);
        sum += pair_minimum(face, neighbour.face);
        here_.clear();
        there_.clear();
      }
    }
    return sum;
  }

 private:
  struct Neighbour {
    std::uint32_t face;
    std::size_t from, to;  ///< first value of the message from that face, and of the one to it
  };

  std::size_t candidates(std::uint32_t face) const { return table_.costs_of(face).size(); }
  std::uint32_t view(std::uint32_t face, std::size_t i) const { return table_.views_of(face)[i]; }

  void gather(std::uint32_t face, std::vector<double>& belief) const {
    belief.assign(table_.costs_of(face).begin(), table_.costs_of(face).end());
    for (const Neighbour& neighbour : neighbours_[face])
      for (std::size_t i = 0; i < belief.size(); ++i) belief[i] += values_[neighbour.from + i];
  }

  /// min over both candidates of here + there + [different] * smoothness.
  double pair_minimum(std::uint32_t a, std::uint32_t b) const {
    double best =
        *std::min_element(here_.begin(), here_.end()) + *std::min_element(there_.begin(), there_.end()) + smoothness_;
    for (std::size_t i = 0, j = 0; i < here_.size() && j < there_.size();) {
      if (view(a, i) == view(b, j))
        best = std::min(best, here_[i++] + there_[j++]);
      else if (view(a, i) < view(b, j))
        ++i;
      else
        ++j;
    }
    return best;
  }

  void send(std::uint32_t face, bool forwards) {
    if (candidates(face) == 0) return;
    gather(face, belief_);
    const std::span<const Neighbour> neighbours = std::as_const(neighbours_)[face];
    std::size_t later = 0;
    for (const Neighbour& neighbour : neighbours) later += neighbour.face > face;
    const double share = 1.0 / static_cast<double>(std::max<std::size_t>({later, neighbours.size() - later, 1}));
    for (const Neighbour& neighbour : neighbours) {
      if ((neighbour.face > face) != forwards) continue;
      double lowest = std::numeric_limits<double>::max();
      for (std::size_t i = 0; i < belief_.size(); ++i) {
        here_.push_back(share * belief_[i] - values_[neighbour.from + i]);
        lowest = std::min(lowest, here_.back());
      }
      const std::size_t count = candidates(neighbour.face);
      double least = std::numeric_limits<double>::max();
      for (std::size_t i = 0, j = 0; j < count; ++j) {
        while (i < here_.size() && view(face, i) < view(neighbour.face, j)) ++i;
        const bool shared = i < here_.size() && view(face, i) == view(neighbour.face, j);
        double& value = values_[neighbour.to + j];
        value = std::min(lowest + smoothness_, shared ? here_[i] : lowest + smoothness_);
        least = std::min(least, value);
      }
      for (std::size_t j = 0; j < count; ++j) values_[neighbour.to + j] -= least;
      here_.clear();
    }
  }

  const labeling::CostTable& table_;
  double smoothness_;
  Grouped<Neighbour> neighbours_;
  std::vector<double> values_;
  std::vector<double> belief_, here_, there_;
};

}  // namespace

double potts_lower_bound(const labeling::CostTable& table, const labeling::FaceGraph& graph, double smoothness,
                         int rounds) {
  double cheapest = 0;
  for (std::size_t face = 0; face < table.faces(); ++face)
    if (const std::span<const float> costs = table.costs_of(face); !costs.empty())
      cheapest += static_cast<double>(*std::min_element(costs.begin(), costs.end()));
  if (rounds <= 0) return cheapest;
  Messages messages(table, graph, smoothness);
  for (int i = 0; i < rounds; ++i) messages.round();
  return std::max(cheapest, messages.bound());
}

}  // namespace gpvc
