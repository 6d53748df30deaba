// Counting sort: from how many items each one has to where they lie.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace gpvc::labeling {

/// Counts become where each one's items begin when all lie one behind the other; returns how many there are.
inline std::size_t offsets_from_counts(std::vector<std::size_t>& counts) {
  std::size_t sum = 0;
  for (std::size_t& count : counts) sum += std::exchange(count, sum);
  return sum;
}

}  // namespace gpvc::labeling
