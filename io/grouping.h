// Items grouped by a number, in compressed rows: all items one after the other, and where each group begins.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
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

/// Per node, the other ends of the pairs that it is in, in the order of the pairs. O(nodes + pairs).
inline Grouped<std::uint32_t> group_neighbours(std::size_t nodes,
                                               const std::vector<std::array<std::uint32_t, 2>>& pairs) {
  return group_items<std::uint32_t>(nodes, [&](const auto& add) {
    for (const auto& [a, b] : pairs) {
      add(a, b);
      add(b, a);
    }
  });
}

}  // namespace gpvc
