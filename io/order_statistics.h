// Values by rank, for many short lists.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace gpvc {

/// Lists up to this length are sorted by comparing all pairs, whose results need no branches: those of a faster sort
/// cannot be predicted and cost more than the comparisons.
inline constexpr std::size_t kShortList = 16;

/// \pre values.size() <= kShortList, none is NaN
template <class Value>
void sort_short(std::span<Value> values) {
  std::array<Value, kShortList> sorted;
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::size_t rank = 0;
    for (std::size_t j = 0; j < i; ++j) rank += values[j] <= values[i] ? 1 : 0;
    for (std::size_t j = i + 1; j < values.size(); ++j) rank += values[j] < values[i] ? 1 : 0;
    sorted[rank] = values[i];
  }
  std::copy_n(sorted.begin(), values.size(), values.begin());
}

/// The value that as many values are below as above; of an even number of values, the higher one of the two. Reorders
/// the values: the lower half comes first. \pre not empty, none is NaN
template <class Value>
Value upper_median(std::span<Value> values) {
  const std::size_t middle = values.size() / 2;
  if (values.size() <= kShortList) {
    sort_short(values);
  } else {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(middle), values.end());
  }
  return values[middle];
}

}  // namespace gpvc
