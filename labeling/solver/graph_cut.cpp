// The only source that uses Boost.Graph. Its algorithm runs on a view of flat arrays that models the graph concepts it
// requires, because building an adjacency_list would take longer than computing the flow.
#include "labeling/solver/graph_cut.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/graph_traits.hpp>
#include <boost/iterator/counting_iterator.hpp>
#include <boost/property_map/property_map.hpp>
#include <span>
#include <utility>

namespace gpvc::labeling {

namespace {

/// Breadth-first spanning forest, a tree for each connected component: nodes in order of discovery, where the trees begin
/// in that order, and the arc to each node's parent.
struct Forest {
  std::vector<std::uint32_t> order, parent_arc;
  std::vector<std::size_t> tree_first;  ///< trees + 1

  void grow(const CutGraph::Topology& graph) {
    const auto nodes = static_cast<std::uint32_t>(graph.terminal.size());
    order.clear();
    tree_first.assign(1, 0);
    parent_arc.assign(nodes, kUnseen);
    for (std::uint32_t root = 0; root < nodes; ++root) {
      if (parent_arc[root] != kUnseen) continue;
      parent_arc[root] = kRoot;
      order.push_back(root);
      for (std::size_t i = tree_first.back(); i < order.size(); ++i)
        for (std::uint32_t arc = graph.first[order[i]]; arc < graph.first[order[i] + 1]; ++arc) {
          if (parent_arc[graph.target[arc]] != kUnseen) continue;
          parent_arc[graph.target[arc]] = graph.reverse[arc];
          order.push_back(graph.target[arc]);
        }
      tree_first.push_back(order.size());
    }
  }

  std::span<const std::uint32_t> tree(std::size_t n) const {
    return std::span(order).subspan(tree_first[n], tree_first[n + 1] - tree_first[n]);
  }

  static constexpr std::uint32_t kUnseen = 0xFFFFFFFFu, kRoot = 0xFFFFFFFEu;
};

/// Pushes each node's excess (capacity from the source or to the sink) towards the root of its tree as far as capacities
/// allow, so that supply and demand cancel. Flow pushed in advance does not change the minimum cuts. This takes linear
/// time and leaves little for the search trees of the algorithm, since terminal capacities of neighbours are small and of
/// either sign.
void push_to_roots(CutGraph::Topology& graph, const Forest& forest) {
  for (std::size_t i = forest.order.size(); i-- > 0;) {
    const std::uint32_t node = forest.order[i], arc = forest.parent_arc[node];
    const Capacity terminal = graph.terminal[node];
    if (arc == Forest::kRoot || terminal == 0) continue;
    const std::uint32_t back = graph.reverse[arc];
    const Capacity sent =
        terminal > 0 ? std::min(terminal, graph.capacity[arc]) : -std::min(-terminal, graph.capacity[back]);
    graph.terminal[node] -= sent;
    graph.terminal[graph.target[arc]] += sent;
    graph.capacity[arc] -= sent;
    graph.capacity[back] += sent;
  }
}

}  // namespace

// The graph as the algorithm sees it: nodes 0 to n - 1, then source and sink. A node's arcs are its terminal arc, if it has
// one, then those of the topology. Components without capacity from the source are left out: no flow enters them.
struct CutGraph::Arrays {
  std::vector<std::uint32_t> node;   ///< of the topology
  std::vector<std::uint32_t> index;  ///< the other way round; undefined for nodes that are left out
  std::vector<std::uint32_t> first;  ///< nodes + 3
  std::vector<std::uint32_t> target, reverse;
  std::vector<Capacity> residual;
  std::vector<std::uint32_t> parent_arc;
  std::vector<boost::default_color_type> tree;
  std::vector<std::int32_t> distance;
  std::vector<std::uint8_t> source_side;
  Forest forest;

  void build(const Topology& problem);

 private:
  void choose_nodes(const Topology& problem);
  void place_rows(const Topology& problem);
};

namespace {

struct FlowGraphCategory : boost::vertex_list_graph_tag, boost::edge_list_graph_tag, boost::incidence_graph_tag {};

/// The view that Boost's algorithm works on; boost::graph_traits takes the types from here.
struct FlowGraph {
  using vertex_descriptor = std::uint32_t;
  using edge_descriptor = std::uint32_t;
  using vertex_iterator = boost::counting_iterator<std::uint32_t>;
  using edge_iterator = boost::counting_iterator<std::uint32_t>;
  using out_edge_iterator = boost::counting_iterator<std::uint32_t>;
  using directed_category = boost::directed_tag;
  using edge_parallel_category = boost::allow_parallel_edge_tag;
  using traversal_category = FlowGraphCategory;
  using vertices_size_type = std::uint32_t;
  using edges_size_type = std::uint32_t;
  using degree_size_type = std::uint32_t;
  static vertex_descriptor null_vertex() { return 0xFFFFFFFFu; }

  const std::vector<std::uint32_t>* first;
  const std::vector<std::uint32_t>* target;
  const std::vector<std::uint32_t>* reverse;
};

// Found by argument-dependent lookup from inside Boost.
using ArcIterator = boost::counting_iterator<std::uint32_t>;

std::uint32_t num_vertices(const FlowGraph& graph) { return static_cast<std::uint32_t>(graph.first->size() - 1); }
std::uint32_t num_edges(const FlowGraph& graph) { return static_cast<std::uint32_t>(graph.target->size()); }
std::pair<ArcIterator, ArcIterator> vertices(const FlowGraph& graph) {
  return {ArcIterator(0), ArcIterator(num_vertices(graph))};
}
std::pair<ArcIterator, ArcIterator> edges(const FlowGraph& graph) {
  return {ArcIterator(0), ArcIterator(num_edges(graph))};
}
std::pair<ArcIterator, ArcIterator> out_edges(std::uint32_t node, const FlowGraph& graph) {
  return {ArcIterator((*graph.first)[node]), ArcIterator((*graph.first)[node + 1])};
}
std::uint32_t out_degree(std::uint32_t node, const FlowGraph& graph) {
  return (*graph.first)[node + 1] - (*graph.first)[node];
}
std::uint32_t target(std::uint32_t arc, const FlowGraph& graph) { return (*graph.target)[arc]; }
std::uint32_t source(std::uint32_t arc, const FlowGraph& graph) { return (*graph.target)[(*graph.reverse)[arc]]; }

}  // namespace

void CutGraph::Topology::clear() {
  first.assign(1, 0);
  target.clear();
  reverse.clear();
  capacity.clear();
  terminal.clear();
}

void CutGraph::Topology::link_reverse() {
  reverse.resize(target.size());
  for (std::uint32_t node = 0; node < terminal.size(); ++node)
    for (std::uint32_t arc = first[node]; arc < first[node + 1]; ++arc) {
      std::uint32_t back = first[target[arc]];
      while (target[back] != node) ++back;
      reverse[arc] = back;
    }
}

void CutGraph::Arrays::choose_nodes(const Topology& problem) {
  node.clear();
  index.resize(problem.terminal.size());
  for (std::size_t n = 0; n + 1 < forest.tree_first.size(); ++n) {
    const std::span<const std::uint32_t> component = forest.tree(n);
    if (std::ranges::none_of(component, [&](std::uint32_t at) { return problem.terminal[at] > 0; })) continue;
    for (const std::uint32_t at : component) {
      index[at] = static_cast<std::uint32_t>(node.size());
      node.push_back(at);
    }
  }
}

/// Fills `first` and resizes the arrays of arcs.
void CutGraph::Arrays::place_rows(const Topology& problem) {
  const std::size_t nodes = node.size();
  first.resize(nodes + 3);
  std::uint32_t arcs = 0, terminals = 0, source_arcs = 0;
  for (std::size_t i = 0; i < nodes; ++i) {
    const std::uint32_t at = node[i];
    first[i] = arcs;
    arcs += problem.first[at + 1] - problem.first[at] + (problem.terminal[at] != 0 ? 1u : 0u);
    terminals += problem.terminal[at] != 0;
    source_arcs += problem.terminal[at] > 0;
  }
  first[nodes] = arcs;
  first[nodes + 1] = arcs + source_arcs;
  first[nodes + 2] = arcs + terminals;
  target.resize(first.back());
  reverse.resize(first.back());
  residual.resize(first.back());
}

void CutGraph::Arrays::build(const Topology& problem) {
  choose_nodes(problem);
  place_rows(problem);
  const auto nodes = static_cast<std::uint32_t>(node.size());
  const std::uint32_t source_node = nodes, sink_node = nodes + 1;
  std::uint32_t next_source = first[source_node], next_sink = first[sink_node];
  for (std::uint32_t i = 0; i < nodes; ++i) {
    const std::uint32_t at = node[i];
    std::uint32_t arc = first[i];
    if (const Capacity terminal = problem.terminal[at]; terminal != 0) {
      const std::uint32_t back = terminal > 0 ? next_source++ : next_sink++;
      target[arc] = terminal > 0 ? source_node : sink_node;
      residual[arc] = terminal > 0 ? 0 : -terminal;
      target[back] = i;
      residual[back] = terminal > 0 ? terminal : 0;
      reverse[arc] = back;
      reverse[back] = arc;
      ++arc;
    }
    for (std::uint32_t from = problem.first[at]; from < problem.first[at + 1]; ++from, ++arc) {
      const std::uint32_t other = problem.target[from];
      target[arc] = index[other];
      residual[arc] = problem.capacity[from];
      reverse[arc] =
          problem.reverse[from] - problem.first[other] + first[index[other]] + (problem.terminal[other] != 0 ? 1u : 0u);
    }
  }
}

CutGraph::CutGraph() : arrays_(std::make_unique<Arrays>()) { topology.clear(); }
CutGraph::~CutGraph() = default;

const std::vector<std::uint8_t>& CutGraph::solve() {
  Arrays& a = *arrays_;
  a.forest.grow(topology);
  push_to_roots(topology, a.forest);
  a.source_side.assign(topology.terminal.size(), 0);
  a.build(topology);
  if (a.node.empty()) return a.source_side;
  const auto nodes = static_cast<std::uint32_t>(a.node.size());
  a.parent_arc.resize(nodes + 2);
  a.tree.resize(nodes + 2);
  a.distance.assign(nodes + 2, 0);
  FlowGraph graph{&a.first, &a.target, &a.reverse};
  // Capacities and residuals may be the same array: the algorithm begins by copying one to the other.
  boost::boykov_kolmogorov_max_flow(graph, a.residual.data(), a.residual.data(), a.reverse.data(), a.parent_arc.data(),
                                    a.tree.data(), a.distance.data(),
                                    boost::typed_identity_property_map<std::uint32_t>(), nodes, nodes + 1);
  for (std::uint32_t i = 0; i < nodes; ++i) a.source_side[a.node[i]] = a.tree[i] == boost::black_color;
  return a.source_side;
}

}  // namespace gpvc::labeling
