// How the C library keeps freed memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace gpvc::cli {

/// Blocks from this size on are mapped, and unmapped when they are freed.
inline constexpr std::size_t kUnmappedBytes = std::size_t{1} << 20;

/// Of smaller blocks, what an arena keeps at its end when they are freed, and takes from the system at a time.
inline constexpr std::size_t kKeptBytes = std::size_t{64} << 20, kTakenBytes = std::size_t{4} << 20;

/// From now on blocks of a megabyte and more go back to the system when they are freed, and there is an arena a core for smaller
/// ones. By default glibc keeps freed blocks of up to 32 MB, in eight arenas a core, for hundreds of megabytes that
/// nothing uses. With a threshold set, it would give back and take again 128 KB at a time, and the kernel clears what it gives: a third
/// of a run's page faults.
inline void set_memory_arenas() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(kUnmappedBytes));
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(kKeptBytes));
  mallopt(M_TOP_PAD, static_cast<int>(kTakenBytes));
  mallopt(M_ARENA_MAX, static_cast<int>(std::max(2u, std::thread::hardware_concurrency())));
#endif
}

}  // namespace gpvc::cli
