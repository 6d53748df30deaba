#include "atlas/leveling/offset_system.h"

#include <algorithm>

namespace gpvc::atlas {

namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

float strongest(std::span<const LinkTo> links) {
  float weight = 0;
  for (const LinkTo& to : links) weight = std::max(weight, to.weight);
  return weight;
}

/// Nodes whose offsets are nearly equal, because strong links join them.
struct Aggregates {
  std::vector<std::uint32_t> of_node;
  std::uint32_t count = 0;
};

/// Each aggregate is a node with its neighbours by strong links, where all of them are still free. The nodes that this
/// leaves join the aggregate of their strongest neighbour.
Aggregates aggregate(const OffsetSystem& system) {
  // Relative to the node's strongest link. Across a seam with little evidence offsets differ.
  constexpr float kStrong = 0.5f;
  Aggregates result{std::vector<std::uint32_t>(system.size(), kNone), 0};
  std::vector<std::uint32_t>& of_node = result.of_node;
  for (std::uint32_t i = 0; i < of_node.size(); ++i) {
    const auto links = system.links[i];
    const float least = kStrong * strongest(links);
    const auto taken = [&](const LinkTo& to) { return to.weight >= least && of_node[to.node] != kNone; };
    if (of_node[i] != kNone || std::ranges::any_of(links, taken)) continue;
    of_node[i] = result.count;
    for (const LinkTo& to : links)
      if (to.weight >= least) of_node[to.node] = result.count;
    ++result.count;
  }
  const std::vector<std::uint32_t> seeded = of_node;
  for (std::uint32_t i = 0; i < of_node.size(); ++i) {
    if (of_node[i] != kNone) continue;
    float best = 0;
    for (const LinkTo& to : system.links[i]) {
      if (seeded[to.node] == kNone || to.weight <= best) continue;
      best = to.weight;
      of_node[i] = seeded[to.node];
    }
    if (of_node[i] == kNone) of_node[i] = result.count++;
  }
  return result;
}

/// The system that remains if all nodes of an aggregate have one offset.
OffsetSystem coarsen(const OffsetSystem& fine, const std::vector<std::uint32_t>& of_node,
                     const Grouped<std::uint32_t>& members) {
  // Offsets that are constant within aggregates put all of a slope on the links between them, which makes the coarse
  // system too stiff. Any weights serve as a preconditioner; with these the fewest iterations are needed.
  constexpr float kSoftened = 1 / 1.5f;
  return make_rows(members.groups(), [&](std::size_t k, LinkSums& links) {
    float diagonal = 0;
    for (const std::uint32_t i : members[k]) {
      diagonal += fine.diagonal[i];
      for (const LinkTo& to : fine.links[i]) {
        const std::uint32_t other = of_node[to.node];
        diagonal -= other == k ? to.weight : (1 - kSoftened) * to.weight;
        if (other != k) links.add(other, kSoftened * to.weight);
      }
    }
    return diagonal;
  });
}

/// An approximate inverse: symmetric and positive, so that it preconditions conjugate gradients. The finest level adds
/// the inverse of its diagonal to what the coarser levels answer, which are solved by a V-cycle (Briggs, Henson and
/// McCormick, A Multigrid Tutorial, 2000) with damped Jacobi steps.
class Preconditioner {
 public:
  explicit Preconditioner(const OffsetSystem& finest) : finest_(finest) {
    // Few nodes are left to their Jacobi steps, and so are those that no longer aggregate.
    constexpr std::size_t kFew = 200;
    const OffsetSystem* fine = &finest;
    while (fine->size() > kFew) {
      Level level;
      Aggregates aggregates = aggregate(*fine);
      if (aggregates.count > fine->size() / 5 * 4) break;
      level.of_node = std::move(aggregates.of_node);
      level.members = group_items<std::uint32_t>(aggregates.count, [&](const auto& add) {
        for (std::uint32_t i = 0; i < level.of_node.size(); ++i) add(level.of_node[i], i);
      });
      level.system = coarsen(*fine, level.of_node, level.members);
      for (Offsets* list : {&level.right, &level.x, &level.rest}) list->resize(aggregates.count);
      levels_.push_back(std::move(level));
      fine = &levels_.back().system;
    }
  }

  /// Makes z the approximate solution for the residuals r.
  void apply(const Offsets& r, Offsets& z) {
    if (!levels_.empty()) {
      restrict_to(levels_[0], r);
      cycle(0);
    }
    finest_.for_each([&](std::size_t i) {
      z[i] = r[i] / finest_.diagonal[i];
      if (!levels_.empty()) z[i] += levels_[0].x[levels_[0].of_node[i]];
    });
  }

 private:
  struct Level {
    OffsetSystem system;
    std::vector<std::uint32_t> of_node;  ///< per node of the finer level, the node here
    Grouped<std::uint32_t> members;      ///< the reverse
    Offsets right, x, rest;
  };

  static void restrict_to(Level& level, const Offsets& finer) {
    level.system.for_each([&](std::size_t k) {
      Offset sum = Offset::Zero();
      for (const std::uint32_t i : level.members[k]) sum += finer[i];
      level.right[k] = sum;
    });
  }

  static constexpr float kDamping = 0.7f;

  static void find_rest(Level& level) {
    level.system.for_each([&](std::size_t i) { level.rest[i] = level.right[i] - level.system.times(level.x, i); });
  }

  static void smooth(Level& level) {
    find_rest(level);
    level.system.for_each([&](std::size_t i) { level.x[i] += level.rest[i] * (kDamping / level.system.diagonal[i]); });
  }

  /// Solves a level for its right side, approximately.
  void cycle(std::size_t number) {
    Level& level = levels_[number];
    level.system.for_each([&](std::size_t i) { level.x[i] = level.right[i] * (kDamping / level.system.diagonal[i]); });
    if (number + 1 == levels_.size()) {
      for (int k = 0; k < 10; ++k) smooth(level);
      return;
    }
    find_rest(level);
    Level& coarser = levels_[number + 1];
    restrict_to(coarser, level.rest);
    cycle(number + 1);
    level.system.for_each([&](std::size_t i) { level.x[i] += coarser.x[coarser.of_node[i]]; });
    smooth(level);
  }

  const OffsetSystem& finest_;
  std::vector<Level> levels_;
};

}  // namespace

std::size_t LinkSums::find(std::uint32_t node) const {
  if (count() > kSearched) {
    const auto found = places_.find(node);
    return found == places_.end() ? items.size() : found->second;
  }
  std::size_t place = begin_;
  while (place < items.size() && items[place].node != node) ++place;
  return place;
}

void LinkSums::note_places() {
  if (count() == kSearched + 1) {
    places_.clear();
    for (std::size_t i = begin_; i + 1 < items.size(); ++i) places_.emplace(items[i].node, i);
  }
  places_.emplace(items.back().node, items.size() - 1);
}

Offsets solve(const OffsetSystem& system, Offsets right) {
  // A relative residual of 3e-3 leaves errors of 0.1 grey levels (root mean square over all nodes of two scenes).
  constexpr float kTolerance = 3e-3f;
  constexpr int kMostIterations = 300;
  const std::size_t n = system.size();
  Preconditioner inverse(system);
  Offsets x(n, Offset::Zero()), p(n), q(n);
  Offsets& r = right;
  const auto norm = [&](std::size_t i) { return Offset(r[i] * r[i] / system.diagonal[i]); };
  Offset rest = system.sum(norm), rho = Offset::Zero();
  const Offset target = kTolerance * kTolerance * rest;
  for (int k = 0; k < kMostIterations && (rest > target).any(); ++k) {
    inverse.apply(r, q);
    const Offset next = system.sum([&](std::size_t i) { return Offset(r[i] * q[i]); });
    const Offset beta = (rho > 0).select(next / rho, Offset::Zero());
    rho = next;
    if (k == 0)
      std::swap(p, q);
    else
      system.for_each([&](std::size_t i) { p[i] = q[i] + beta * p[i]; });
    const Offset pq = system.sum([&](std::size_t i) {
      q[i] = system.times(p, i);
      return Offset(p[i] * q[i]);
    });
    const Offset alpha = (pq > 0).select(rho / pq, Offset::Zero());
    rest = system.sum([&](std::size_t i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
      return norm(i);
    });
  }
  return x;
}

}  // namespace gpvc::atlas
