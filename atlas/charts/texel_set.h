// A set of texels, stored as intervals of rows.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>

namespace gpvc::atlas {

/// Touching intervals of a row are merged, so a set of large triangles costs a few entries per row.
class TexelSet {
 public:
  bool meets(int y, int first, int last) const {
    const auto row = rows_.find(y);
    if (row == rows_.end()) return false;
    const auto after = row->second.upper_bound(last);
    return after != row->second.begin() && std::prev(after)->second >= first;
  }
  bool meets(const TexelSet& other) const {
    const TexelSet &small = intervals_ < other.intervals_ ? *this : other, &large = &small == this ? other : *this;
    for (const auto& [y, row] : small.rows_)
      for (const auto& [first, last] : row)
        if (large.meets(y, first, last)) return true;
    return false;
  }
  void add(int y, int first, int last) {
    auto& row = rows_[y];
    auto at = row.upper_bound(first);
    if (at != row.begin() && std::prev(at)->second >= first - 1) --at;
    while (at != row.end() && at->first <= last + 1) {
      first = std::min(first, at->first);
      last = std::max(last, at->second);
      at = row.erase(at);
      --intervals_;
    }
    row.emplace(first, last);
    ++intervals_;
  }
  /// Leaves `other` empty.
  void take(TexelSet& other) {
    if (intervals_ < other.intervals_) std::swap(*this, other);
    for (const auto& [y, row] : other.rows_)
      for (const auto& [first, last] : row) add(y, first, last);
    other = {};
  }

 private:
  std::map<int, std::map<int, int>> rows_;  ///< per row, last texel by first
  std::size_t intervals_ = 0;
};

}  // namespace gpvc::atlas
