#include "atlas/leveling/offset_system.h"

#include <gtest/gtest.h>

#include <random>

namespace gpvc::atlas {
namespace {

/// A square grid of nodes with links of weight 1, in two halves that only links of `weight` join, and an anchor.
OffsetSystem grid_system(std::uint32_t edge, float weight) {
  const auto joins = [&](std::uint32_t x) { return x + 1 == edge / 2 ? weight : 1.0f; };
  OffsetSystem system;
  system.links = group_items<LinkTo>(edge * edge, [&](const auto& add) {
    for (std::uint32_t y = 0; y < edge; ++y) {
      for (std::uint32_t x = 0; x < edge; ++x) {
        const std::uint32_t i = y * edge + x;
        if (x > 0) add(i, LinkTo{i - 1, joins(x - 1)});
        if (x + 1 < edge) add(i, LinkTo{i + 1, joins(x)});
        if (y > 0) add(i, LinkTo{i - edge, 1});
        if (y + 1 < edge) add(i, LinkTo{i + edge, 1});
      }
    }
  });
  for (std::uint32_t i = 0; i < edge * edge; ++i) {
    system.diagonal.push_back(1e-3f);
    for (const LinkTo& to : system.links[i]) system.diagonal.back() += to.weight;
  }
  return system;
}

TEST(OffsetSystem, SmoothAndRoughOffsetsAreFound) {
  for (const float weight : {1.0f, 0.01f}) {
    constexpr std::uint32_t kEdge = 90;
    const OffsetSystem system = grid_system(kEdge, weight);
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, 1);
    Offsets truth(system.size()), right(system.size());
    for (std::uint32_t i = 0; i < truth.size(); ++i) {
      const float x = static_cast<float>(i % kEdge), y = static_cast<float>(i / kEdge);
      truth[i] = Offset(x < kEdge / 2 ? 20 : -10, 0.2f * y, noise(random), 0);
    }
    for (std::size_t i = 0; i < right.size(); ++i) right[i] = system.times(truth, i);
    const Offsets found = solve(system, right);
    Offset error = Offset::Zero();
    for (std::size_t i = 0; i < truth.size(); ++i) error += (found[i] - truth[i]).square();
    error = (error / static_cast<float>(truth.size())).sqrt();
    EXPECT_LT(error.maxCoeff(), 0.2f) << weight;
    EXPECT_EQ(error[3], 0);
  }
}

// As of a vertex of a million faces, after one of few: each link stands once, where it came first.
TEST(OffsetSystem, LinksOfANodeToTheSameNodesAreSummed) {
  LinkSums sums;
  std::size_t begin = 0;
  for (const std::uint32_t nodes : {5u, 1'000'000u, 33u, 40u, 32u}) {
    sums.next_node();
    for (int twice = 0; twice < 2; ++twice)
      for (std::uint32_t node = nodes; node-- > 0;) sums.add(node, 0.5f);
    ASSERT_EQ(sums.items.size(), begin + nodes);
    for (std::uint32_t i = 0; i < nodes; ++i) {
      ASSERT_EQ(sums.items[begin + i].node, nodes - 1 - i) << nodes;
      ASSERT_EQ(sums.items[begin + i].weight, 1) << nodes;
    }
    begin = sums.items.size();
  }
}

// Rows are made in blocks, which differ in length.
TEST(OffsetSystem, RowsFollowTheirNodes) {
  constexpr std::size_t kNodes = 10'000;
  const auto links_of = [](std::size_t i) { return i % 7 + (i > 5000 ? 3 : 0); };
  const OffsetSystem system = make_rows(kNodes, [&](std::size_t i, LinkSums& sums) {
    for (std::size_t k = 0; k < links_of(i); ++k) sums.add(static_cast<std::uint32_t>(i + k), 1);
    return static_cast<float>(i);
  });
  ASSERT_EQ(system.size(), kNodes);
  ASSERT_EQ(system.links.groups(), kNodes);
  for (std::size_t i = 0; i < kNodes; ++i) {
    ASSERT_EQ(system.diagonal[i], static_cast<float>(i));
    ASSERT_EQ(system.links[i].size(), links_of(i)) << i;
    for (std::size_t k = 0; k < links_of(i); ++k) ASSERT_EQ(system.links[i][k].node, i + k);
  }
}

TEST(OffsetSystem, NothingHasNoOffsets) {
  EXPECT_TRUE(solve(OffsetSystem{}, {}).empty());
  const OffsetSystem lone{{2.0f, 1e-3f}, {{0, 0, 0}, {}}};
  const Offsets found = solve(lone, {Offset(4, 2, 0, 0), Offset::Zero()});
  EXPECT_FLOAT_EQ(found[0][0], 2);
  EXPECT_FLOAT_EQ(found[0][1], 1);
  EXPECT_EQ(found[1][0], 0);
}

}  // namespace
}  // namespace gpvc::atlas
