// Large blocks of memory whose pages all threads take from the system.
#pragma once

#include <cstddef>
#include <vector>

namespace gpvc {

/// Has the system provide the pages of a block, which it clears, by all threads and not by the one that first writes to
/// them: a gigabyte takes up to two seconds where it comes from a virtual machine's host. Contents stay. Does nothing for
/// small blocks, and where the system cannot (Linux before 5.14).
void provide_pages(void* block, std::size_t bytes);

/// A vector of so many copies of a value, whose memory is provided as above.
template <typename T>
std::vector<T> filled(std::size_t size, const T& value) {
  std::vector<T> vector;
  vector.reserve(size);
  provide_pages(vector.data(), size * sizeof(T));
  vector.assign(size, value);
  return vector;
}

}  // namespace gpvc
