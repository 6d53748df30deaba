// Minimum cuts of small sparse graphs, by Boykov and Kolmogorov's maximum flow (2004) as Boost.Graph implements it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace gpvc::labeling {

/// Integers, so that sums are exact and do not depend on the order of operations.
using Capacity = std::int64_t;

/// A cut problem and its solution, meant to be filled again, so that its memory is allocated once.
class CutGraph {
 public:
  CutGraph();
  ~CutGraph();

  /// Nodes and arcs, compressed by node. Every arc has a reverse arc with a capacity of its own. If flow has been pushed
  /// already, capacities are what remains of them.
  struct Topology {
    std::vector<std::uint32_t> first;  ///< nodes + 1
    std::vector<std::uint32_t> target, reverse;
    std::vector<Capacity> capacity;
    std::vector<Capacity> terminal;  ///< per node; > 0: capacity from the source, < 0: capacity to the sink

    void clear();
    /// Fills `reverse` from the rest. No two arcs between the same nodes in the same direction. O(arcs * degree).
    void link_reverse();
  };
  Topology topology;

  /// A flag per node, 1 if the source still reaches it when the flow is maximal: the smallest source side of all minimum
  /// cuts. Valid until the next solve. O(arcs * nodes^2 * flow) in the worst case, in practice nearly linear.
  const std::vector<std::uint8_t>& solve();

 private:
  struct Arrays;
  std::unique_ptr<Arrays> arrays_;
};

}  // namespace gpvc::labeling
