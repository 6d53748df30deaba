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

// As of a vertex of a million faces: each link stands once, where it came first.
TEST(OffsetSystem, LinksOfANodeToTheSameNodesAreSummed) {
  constexpr std::uint32_t kNodes = 1'000'000;
  std::vector<LinkTo> items{{7, 1}};
  LinkSums sums(items, kNodes);
  sums.next_node();
  for (int twice = 0; twice < 2; ++twice)
    for (std::uint32_t node = kNodes; node-- > 0;) sums.add(node, 0.5f);
  ASSERT_EQ(items.size(), 1 + std::size_t{kNodes});
  EXPECT_EQ(items[0].weight, 1) << "a node before";
  for (std::uint32_t i = 0; i < kNodes; i += 1000) {
    EXPECT_EQ(items[1 + i].node, kNodes - 1 - i);
    EXPECT_EQ(items[1 + i].weight, 1);
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
