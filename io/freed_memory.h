// Memory that is given back when it is needed no longer.
#pragma once

#include <vector>

namespace gpvc {

/// Empties a vector and frees its memory, which assigning {} or clear() would keep.
template <typename T>
void free_memory(std::vector<T>& vector) {
  std::vector<T>().swap(vector);
}

/// Gives memory that was freed back to the system, which allocators otherwise keep for later.
void release_freed_memory();

}  // namespace gpvc
