#include "io/grouping.h"

#include <gtest/gtest.h>

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

TEST(Grouping, NoGroups) {
  EXPECT_EQ(Grouped<int>().groups(), 0u);
  EXPECT_EQ(group_items<int>(0, [](const auto&) {}).first, (std::vector<std::size_t>{0}));
}

}  // namespace
}  // namespace gpvc
