// Large blocks of memory in large pages.
//
// Photos, maps and pages are blocks of tens of megabytes, and the kernel clears each of their 4 KB pages in an interrupt of its
// own when it is first written: a tenth of a run's time. Where the system leaves it to programs to ask for pages of 2 MB
// (Linux: transparent_hugepage = madvise, as in Debian), this asks for them. Replaces the program's operator new, which
// all vectors use; see madvise(2), MADV_HUGEPAGE.
#include <cstdint>
#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace {

constexpr std::uintptr_t kLargePage = std::uintptr_t{2} << 20;

void ask_for_large_pages([[maybe_unused]] void* block, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  if (bytes < 2 * kLargePage) return;  // smaller blocks may hold no whole page
  const auto begin = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t end = (begin + bytes) / kLargePage * kLargePage;
  // A wish: where it is not met, the block is as good.
  if (first < end) static_cast<void>(madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE));
#endif
}

}  // namespace

void* operator new(std::size_t bytes) {
  for (;;) {
    if (void* block = std::malloc(bytes > 0 ? bytes : 1)) {
      ask_for_large_pages(block, bytes);
      return block;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
