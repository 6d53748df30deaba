#include "io/grouping.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

namespace gpvc {
namespace {

TEST(Grouping, ItemsKeepTheirOrderWithinAGroup) {
  const std::size_t keys[] = {2, 0, 2, 3, 0, 2};
  const Grouped<int> grouped = group_items<int>(5, [&](const auto& add) {
    for (int i = 0; i < 6; ++i) add(keys[i], i);
  });
  EXPECT_EQ(grouped.groups(), 5u);
  EXPECT_EQ(grouped.first, (std::vector<std::size_t>{0, 2, 2, 5, 6, 6}));
  EXPECT_EQ(grouped.items, (std::vector{1, 4, 0, 2, 5, 3}));
  EXPECT_EQ(grouped[2].size(), 3u);
  EXPECT_EQ(grouped[2][1], 2);
  EXPECT_TRUE(grouped[4].empty());
}

// So many that they are grouped in several blocks, where threads allow.
TEST(Grouping, ManyNumbersKeepTheirOrderOnAnyNumberOfThreads) {
  constexpr std::size_t kGroups = 1000, kNumbers = 200'000;
  const auto visit = [](std::size_t i, const auto& add) {
    add(i * 7919 % kGroups, static_cast<int>(i));
    if (i % 3 == 0) add(i % 10, -static_cast<int>(i));
  };
  const Grouped<int> expected = group_items<int>(kGroups, [&](const auto& add) {
    for (std::size_t i = 0; i < kNumbers; ++i) visit(i, add);
  });
  for (const int threads : {1, 2, 3, 16}) {
    tbb::task_arena arena(threads);
    const Grouped<int> grouped = arena.execute([&] { return group_numbered<int>(kGroups, kNumbers, visit); });
    EXPECT_EQ(grouped.first, expected.first) << threads;
    EXPECT_EQ(grouped.items, expected.items) << threads;
  }
}

TEST(Grouping, NoGroups) {
  EXPECT_EQ(group_numbered<int>(3, 0, [](std::size_t, const auto&) {}).first, (std::vector<std::size_t>(4, 0)));
  EXPECT_EQ(Grouped<int>().groups(), 0u);
  EXPECT_EQ(group_items<int>(0, [](const auto&) {}).first, (std::vector<std::size_t>{0}));
}

}  // namespace
}  // namespace gpvc
