// Items grouped by a number, in compressed rows: all items one after the other, and where each group begins.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace gpvc {

template <class Item>
struct Grouped {
  std::vector<std::size_t> first = {0};  ///< groups + 1 offsets into items
  std::vector<Item> items;

  std::size_t groups() const { return first.size() - 1; }
  std::span<Item> operator[](std::size_t group) {
    return {items.data() + first[group], first[group + 1] - first[group]};
  }
  std::span<const Item> operator[](std::size_t group) const {
    return {items.data() + first[group], first[group + 1] - first[group]};
  }
};
/// See members.h.
template <typename Item>
auto members_of(Grouped<Item>& grouped) {
  return std::tie(grouped.first, grouped.items);
}
template <typename Item>
auto members_of(const Grouped<Item>& grouped) {
  return std::tie(grouped.first, grouped.items);
}

/// Groups what for_each_item(add) passes to add(group, item), in that order within a group: a counting sort. The visitor
/// is called twice, to count and to fill, and must pass the same items both times. Uses the memory that `result` has.
/// O(groups + items).
template <class Item, class ForEachItem>
void group_items_into(Grouped<Item>& result, std::size_t groups, const ForEachItem& for_each_item) {
  std::vector<std::size_t>& first = result.first;
  // Counts are kept two places further on, so that after summing first[group + 1] is where the group's next item goes,
  // and after filling where the group ends.
  first.assign(groups + 2, 0);
  for_each_item([&](std::size_t group, const Item&) { ++first[group + 2]; });
  for (std::size_t i = 2; i < first.size(); ++i) first[i] += first[i - 1];
  result.items.resize(first.back());
  for_each_item([&](std::size_t group, const Item& item) { result.items[first[group + 1]++] = item; });
  first.pop_back();
}

/// As group_items_into, in memory of its own.
template <class Item, class ForEachItem>
Grouped<Item> group_items(std::size_t groups, const ForEachItem& for_each_item) {
  Grouped<Item> result;
  group_items_into(result, groups, for_each_item);
  return result;
}

/// Groups what visit(i, add) passes to add(group, item) for i = 0 ... numbers - 1, in that order within a group. The
/// visitor is called twice for each number, for several numbers at once, and must pass the same items both times.
/// O(groups + items), TBB; four bytes a group and thread more than group_items(), of four threads at most.
template <class Item, class Visit>
Grouped<Item> group_numbered(std::size_t groups, std::size_t numbers, const Visit& visit) {
  constexpr std::size_t kLeastNumbers = 1 << 14, kMostBlocks = 4;
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t blocks = std::max(std::size_t{1}, std::min({numbers / kLeastNumbers, threads, kMostBlocks}));
  const auto for_block = [&](std::size_t block, const auto& add) {
    for (std::size_t i = numbers * block / blocks; i < numbers * (block + 1) / blocks; ++i) visit(i, add);
  };
  if (blocks == 1) return group_items<Item>(groups, [&](const auto& add) { for_block(0, add); });
  // Of each block and group: how many items, then after how many of the group's its next one goes.
  std::vector<std::vector<std::uint32_t>> counts(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    std::vector<std::uint32_t>& count = counts[block];
    count.assign(groups, 0);
    for_block(block, [&](std::size_t group, const Item&) { ++count[group]; });
  });
  Grouped<Item> result;
  result.first.resize(groups + 1);
  for (std::size_t group = 0; group < groups; ++group) {
    std::uint32_t before = 0;
    for (std::vector<std::uint32_t>& count : counts) before += std::exchange(count[group], before);
    result.first[group + 1] = result.first[group] + before;
  }
  result.items.resize(result.first.back());
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    std::vector<std::uint32_t>& next = counts[block];
    for_block(block,
              [&](std::size_t group, const Item& item) { result.items[result.first[group] + next[group]++] = item; });
  });
  return result;
}

/// Per node, the other ends of the pairs that it is in, in the order of the pairs. O(nodes + pairs), TBB.
inline Grouped<std::uint32_t> group_neighbours(std::size_t nodes,
                                               const std::vector<std::array<std::uint32_t, 2>>& pairs) {
  return group_numbered<std::uint32_t>(nodes, pairs.size(), [&](std::size_t i, const auto& add) {
    const auto& [a, b] = pairs[i];
    add(a, b);
    add(b, a);
  });
}

}  // namespace gpvc
