// Minimum cuts of small sparse graphs, by Boykov and Kolmogorov's maximum flow (2004) as Boost.Graph implements it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace gpvc::labeling {

/// Integers: exact and the same for any order of operations.
using Capacity = std::int64_t;

/// A cut problem and its answer; meant to be refilled, so that its memory is allocated once.
class CutGraph {
 public:
  CutGraph();
  ~CutGraph();
  CutGraph(const CutGraph&) = delete;
  CutGraph& operator=(const CutGraph&) = delete;

  /// Nodes and arcs, compressed by node; every arc has one back, of a capacity of its own. Flow may be pushed through
  /// it in advance: then these are the residuals.
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

  /// Nodes that the source still reaches once the flow is maximal: the smallest source side of all minimum cuts. Result
  /// per node, valid until the next solve. Worst case of the algorithm O(arcs nodes^2 flow), in practice near linear.
  const std::vector<std::uint8_t>& solve();

 private:
  struct Arrays;
  std::unique_ptr<Arrays> arrays_;
};

}  // namespace gpvc::labeling
