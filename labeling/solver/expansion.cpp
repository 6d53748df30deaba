#include "labeling/solver/expansion.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kNotInCut = 0xFFFFFFFFu;

/// How many edges around a change a label is expanded again, before a sweep over whole graphs checks the result. Affects
/// the order of moves and the speed, not what counts as a fixpoint.
constexpr int kReach = 12;

Grouped<LabelProblem::Neighbour> weighted_neighbours(const CostTable& table, std::span<const WeightedPair> pairs) {
  const auto has_candidates = [&](std::uint32_t node) { return table.first[node] < table.first[node + 1]; };
  return group_items<LabelProblem::Neighbour>(table.faces(), [&](const auto& add) {
    for (const WeightedPair& pair : pairs) {
      if (!(pair.weight > 0) || !has_candidates(pair.a) || !has_candidates(pair.b)) continue;
      add(pair.a, {pair.b, pair.weight});
      add(pair.b, {pair.a, pair.weight});
    }
  });
}

Grouped<LabelProblem::Candidate> group_by_label(const CostTable& table) {
  const auto highest = std::ranges::max_element(table.views);
  const std::size_t labels = highest == table.views.end() ? 0 : std::size_t{*highest} + 1;
  return group_items<LabelProblem::Candidate>(labels, [&](const auto& add) {
    for (std::uint32_t node = 0; node < table.faces(); ++node)
      for (std::size_t i = table.first[node]; i < table.first[node + 1]; ++i)
        add(table.views[i], {node, table.costs[i]});
  });
}

/// The solver's sums are at most the cost of all candidates and all pairs together.
double scale_for(const LabelProblem& problem) {
  double bound = 1;
  for (const float cost : problem.costs) bound += static_cast<double>(cost);
  for (const LabelProblem::Neighbour& neighbour : problem.neighbours.items)
    bound += static_cast<double>(neighbour.weight);
  return std::ldexp(1.0, std::min(40, 60 - static_cast<int>(std::ceil(std::log2(bound)))));
}

/// One thread's memory for cutting one label's graph.
struct Workspace {
  std::vector<std::uint32_t> local;  ///< node -> node of the cut, or kNotInCut
  std::vector<std::uint32_t> nodes;  ///< node of the cut -> node
  std::vector<Capacity> cost;        ///< of the label at each node of the cut
  CutGraph cut;

  void clear(std::size_t problem_nodes) {
    local.resize(problem_nodes, kNotInCut);
    nodes.clear();
    cost.clear();
  }
  void add(std::uint32_t node, Capacity cost_of_label) {
    local[node] = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(node);
    cost.push_back(cost_of_label);
  }
};

Capacity cost_of(const LabelProblem& problem, std::size_t node, std::uint32_t label) {
  for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i)
    if (problem.labels[i] == label) return problem.fixed(problem.costs[i]);
  return 0;
}

struct Move {
  std::uint32_t node;
  Capacity cost;  ///< at the new label
};

}  // namespace

LabelProblem make_problem(const CostTable& table, std::span<const WeightedPair> pairs) {
  LabelProblem problem{table.first, table.views, table.costs, weighted_neighbours(table, pairs), group_by_label(table)};
  problem.scale = scale_for(problem);
  return problem;
}

std::vector<std::uint32_t> cheapest_labels(const LabelProblem& problem) {
  std::vector<std::uint32_t> result(problem.nodes(), kNoLabel);
  for (std::size_t node = 0; node < result.size(); ++node) {
    const std::span<const float> costs = problem.costs_of(node);
    if (costs.empty()) continue;
    const auto cheapest = std::min_element(costs.begin(), costs.end()) - costs.begin();
    result[node] = problem.labels_of(node)[static_cast<std::size_t>(cheapest)];
  }
  return result;
}

Capacity fixed_energy(const LabelProblem& problem, std::span<const std::uint32_t> labels) {
  Capacity energy = 0, twice_pairs = 0;
  for (std::size_t node = 0; node < problem.nodes(); ++node) {
    energy += cost_of(problem, node, labels[node]);
    for (const LabelProblem::Neighbour& neighbour : problem.neighbours[node])
      if (labels[neighbour.node] != labels[node]) twice_pairs += problem.fixed_weight(neighbour.weight);
  }
  return energy + twice_pairs / 2;
}

struct Expander::State {
  const LabelProblem& problem;
  std::vector<std::uint32_t>& labels;
  std::size_t batch;
  std::vector<Capacity> cost;          ///< per node, of its label
  std::vector<std::uint32_t> changed;  ///< per node, tick of its last change
  std::vector<std::uint32_t> looked;   ///< per label, tick at which its graph, or part of it, was last cut
  std::vector<std::uint32_t> proven;   ///< per label, tick at which a cut of its whole graph found no move; 0: never
  std::uint32_t tick = 1;              ///< number of the batch
  bool whole = true;                   ///< the next sweep cuts whole graphs
  bool fixpoint = false;
  tbb::enumerable_thread_specific<Workspace> workspaces;
  std::vector<std::uint32_t> mark;  ///< per node, number of the group of moves that it was last in
  std::uint32_t groups = 0;

  State(const LabelProblem& p, std::vector<std::uint32_t>& l, std::size_t b)
      : problem(p),
        labels(l),
        batch(b),
        cost(p.nodes()),
        changed(p.nodes(), 1),
        looked(p.label_count(), 0),
        proven(p.label_count(), 0),
        mark(p.nodes(), 0) {
    for (std::size_t node = 0; node < cost.size(); ++node) cost[node] = cost_of(problem, node, labels[node]);
  }

  bool changed_since(std::uint32_t node, std::uint32_t then) const {
    if (changed[node] > then) return true;
    for (const auto& neighbour : problem.neighbours[node])
      if (changed[neighbour.node] > then) return true;
    return false;
  }

  bool nothing_changed_since(std::uint32_t alpha, std::uint32_t then) const {
    return then != 0 && std::ranges::none_of(problem.by_label[alpha], [&](const LabelProblem::Candidate& c) {
             return changed_since(c.node, then);
           });
  }

  /// All nodes that may switch to alpha.
  void list_nodes(std::uint32_t alpha, Workspace& ws) const {
    for (const auto& [node, cost_of_alpha] : problem.by_label[alpha])
      if (labels[node] != alpha) ws.add(node, problem.fixed(cost_of_alpha));
  }

  /// The nodes that may switch to alpha within kReach edges of a change since alpha was last cut. All others keep their
  /// labels.
  void list_surroundings(std::uint32_t alpha, Workspace& ws) const {
    const std::span<const LabelProblem::Candidate> all = problem.by_label[alpha];
    for (const auto& [node, cost_of_alpha] : all)
      if (labels[node] != alpha && changed_since(node, looked[alpha])) ws.add(node, problem.fixed(cost_of_alpha));
    std::size_t begin = 0;
    for (int step = 0; step < kReach && begin < ws.nodes.size(); ++step) {
      const std::size_t end = ws.nodes.size();
      for (; begin < end; ++begin)
        for (const auto& neighbour : problem.neighbours[ws.nodes[begin]]) {
          if (ws.local[neighbour.node] != kNotInCut || labels[neighbour.node] == alpha) continue;
          const auto found = std::ranges::lower_bound(all, neighbour.node, {}, &LabelProblem::Candidate::node);
          if (found != all.end() && found->node == neighbour.node) ws.add(neighbour.node, problem.fixed(found->cost));
        }
    }
  }

  /// Fills the cut graph. A node on the source side takes alpha: x = 1. Nodes outside the graph keep their labels. A pair of
  /// nodes costs w unless both take alpha or both keep the same label:
  ///   same label now:    w |x - y|
  ///   different labels:  w (1 - x y) = w - w/2 x - w/2 y + w/2 |x - y|
  void fill(std::uint32_t alpha, Workspace& ws) const {
    CutGraph::Topology& cut = ws.cut.topology;
    cut.clear();
    for (std::uint32_t here = 0; here < ws.nodes.size(); ++here) {
      const std::uint32_t node = ws.nodes[here];
      Capacity gain = cost[node] - ws.cost[here];
      for (const auto& neighbour : problem.neighbours[node]) {
        const Capacity weight = problem.fixed_weight(neighbour.weight);
        const bool same = labels[neighbour.node] == labels[node];
        if (ws.local[neighbour.node] != kNotInCut) {
          cut.target.push_back(ws.local[neighbour.node]);
          cut.capacity.push_back(same ? weight : weight / 2);
          if (!same) gain += weight / 2;
        } else if (labels[neighbour.node] == alpha) {
          gain += weight;
        } else if (same) {
          gain -= weight;
        }
      }
      cut.first.push_back(static_cast<std::uint32_t>(cut.target.size()));
      cut.terminal.push_back(gain);
    }
    cut.link_reverse();
  }

  std::vector<Move> best_move(std::uint32_t alpha) {
    Workspace& ws = workspaces.local();
    ws.clear(problem.nodes());
    if (whole && nothing_changed_since(alpha, proven[alpha])) return {};
    if (whole)
      list_nodes(alpha, ws);
    else
      list_surroundings(alpha, ws);
    std::vector<Move> moves;
    if (!ws.nodes.empty()) {
      fill(alpha, ws);
      const std::vector<std::uint8_t>& takes_alpha = ws.cut.solve();
      for (std::uint32_t here = 0; here < ws.nodes.size(); ++here) {
        if (takes_alpha[here] != 0) moves.push_back({ws.nodes[here], ws.cost[here]});
        ws.local[ws.nodes[here]] = kNotInCut;
      }
    }
    return moves;
  }

  /// True if the energy falls when the group, marked with the latest number, takes alpha.
  bool lowers_energy(std::uint32_t alpha, std::span<const Move> group) const {
    Capacity change = 0;
    for (const Move& move : group) {
      change += move.cost - cost[move.node];
      for (const auto& neighbour : problem.neighbours[move.node]) {
        const Capacity weight = problem.fixed_weight(neighbour.weight);
        const bool both_move = mark[neighbour.node] == groups;
        if (labels[neighbour.node] != labels[move.node]) change -= both_move ? weight / 2 : weight;
        if (!both_move && labels[neighbour.node] != alpha) change += weight;
      }
    }
    return change < 0;
  }

  /// Extends the group, which holds its first move, by all moves connected with it, and marks them. Moves not in a group
  /// yet are marked `unvisited`; ws.local has their indices. Returns true if the group touches a change of this batch.
  bool collect_group(std::uint32_t unvisited, std::span<const Move> moves, const Workspace& ws,
                     std::vector<Move>& group) {
    const std::uint32_t id = ++groups;
    bool touched = false;
    mark[group[0].node] = id;
    for (std::size_t i = 0; i < group.size(); ++i) {
      touched |= changed[group[i].node] == tick;
      for (const auto& neighbour : problem.neighbours[group[i].node]) {
        touched |= changed[neighbour.node] == tick;
        if (mark[neighbour.node] != unvisited) continue;
        mark[neighbour.node] = id;
        group.push_back(moves[ws.local[neighbour.node]]);
      }
    }
    return touched;
  }

  /// Applies the moves of one label by connected groups. Each group lowers the energy by itself, since a cut's smallest
  /// source side contains no group that does not. A group that touches another label's move of the same batch was computed
  /// from labels that have changed since, and is applied only if it still lowers the energy. Returns the number of nodes
  /// that changed.
  std::size_t apply(std::uint32_t alpha, std::span<const Move> moves) {
    if (moves.empty()) return 0;
    const std::uint32_t unvisited = ++groups;
    for (const Move& move : moves) mark[move.node] = unvisited;
    Workspace& ws = workspaces.local();
    ws.local.resize(problem.nodes(), kNotInCut);
    for (std::uint32_t i = 0; i < moves.size(); ++i) ws.local[moves[i].node] = i;
    std::size_t count = 0;
    std::vector<Move> group;
    for (const Move& first_move : moves) {
      if (mark[first_move.node] != unvisited) continue;
      group.assign(1, first_move);
      if (collect_group(unvisited, moves, ws, group) && !lowers_energy(alpha, group)) continue;
      for (const Move& move : group) {
        labels[move.node] = alpha;
        cost[move.node] = move.cost;
      }
      count += group.size();
    }
    // `changed` is updated only now, so that groups of the same label do not count as touching each other.
    for (const Move& move : moves) {
      ws.local[move.node] = kNotInCut;
      if (labels[move.node] == alpha) changed[move.node] = tick;
    }
    return count;
  }
};

Expander::Expander(const LabelProblem& problem, std::vector<std::uint32_t>& labels, std::size_t batch)
    : state_(std::make_unique<State>(problem, labels, batch)) {}
Expander::~Expander() = default;

std::size_t Expander::sweep(const std::function<void()>& after_batch) {
  State& s = *state_;
  const std::size_t count = s.problem.label_count();
  std::size_t total = 0;
  std::vector<std::vector<Move>> moves;
  for (std::size_t begin = 0; begin < count; begin += s.batch) {
    const std::size_t end = std::min(count, begin + s.batch);
    moves.assign(end - begin, {});
    const std::uint32_t cut_at = s.tick++;
    tbb::parallel_for(
        begin, end, [&](std::size_t label) { moves[label - begin] = s.best_move(static_cast<std::uint32_t>(label)); },
        tbb::simple_partitioner());
    for (std::size_t label = begin; label < end; ++label) {
      s.looked[label] = cut_at;
      if (s.whole) s.proven[label] = moves[label - begin].empty() ? cut_at : 0;
      total += s.apply(static_cast<std::uint32_t>(label), moves[label - begin]);
    }
    if (after_batch) after_batch();
  }
  s.fixpoint = s.whole && total == 0;
  s.whole = total == 0;
  return total;
}

bool Expander::is_fixpoint() const { return state_->fixpoint; }

}  // namespace gpvc::labeling
