// Large blocks of memory in large pages.
//
// Photos, maps and pages are blocks of tens of megabytes, and the kernel clears each of their 4 KB pages in an interrupt of its
// own when it is first written: a tenth of a run's time. Where the system leaves it to programs to ask for pages of 2 MB
// (Linux: transparent_hugepage = madvise, as in Debian), this asks for them. Replaces the program's operator new, which
// all vectors use; see madvise(2), MADV_HUGEPAGE. glibc's tunable glibc.malloc.hugetlb=1 serves as well, but is read before
// main(): the program would have to start itself again, and loading its libraries takes longer than this saves.
//
// And some are kept for the next of their size: each photo needs the same few blocks (its file's bytes, its coarse colours, maps of its
// pixels), which the system would unmap, map and clear again.
//
// Or in files: a mesh that is larger than the memory is cut into tiles by algorithms that go over its arrays in order, which a
// mapped file serves as well, as the system reads and writes ahead.
#include "app/cli/large_blocks.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <string>

#ifdef __linux__
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "app/cli/memory_arenas.h"

namespace {

constexpr std::uintptr_t kPage = 4096;
constexpr std::size_t kLeastMapped = std::size_t{16} << 20;

// Blocks that are mapped files. malloc()'s own blocks have a header in front, so none of theirs begins at a page.
class MappedBlocks {
 public:
  void use(const std::string& folder) {
    const std::lock_guard lock(mutex_);
    folder_ = folder;
    in_use_ = true;
  }
  bool in_use() const { return in_use_; }

  void* make([[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
    const std::lock_guard lock(mutex_);
    const int file = open(folder_.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (file < 0) return nullptr;
    void* block = MAP_FAILED;
    // Room on the disk is taken now: without it, writing to the block would end the program.
    if (posix_fallocate(file, 0, static_cast<off_t>(bytes)) == 0)
      block = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (block == MAP_FAILED) return nullptr;
    try {
      sizes_.emplace(block, bytes);
    } catch (...) {
      munmap(block, bytes);
      return nullptr;
    }
    return block;
#else
    return nullptr;
#endif
  }

  /// False for a block that is none of these.
  bool free([[maybe_unused]] void* block) {
#ifdef __linux__
    if (!in_use_ || reinterpret_cast<std::uintptr_t>(block) % kPage != 0) return false;
    const std::lock_guard lock(mutex_);
    const auto found = sizes_.find(block);
    if (found == sizes_.end()) return false;
    munmap(block, found->second);
    sizes_.erase(found);
    return true;
#else
    return false;
#endif
  }

 private:
  std::mutex mutex_;
  std::atomic<bool> in_use_ = false;
  std::string folder_;
  std::map<void*, std::size_t> sizes_;
};

// Never destroyed: blocks outlive everything else.
MappedBlocks& mapped_blocks() {
  alignas(MappedBlocks) static unsigned char room[sizeof(MappedBlocks)];
  static MappedBlocks* blocks = new (room) MappedBlocks;
  return *blocks;
}

// Blocks that were freed and may be had again.
class SpareBlocks {
 public:
  // A block of at least so many bytes, an eighth more at most; null if there is none.
  void* take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = count_; i-- > 0;)  // the one that was used last may still be in the cache
      if (blocks_[i].bytes >= bytes && blocks_[i].bytes <= bytes + bytes / 8) return remove(i);
    return nullptr;
  }

  // Takes over a block that malloc() made.
  void give(void* block, std::size_t bytes) {
    std::array<void*, kMost> old{};
    std::size_t removed = 0;
    {
      const std::lock_guard lock(mutex_);
      while (count_ > 0 && (count_ == kMost || bytes_ + bytes > kMostBytes)) old[removed++] = remove(0);
      blocks_[count_++] = {block, bytes};
      bytes_ += bytes;
    }
    for (std::size_t i = 0; i < removed; ++i) std::free(old[i]);
  }

  // Larger ones come seldom, and photos are kept by who decodes them.
  static bool keeps(std::size_t bytes) { return bytes >= gpvc::cli::kUnmappedBytes && bytes <= kMostBytes / 2; }

 private:
  struct Block {
    void* place = nullptr;
    std::size_t bytes = 0;
  };
  static constexpr std::size_t kMost = 32;
  // What is kept counts as the program's memory: a tenth of what the smallest runs take.
  static constexpr std::size_t kMostBytes = std::size_t{32} << 20;

  void* remove(std::size_t i) {
    void* block = blocks_[i].place;
    bytes_ -= blocks_[i].bytes;
    std::copy(blocks_.begin() + i + 1, blocks_.begin() + count_, blocks_.begin() + i);
    --count_;
    return block;
  }

  std::mutex mutex_;
  std::array<Block, kMost> blocks_{};  // oldest first
  std::size_t count_ = 0, bytes_ = 0;
};

// Never destroyed either.
SpareBlocks& spare_blocks() {
  alignas(SpareBlocks) static unsigned char room[sizeof(SpareBlocks)];
  static SpareBlocks* blocks = new (room) SpareBlocks;
  return *blocks;
}

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

// What malloc() made. Not inlined: compilers take free() in a delete for a mistake.
[[gnu::noinline]] void release(void* block) {
#ifdef __GLIBC__
  const std::size_t bytes = malloc_usable_size(block);
  if (SpareBlocks::keeps(bytes)) return spare_blocks().give(block, bytes);
#endif
  std::free(block);
}

}  // namespace

namespace gpvc::cli {

void keep_large_blocks_in(const std::filesystem::path& folder) { mapped_blocks().use(folder.string()); }

}  // namespace gpvc::cli

void* operator new(std::size_t bytes) {
  if (bytes >= kLeastMapped && mapped_blocks().in_use())
    if (void* block = mapped_blocks().make(bytes)) return block;
  if (SpareBlocks::keeps(bytes))
    if (void* block = spare_blocks().take(bytes)) return block;
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

void operator delete(void* block) noexcept {
  if (!mapped_blocks().free(block)) release(block);
}
void operator delete(void* block, std::size_t) noexcept { operator delete(block); }
