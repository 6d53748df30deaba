// Finding a face's coverage in a view.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "visibility/result.h"

namespace gpvc::atlas {

/// Borrows the table, whose entries come view after view in any order.
class CoverageIndex {
 public:
  /// O(n log n).
  explicit CoverageIndex(const visibility::CoverageTable& table) : table_(&table), order_(table.entries.size()) {
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::uint32_t>(i);
    const auto key = [&](std::uint32_t i) { return std::tuple(table.entries[i].face, table.entries[i].view, i); };
    std::ranges::sort(order_, {}, key);
  }

  /// nullptr if the table has no entry for the face in the view. O(log n).
  const visibility::FaceCoverage* find(FaceId face, ViewId view) const {
    const auto key = [&](std::uint32_t i) { return std::pair(table_->entries[i].face, table_->entries[i].view); };
    const auto found = std::ranges::lower_bound(order_, std::pair(face, view), {}, key);
    return found != order_.end() && key(*found) == std::pair(face, view) ? &table_->entries[*found] : nullptr;
  }

  /// Calls visit(entry) for the views that see the face in part. O(log n + entries).
  template <typename Visit>
  void for_views(FaceId face, const Visit& visit) const {
    const auto face_of = [&](std::uint32_t i) { return table_->entries[i].face; };
    for (auto i = std::ranges::lower_bound(order_, face, {}, face_of); i != order_.end() && face_of(*i) == face; ++i)
      visit(table_->entries[*i]);
  }

  const visibility::CoverageTable& table() const { return *table_; }

 private:
  const visibility::CoverageTable* table_;
  std::vector<std::uint32_t> order_;
};

}  // namespace gpvc::atlas
