// Alpha expansion on a graph of weighted pairs: each step moves from one labeling to the next by a minimum cut.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "io/grouping.h"
#include "labeling/labeling.h"
#include "labeling/solver/graph_cut.h"

namespace gpvc::labeling {

inline constexpr std::uint32_t kNoLabel = 0xFFFFFFFFu;

/// Nodes with candidate labels, and pairs of nodes that cost their weight if their labels differ. A node without
/// candidates has no label, and its pairs are left out.
struct LabelProblem {
  // Candidates by node, labels ascending; borrowed.
  std::span<const std::size_t> first;  ///< nodes + 1
  std::span<const std::uint32_t> labels;
  std::span<const float> costs;

  struct Neighbour {
    std::uint32_t node;
    float weight;
  };
  Grouped<Neighbour> neighbours;  ///< by node; every pair twice

  struct Candidate {
    std::uint32_t node;
    float cost;
  };
  Grouped<Candidate> by_label;  ///< the candidates once more, by label, nodes ascending

  /// Costs are held as integers in units of 1 / scale, a power of two: the finest in which no sum overflows.
  double scale = 1;

  std::size_t nodes() const { return first.size() - 1; }
  std::size_t label_count() const { return by_label.groups(); }
  std::span<const std::uint32_t> labels_of(std::size_t node) const {
    return labels.subspan(first[node], first[node + 1] - first[node]);
  }
  std::span<const float> costs_of(std::size_t node) const {
    return costs.subspan(first[node], first[node + 1] - first[node]);
  }
  Capacity fixed(float cost) const { return static_cast<Capacity>(static_cast<double>(cost) * scale + 0.5); }
  /// Even, because the weight of a pair whose labels differ already is split into halves.
  Capacity fixed_weight(float weight) const {
    return 2 * static_cast<Capacity>(static_cast<double>(weight) * (scale / 2) + 0.5);
  }
};

struct WeightedPair {
  std::uint32_t a, b;
  float weight;
};

/// Borrows the arrays of the table. O(candidates + pairs).
LabelProblem make_problem(const CostTable& table, std::span<const WeightedPair> pairs);

/// Each node's cheapest candidate, the lowest label of equals; kNoLabel for nodes without candidates.
std::vector<std::uint32_t> cheapest_labels(const LabelProblem& problem);

/// Energy in units of 1 / scale.
Capacity fixed_energy(const LabelProblem& problem, std::span<const std::uint32_t> labels);

/// Improves labels in place, expansion by expansion; the energy never rises. `batch` labels are cut at a time, in
/// parallel, from the same labeling; where their moves touch each other, a later one is applied only if it still lowers
/// the energy. The result depends on `batch`, never on the number of threads.
class Expander {
 public:
  Expander(const LabelProblem& problem, std::vector<std::uint32_t>& labels, std::size_t batch);
  ~Expander();

  /// Expands every label once and returns the number of nodes that changed. The first sweep, and any sweep after one
  /// without a change, cuts whole graphs; the others cut only the surroundings of what changed since the label was last
  /// cut. Calls after_batch() whenever a batch has been applied.
  std::size_t sweep(const std::function<void()>& after_batch = {});

  /// True if the last sweep proved that no expansion of any label lowers the energy.
  bool is_fixpoint() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::labeling
