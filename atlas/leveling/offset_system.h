// The linear system of the offsets, and its solution by conjugate gradients on several levels.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "io/grouping.h"

namespace gpvc::atlas {

/// R, G, B and a fourth number that is always 0, because four floats fill a register.
using Offset = Eigen::Array4f;
using Offsets = std::vector<Offset>;

/// A term of the energy, the squared difference of two offsets, as one of them sees it.
struct LinkTo {
  std::uint32_t node;
  float weight;
};
using Links = Grouped<LinkTo>;

/// Collects the links of one node after another, several to the same node as one. O(1) a link, whatever a node's valence.
class LinkSums {
 public:
  void next_node() { begin_ = items.size(); }
  void add(std::uint32_t node, float weight) {
    const std::size_t place = find(node);
    if (place < items.size()) {
      items[place].weight += weight;
      return;
    }
    items.push_back({node, weight});
    if (count() > kSearched) note_places();
  }

  std::vector<LinkTo> items;  ///< of all nodes so far

 private:
  /// Of so many links of a node the one to another node is searched for, of more it is looked up.
  static constexpr std::size_t kSearched = 32;

  std::size_t count() const { return items.size() - begin_; }
  /// The place of this node's link to another, items.size() where it has none yet.
  std::size_t find(std::uint32_t node) const;
  void note_places();

  std::size_t begin_ = 0;
  std::unordered_map<std::uint32_t, std::size_t>
      places_;  ///< of this node's links, by the other node, if they are many
};

/// A symmetric positive definite matrix: the diagonal minus the links. No diagonal element is less than the sum of its
/// links' weights.
struct OffsetSystem {
  std::vector<float> diagonal;
  Links links;  ///< one for each pair of unknowns

  std::size_t size() const { return diagonal.size(); }
  Offset times(const Offsets& x, std::size_t i) const {
    Offset sum = diagonal[i] * x[i];
    for (const LinkTo& to : links[i]) sum -= to.weight * x[to.node];
    return sum;
  }
  template <typename Body>
  void for_each(const Body& body) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, size(), 2048), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
    });
  }
  /// Sums in an order that does not depend on the number of threads.
  template <typename Term>
  Offset sum(const Term& term) const {
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, size(), 4096), Offset(Offset::Zero()),
        [&](const auto& range, Offset partial) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) partial += term(i);
          return partial;
        },
        [](const Offset& a, const Offset& b) { return Offset(a + b); });
  }
};

/// The system whose row i has the links that add_links(i, sums) adds to the sums, and the diagonal element that it
/// returns. Called for several nodes at once.
template <typename AddLinks>
OffsetSystem make_rows(std::size_t nodes, const AddLinks& add_links) {
  constexpr std::size_t kBlock = 4096;
  std::vector<std::vector<LinkTo>> blocks((nodes + kBlock - 1) / kBlock);
  const auto for_block = [&](std::size_t block, const auto& body) {
    for (std::size_t i = block * kBlock; i < std::min(nodes, (block + 1) * kBlock); ++i) body(i);
  };
  OffsetSystem system;
  system.diagonal.resize(nodes);
  std::vector<std::size_t>& first = system.links.first;
  first.resize(nodes + 1);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    LinkSums sums;
    for_block(block, [&](std::size_t i) {
      sums.next_node();
      system.diagonal[i] = add_links(i, sums);
      first[i + 1] = sums.items.size();  // within the block as yet
    });
    blocks[block] = std::move(sums.items);
  });
  std::vector<std::size_t> begin(blocks.size() + 1, 0);
  for (std::size_t block = 0; block < blocks.size(); ++block) begin[block + 1] = begin[block] + blocks[block].size();
  system.links.items.resize(begin.back());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    for_block(block, [&](std::size_t i) { first[i + 1] += begin[block]; });
    std::ranges::copy(blocks[block], system.links.items.begin() + static_cast<std::ptrdiff_t>(begin[block]));
    blocks[block] = {};
  });
  return system;
}

/// The unknowns x with system x = right, for the three channels at once. Deterministic. Some twenty iterations,
/// whatever the number of unknowns.
Offsets solve(const OffsetSystem& system, Offsets right);

}  // namespace gpvc::atlas
