#include "labeling/solver/expansion.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <span>

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kNotInCut = 0xFFFFFFFFu;

// Limits of sweep_borders(), chosen by time and energy on instances of three scenes (benchmarks/labeling): 0.2 % above the
// energy that sweeps over whole graphs reach, at most.

/// A label stops growing where what it costs more than the present labels, summed on the way from the seed, exceeds this
/// share of the mean weight around a node: no border is likely to move that far.
constexpr double kGrowthCost = 1.0 / 3;

/// A node is a seed of a label away from its border if the label costs less than its present one by this share of the
/// weights around the node.
constexpr double kSeedGain = 0.25;

/// So many first sweeps look at all nodes: a sweep moves borders to where other labels become possible.
constexpr int kSweepsOverAll = 2;

/// One thread's memory for cutting one label's graph.
struct Workspace {
  std::vector<std::uint32_t> local;  ///< node -> node of the cut, or kNotInCut
  std::vector<std::uint32_t> nodes;  ///< node of the cut -> node
  std::vector<Capacity> cost;        ///< of the label at each node of the cut
  std::vector<Capacity> excess;      ///< at each node of the cut, see kGrowthCost
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

struct Move {
  std::uint32_t node;
  Capacity cost;  ///< at the new label
};

struct Candidate {
  std::uint32_t node;
  float cost;
};

Grouped<Candidate> group_by_label(const LabelProblem& problem) {
  return group_items<Candidate>(problem.label_count, [&](const auto& add) {
    for (std::uint32_t node = 0; node < problem.nodes(); ++node)
      for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i)
        add(problem.labels[i], {node, problem.costs[i]});
  });
}

/// A label to be expanded, and a node to begin at.
struct Seed {
  std::uint32_t label, node;
};

}  // namespace

struct Expander::State {
  const LabelProblem& problem;
  std::vector<std::uint32_t>& labels;
  std::size_t batch;
  std::vector<Capacity> cost;          ///< per node, of its label
  std::vector<std::uint32_t> changed;  ///< per node, tick of its last change
  std::vector<std::uint32_t> in_vain;  ///< per label, tick of the last sweep if it found no move for it, else 0
  std::vector<std::uint32_t> proven;   ///< in_vain of the last sweep(), which cuts whole graphs; 0: never
  std::uint32_t tick = 1;              ///< number of the batch
  int sweeps = 0;
  bool fixpoint = false;
  Capacity most_excess = 0;           ///< kGrowthCost in units of 1 / scale
  std::vector<std::uint32_t> active;  ///< nodes that sweep_borders() looks at, ascending
  std::vector<std::uint32_t> moved;   ///< nodes that the current sweep changed
  Grouped<Candidate> by_label;        ///< all candidates; filled by the first sweep()
  tbb::enumerable_thread_specific<Workspace> workspaces;
  std::vector<std::uint32_t> mark;  ///< per node, number of the group of moves that it was last in
  std::uint32_t groups = 0;

  State(const LabelProblem& p, std::vector<std::uint32_t>& l, std::size_t b)
      : problem(p),
        labels(l),
        batch(b),
        cost(p.nodes()),
        changed(p.nodes(), 1),
        in_vain(p.label_count, 0),
        proven(p.label_count, 0),
        mark(p.nodes(), 0) {
    tbb::parallel_for(std::size_t{0}, cost.size(),
                      [&](std::size_t node) { cost[node] = cost_of(problem, node, labels[node]); });
    const auto nodes = static_cast<double>(std::max<std::size_t>(1, p.nodes()));
    most_excess = static_cast<Capacity>(kGrowthCost * p.weight_sum / nodes * p.scale);
    active.resize(p.nodes());
    std::iota(active.begin(), active.end(), 0u);
  }

  bool changed_since(std::uint32_t node, std::uint32_t then) const {
    if (changed[node] > then) return true;
    for (const auto& neighbour : problem.neighbours[node])
      if (changed[neighbour.node] > then) return true;
    return false;
  }

  bool nothing_changed_since(std::uint32_t alpha, std::uint32_t then) const {
    return then != 0 &&
           std::ranges::none_of(by_label[alpha], [&](const Candidate& c) { return changed_since(c.node, then); });
  }

  /// All nodes that may switch to alpha.
  void list_nodes(std::uint32_t alpha, Workspace& ws) const {
    for (const auto& [node, cost_of_alpha] : by_label[alpha])
      if (labels[node] != alpha) ws.add(node, problem.fixed(cost_of_alpha));
  }

  // --- seeds of sweep_borders()

  bool is_beside(std::uint32_t node, std::uint32_t label) const {
    return std::ranges::any_of(problem.neighbours[node], [&](const LabelProblem::Neighbour& neighbour) {
      return labels[neighbour.node] == label;
    });
  }

  Capacity weight_around(std::uint32_t node) const {
    Capacity weight = 0;
    for (const auto& neighbour : problem.neighbours[node]) weight += problem.fixed_weight(neighbour.weight);
    return weight;
  }

  void add_seeds(std::uint32_t node, std::vector<Seed>& seeds) const {
    const Capacity cheap = cost[node] - static_cast<Capacity>(kSeedGain * static_cast<double>(weight_around(node)));
    for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i) {
      const std::uint32_t label = problem.labels[i];
      if (label == labels[node]) continue;
      if (problem.fixed(problem.costs[i]) <= cheap || is_beside(node, label)) seeds.push_back({label, node});
    }
  }

  /// The seeds of each label among the active nodes.
  Grouped<std::uint32_t> find_seeds() const {
    constexpr std::size_t kBlock = 4096;
    std::vector<std::vector<Seed>> blocks((active.size() + kBlock - 1) / kBlock);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
      const std::size_t end = std::min(active.size(), (block + 1) * kBlock);
      for (std::size_t i = block * kBlock; i < end; ++i) add_seeds(active[i], blocks[block]);
    });
    return group_items<std::uint32_t>(problem.label_count, [&](const auto& add) {
      for (const std::vector<Seed>& block : blocks)
        for (const Seed& seed : block) add(seed.label, seed.node);
    });
  }

  /// The nodes that may switch to alpha near its seeds. All others keep their labels, such as those that no expansion of
  /// alpha can change, because it costs more there than all weights around the node.
  void list_around(std::span<const std::uint32_t> seeds, std::uint32_t alpha, Workspace& ws) const {
    std::vector<Capacity>& excess = ws.excess;
    excess.clear();
    const auto visit = [&](std::uint32_t node, Capacity excess_before) {
      if (labels[node] == alpha || ws.local[node] != kNotInCut) return;
      const std::size_t i = find_candidate(problem, node, alpha);
      if (i == kNoCandidate) return;
      const Capacity cost_of_alpha = problem.fixed(problem.costs[i]), more = cost_of_alpha - cost[node];
      const Capacity sum = std::max(Capacity{0}, excess_before + more);
      if (sum > most_excess || (more > 0 && more >= weight_around(node))) return;
      ws.add(node, cost_of_alpha);
      excess.push_back(sum);
    };
    for (const std::uint32_t node : seeds) visit(node, 0);
    std::size_t begin = 0;
    for (int step = 0; step < kReach && begin < ws.nodes.size(); ++step)
      for (const std::size_t end = ws.nodes.size(); begin < end; ++begin)
        for (const auto& neighbour : problem.neighbours[ws.nodes[begin]]) visit(neighbour.node, excess[begin]);
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

  /// The moves of an expansion over the listed nodes. Empties the list.
  std::vector<Move> cut(std::uint32_t alpha, Workspace& ws) const {
    std::vector<Move> moves;
    if (ws.nodes.empty()) return moves;
    fill(alpha, ws);
    const std::vector<std::uint8_t>& takes_alpha = ws.cut.solve();
    for (std::uint32_t here = 0; here < ws.nodes.size(); ++here) {
      if (takes_alpha[here] != 0) moves.push_back({ws.nodes[here], ws.cost[here]});
      ws.local[ws.nodes[here]] = kNotInCut;
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
        moved.push_back(move.node);
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

  /// The next active nodes: those that the sweep changed, and their neighbours.
  void activate_moved() {
    if (++sweeps < kSweepsOverAll) return;
    active.clear();
    const std::uint32_t id = ++groups;
    const auto add = [&](std::uint32_t node) {
      if (mark[node] == id) return;
      mark[node] = id;
      active.push_back(node);
    };
    for (const std::uint32_t node : moved) {
      add(node);
      for (const auto& neighbour : problem.neighbours[node]) add(neighbour.node);
    }
    std::ranges::sort(active);
  }

  /// One expansion of each label, batch by batch; list(label, workspace) lists the nodes to cut.
  template <class List>
  std::size_t expand_all(const List& list, const AfterBatch& after_batch) {
    std::size_t total = 0;
    std::vector<std::vector<Move>> moves;
    moved.clear();
    for (std::size_t begin = 0; begin < problem.label_count; begin += batch) {
      const std::size_t end = std::min(problem.label_count, begin + batch);
      moves.assign(end - begin, {});
      const std::uint32_t cut_at = tick++;
      tbb::parallel_for(
          begin, end,
          [&](std::size_t label) {
            Workspace& ws = workspaces.local();
            ws.clear(problem.nodes());
            list(static_cast<std::uint32_t>(label), ws);
            moves[label - begin] = cut(static_cast<std::uint32_t>(label), ws);
          },
          tbb::simple_partitioner());
      for (std::size_t label = begin; label < end; ++label) {
        in_vain[label] = moves[label - begin].empty() ? cut_at : 0;
        total += apply(static_cast<std::uint32_t>(label), moves[label - begin]);
      }
      if (after_batch) after_batch();
    }
    activate_moved();
    return total;
  }
};

Expander::Expander(const LabelProblem& problem, std::vector<std::uint32_t>& labels, std::size_t batch)
    : state_(std::make_unique<State>(problem, labels, batch)) {}
Expander::~Expander() = default;

std::size_t Expander::sweep(const AfterBatch& after_batch) {
  State& s = *state_;
  if (s.by_label.groups() != s.problem.label_count) s.by_label = group_by_label(s.problem);
  const std::size_t total = s.expand_all(
      [&](std::uint32_t alpha, Workspace& ws) {
        if (!s.nothing_changed_since(alpha, s.proven[alpha])) s.list_nodes(alpha, ws);
      },
      after_batch);
  s.proven = s.in_vain;
  s.fixpoint = total == 0;
  return total;
}

std::size_t Expander::sweep_borders(const AfterBatch& after_batch) {
  State& s = *state_;
  s.fixpoint = false;
  const Grouped<std::uint32_t> seeds = s.find_seeds();
  return s.expand_all([&](std::uint32_t alpha, Workspace& ws) { s.list_around(seeds[alpha], alpha, ws); }, after_batch);
}

bool Expander::is_fixpoint() const { return state_->fixpoint; }

}  // namespace gpvc::labeling
