#include "labeling/solver/expansion.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "labeling/offsets.h"

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kNotHere = 0xFFFFFFFFu;

/// How far around a change a label is tried again before the whole graph has its turn. Only speed depends on it.
constexpr int kReach = 12;

void add_neighbours(LabelProblem& problem, std::span<const WeightedPair> pairs) {
  const auto has_candidates = [&](std::uint32_t node) { return problem.first[node] < problem.first[node + 1]; };
  const auto counts = [&](const WeightedPair& pair) {
    return pair.weight > 0 && has_candidates(pair.a) && has_candidates(pair.b);
  };
  problem.neighbour_first.assign(problem.nodes() + 1, 0);
  for (const WeightedPair& pair : pairs)
    if (counts(pair)) {
      ++problem.neighbour_first[pair.a];
      ++problem.neighbour_first[pair.b];
    }
  problem.neighbours.resize(offsets_from_counts(problem.neighbour_first));
  std::vector<std::size_t> next = problem.neighbour_first;
  for (const WeightedPair& pair : pairs)
    if (counts(pair)) {
      problem.neighbours[next[pair.a]++] = {pair.b, pair.weight};
      problem.neighbours[next[pair.b]++] = {pair.a, pair.weight};
    }
}

void add_candidates_by_label(LabelProblem& problem) {
  const std::size_t count =
      problem.labels.empty() ? 0 : std::size_t{*std::max_element(problem.labels.begin(), problem.labels.end())} + 1;
  problem.label_first.assign(count + 1, 0);
  for (const std::uint32_t label : problem.labels) ++problem.label_first[label];
  problem.by_label.resize(offsets_from_counts(problem.label_first));
  std::vector<std::size_t> next = problem.label_first;
  for (std::uint32_t node = 0; node < problem.nodes(); ++node)
    for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i)
      problem.by_label[next[problem.labels[i]]++] = {node, problem.costs[i]};
}

/// No sum of the solver exceeds what all candidates and all pairs together cost.
double scale_for(const LabelProblem& problem) {
  double bound = 1;
  for (const float cost : problem.costs) bound += static_cast<double>(cost);
  for (const LabelProblem::Neighbour& neighbour : problem.neighbours) bound += static_cast<double>(neighbour.weight);
  return std::ldexp(1.0, std::min(40, 60 - static_cast<int>(std::ceil(std::log2(bound)))));
}

/// What one thread needs to cut one label's graph.
struct Workspace {
  std::vector<std::uint32_t> local;  ///< node -> node of the cut, or kNotHere
  std::vector<std::uint32_t> nodes;  ///< node of the cut -> node
  std::vector<Capacity> cost;        ///< of the label at each node of the cut
  CutGraph cut;
};

struct Move {
  std::uint32_t node;
  Capacity cost;  ///< at the new label
};

}  // namespace

LabelProblem make_problem(std::span<const std::size_t> first, std::span<const std::uint32_t> labels,
                          std::span<const float> costs, std::span<const WeightedPair> pairs) {
  LabelProblem problem;
  problem.first = first;
  problem.labels = labels;
  problem.costs = costs;
  add_neighbours(problem, pairs);
  add_candidates_by_label(problem);
  problem.scale = scale_for(problem);
  return problem;
}

std::vector<std::uint32_t> cheapest_labels(const LabelProblem& problem) {
  std::vector<std::uint32_t> result(problem.nodes(), kNoLabel);
  for (std::size_t node = 0; node < result.size(); ++node) {
    const auto begin = problem.costs.begin() + static_cast<std::ptrdiff_t>(problem.first[node]);
    const auto end = problem.costs.begin() + static_cast<std::ptrdiff_t>(problem.first[node + 1]);
    if (begin != end)
      result[node] = problem.labels[static_cast<std::size_t>(std::min_element(begin, end) - problem.costs.begin())];
  }
  return result;
}

namespace {

Capacity cost_of(const LabelProblem& problem, std::size_t node, std::uint32_t label) {
  for (std::size_t i = problem.first[node]; i < problem.first[node + 1]; ++i)
    if (problem.labels[i] == label) return problem.fixed(problem.costs[i]);
  return 0;
}

}  // namespace

Capacity fixed_energy(const LabelProblem& problem, std::span<const std::uint32_t> labels) {
  Capacity energy = 0, twice_pairs = 0;
  for (std::size_t node = 0; node < problem.nodes(); ++node) {
    energy += cost_of(problem, node, labels[node]);
    for (std::size_t i = problem.neighbour_first[node]; i < problem.neighbour_first[node + 1]; ++i)
      if (labels[problem.neighbours[i].node] != labels[node])
        twice_pairs += problem.fixed_weight(problem.neighbours[i].weight);
  }
  return energy + twice_pairs / 2;
}

struct Expander::State {
  const LabelProblem& problem;
  std::vector<std::uint32_t>& labels;
  std::size_t batch;
  std::vector<Capacity> cost;          ///< of each node's label
  std::vector<std::uint32_t> changed;  ///< per node, tick of its last change
  std::vector<std::uint32_t> looked;   ///< per label, tick at which its graph, or part of it, was last cut
  std::vector<std::uint32_t> proven;   ///< per label, tick at which its whole graph was last cut in vain, or 0
  std::uint32_t tick = 1;              ///< one a batch
  bool whole = true;                   ///< the next sweep looks at whole graphs
  bool fixpoint = false;
  tbb::enumerable_thread_specific<Workspace> workspaces;
  std::vector<std::uint32_t> mark;  ///< per node, group of the moves being applied
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

  std::span<const LabelProblem::Neighbour> neighbours(std::uint32_t node) const {
    return {problem.neighbours.data() + problem.neighbour_first[node],
            problem.neighbour_first[node + 1] - problem.neighbour_first[node]};
  }
  std::span<const LabelProblem::Candidate> candidates(std::uint32_t label) const {
    return {problem.by_label.data() + problem.label_first[label],
            problem.label_first[label + 1] - problem.label_first[label]};
  }

  bool changed_since(std::uint32_t node, std::uint32_t then) const {
    if (changed[node] > then) return true;
    for (const auto& neighbour : neighbours(node))
      if (changed[neighbour.node] > then) return true;
    return false;
  }

  bool nothing_changed_since(std::uint32_t alpha, std::uint32_t then) const {
    if (then == 0) return false;
    const auto all = candidates(alpha);
    return std::none_of(all.begin(), all.end(),
                        [&](const LabelProblem::Candidate& c) { return changed_since(c.node, then); });
  }

  void list_nodes(std::uint32_t alpha, Workspace& ws) const;
  void list_surroundings(std::uint32_t alpha, Workspace& ws) const;
  void fill(std::uint32_t alpha, Workspace& ws) const;
  std::vector<Move> best_move(std::uint32_t alpha);
  bool still_pays(std::uint32_t alpha, std::span<const Move> group) const;
  std::size_t apply(std::uint32_t alpha, std::vector<Move>& moves);
};

/// All nodes that may switch to alpha.
void Expander::State::list_nodes(std::uint32_t alpha, Workspace& ws) const {
  for (const auto& [node, cost_of_alpha] : candidates(alpha)) {
    if (labels[node] == alpha) continue;
    ws.local[node] = static_cast<std::uint32_t>(ws.nodes.size());
    ws.nodes.push_back(node);
    ws.cost.push_back(problem.fixed(cost_of_alpha));
  }
}

/// Those within kReach steps of a change since alpha was last looked at; the others stay as they are.
void Expander::State::list_surroundings(std::uint32_t alpha, Workspace& ws) const {
  const auto all = candidates(alpha);
  const auto add = [&](std::uint32_t node, Capacity cost_of_alpha) {
    ws.local[node] = static_cast<std::uint32_t>(ws.nodes.size());
    ws.nodes.push_back(node);
    ws.cost.push_back(cost_of_alpha);
  };
  for (const auto& [node, cost_of_alpha] : all)
    if (labels[node] != alpha && changed_since(node, looked[alpha])) add(node, problem.fixed(cost_of_alpha));
  std::size_t begin = 0;
  for (int step = 0; step < kReach && begin < ws.nodes.size(); ++step) {
    const std::size_t end = ws.nodes.size();
    for (; begin < end; ++begin)
      for (const auto& neighbour : neighbours(ws.nodes[begin])) {
        if (ws.local[neighbour.node] != kNotHere || labels[neighbour.node] == alpha) continue;
        const auto found =
            std::lower_bound(all.begin(), all.end(), neighbour.node,
                             [](const LabelProblem::Candidate& c, std::uint32_t node) { return c.node < node; });
        if (found != all.end() && found->node == neighbour.node) add(neighbour.node, problem.fixed(found->cost));
      }
  }
}

/// Source side = takes alpha. With x = 1 for that, and nodes outside the graph fixed, a pair of nodes costs w
/// unless both take alpha or both keep one and the same label:
///   same label now:    w |x - y|
///   different labels:  w (1 - x y) = w - w/2 x - w/2 y + w/2 |x - y|
void Expander::State::fill(std::uint32_t alpha, Workspace& ws) const {
  CutGraph::Topology& cut = ws.cut.topology;
  cut.clear();
  for (std::uint32_t here = 0; here < ws.nodes.size(); ++here) {
    const std::uint32_t node = ws.nodes[here];
    Capacity gain = cost[node] - ws.cost[here];
    for (const auto& neighbour : neighbours(node)) {
      const Capacity weight = problem.fixed_weight(neighbour.weight);
      const bool same = labels[neighbour.node] == labels[node];
      if (ws.local[neighbour.node] != kNotHere) {
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

std::vector<Move> Expander::State::best_move(std::uint32_t alpha) {
  Workspace& ws = workspaces.local();
  ws.local.resize(problem.nodes(), kNotHere);
  ws.nodes.clear();
  ws.cost.clear();
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
      ws.local[ws.nodes[here]] = kNotHere;
    }
  }
  return moves;
}

/// The change in energy if the marked group took alpha now.
bool Expander::State::still_pays(std::uint32_t alpha, std::span<const Move> group) const {
  Capacity change = 0;
  for (const Move& move : group) {
    change += move.cost - cost[move.node];
    for (const auto& neighbour : neighbours(move.node)) {
      const Capacity weight = problem.fixed_weight(neighbour.weight);
      const bool both_move = mark[neighbour.node] == groups;
      if (labels[neighbour.node] != labels[move.node]) change -= both_move ? weight / 2 : weight;
      if (!both_move && labels[neighbour.node] != alpha) change += weight;
    }
  }
  return change < 0;
}

/// Applies the moves of one label, connected group by connected group: each lowers the energy by itself, for a cut's
/// smallest source side holds no group that does not. A group that touches another label's move of the same batch was
/// computed on labels that are no more, and is looked at again.
std::size_t Expander::State::apply(std::uint32_t alpha, std::vector<Move>& moves) {
  if (moves.empty()) return 0;
  const std::uint32_t unseen = ++groups;
  for (const Move& move : moves) mark[move.node] = unseen;
  Workspace& ws = workspaces.local();
  ws.local.resize(problem.nodes(), kNotHere);
  for (std::uint32_t i = 0; i < moves.size(); ++i) ws.local[moves[i].node] = i;
  std::size_t count = 0;
  std::vector<Move> group;
  for (const Move& seed : moves) {
    if (mark[seed.node] != unseen) continue;
    const std::uint32_t id = ++groups;
    bool touched = false;
    group.assign(1, seed);
    mark[seed.node] = id;
    for (std::size_t i = 0; i < group.size(); ++i) {
      touched |= changed[group[i].node] == tick;
      for (const auto& neighbour : neighbours(group[i].node)) {
        touched |= changed[neighbour.node] == tick;
        if (mark[neighbour.node] != unseen) continue;
        mark[neighbour.node] = id;
        group.push_back(moves[ws.local[neighbour.node]]);
      }
    }
    if (touched && !still_pays(alpha, group)) continue;
    for (const Move& move : group) {
      labels[move.node] = alpha;
      cost[move.node] = move.cost;
    }
    count += group.size();
  }
  // Stamped now and not before: groups of one label do not touch each other.
  for (const Move& move : moves) {
    ws.local[move.node] = kNotHere;
    if (labels[move.node] == alpha) changed[move.node] = tick;
  }
  return count;
}

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
