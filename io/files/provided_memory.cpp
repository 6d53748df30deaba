#include "io/provided_memory.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace gpvc {

void provide_pages([[maybe_unused]] void* block, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_POPULATE_WRITE
  // The edge of a part is one of a large page (2 MB), so that no two threads ask for the same.
  constexpr std::uintptr_t kPart = std::uintptr_t{16} << 20, kPage = 4096;
  if (bytes < 2 * kPart) return;
  const auto begin = reinterpret_cast<std::uintptr_t>(block), end = begin + bytes;
  tbb::parallel_for(begin / kPart, (end + kPart - 1) / kPart, [&](std::uintptr_t part) {
    const std::uintptr_t from = std::max(part * kPart, begin / kPage * kPage), to = std::min((part + 1) * kPart, end);
    static_cast<void>(madvise(reinterpret_cast<void*>(from), to - from, MADV_POPULATE_WRITE));  // a wish
  });
#endif
}

}  // namespace gpvc
