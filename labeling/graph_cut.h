// Minimum cuts of small sparse graphs, by Boykov and Kolmogorov's maximum flow (2004) as Boost.Graph
// implements it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace gpvc {

/// Integers: exact and the same for any order of operations.
using Capacity = std::int64_t;

/// A cut problem and its answer; meant to be refilled, so that its memory is allocated once. Between clear()
/// and solve(): for each node begin_node(), then its arcs, each arc's reverse being given by its place in the
/// other node.
class CutGraph {
 public:
  CutGraph();
  ~CutGraph();
  CutGraph(const CutGraph&) = delete;
  CutGraph& operator=(const CutGraph&) = delete;

  /// Symmetric arcs between nodes, compressed by node. `reverse[a]` is the arc back. `terminal` > 0: capacity
  /// from the source, < 0: capacity to the sink.
  struct Topology {
    std::vector<std::uint32_t> first;  ///< nodes + 1
    std::vector<std::uint32_t> target, reverse;
    std::vector<Capacity> capacity;
    std::vector<Capacity> terminal;  ///< nodes
    void clear();
  };
  Topology topology;

  /// Nodes that the source still reaches once the flow is maximal: the smallest source side of all minimum
  /// cuts. Result per node, valid until the next solve. Worst case of the algorithm O(arcs nodes^2 flow), in
  /// practice near linear.
  const std::vector<std::uint8_t>& solve();

 private:
  struct Arrays;
  std::unique_ptr<Arrays> arrays_;
};

}  // namespace gpvc
