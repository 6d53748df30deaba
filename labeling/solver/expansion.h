// Alpha expansion on a graph of weighted pairs: each step moves from one labeling to the next by a minimum cut.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "labeling/solver/label_problem.h"

namespace gpvc::labeling {

/// How many edges far a label grows from its seeds. Chosen with the limits in expansion.cpp.
inline constexpr int kReach = 16;

/// Improves labels in place, expansion by expansion; the energy never rises. `batch` labels are cut at a time, in
/// parallel, from the same labeling; where their moves touch each other, a later one is applied only if it still lowers
/// the energy. The result depends on `batch`, never on the number of threads.
class Expander {
 public:
  /// Called whenever a batch has been applied.
  using AfterBatch = std::function<void()>;

  Expander(const LabelProblem& problem, std::vector<std::uint32_t>& labels, std::size_t batch);
  ~Expander();

  /// Expands every label over all nodes that have it as a candidate, and returns the number of nodes that changed. Labels
  /// whose nodes and their neighbours have not changed since they were expanded in vain are skipped. O(candidates) and
  /// the cuts.
  std::size_t sweep(const AfterBatch& after_batch = {});

  /// Expands labels where a move is likely, and returns the number of nodes that changed: a label grows from nodes beside
  /// it and from nodes whose present label costs much more, at most some edges far. The first two sweeps look at all nodes,
  /// later ones at those that the last sweep of either kind changed, and their neighbours. O(nodes looked at) and cuts
  /// of a size that the length of the borders between labels determines.
  std::size_t sweep_borders(const AfterBatch& after_batch = {});

  /// True if the last call was a sweep() which proved that no expansion of any label lowers the energy.
  bool is_fixpoint() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::labeling
