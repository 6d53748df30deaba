// The linear system of the offsets, and its solution by conjugate gradients on several levels.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
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
  LinkSums(std::vector<LinkTo>& items, std::size_t nodes) : items_(items), place_(nodes, 0) {}
  void next_node() { begin_ = items_.size(); }
  void add(std::uint32_t node, float weight) {
    std::size_t& place = place_[node];
    if (place >= begin_ && place < items_.size() && items_[place].node == node) {
      items_[place].weight += weight;
      return;
    }
    place = items_.size();
    items_.push_back({node, weight});
  }

 private:
  std::vector<LinkTo>& items_;
  std::vector<std::size_t> place_;  ///< per node, of its last link; stale where that is another node's
  std::size_t begin_ = 0;
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

/// The unknowns x with system x = right, for the three channels at once. Deterministic. Some twenty iterations,
/// whatever the number of unknowns.
Offsets solve(const OffsetSystem& system, Offsets right);

}  // namespace gpvc::atlas
