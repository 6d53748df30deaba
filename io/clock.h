// Wall time, and what the process has taken of the machine, for statistics.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <cstddef>

namespace gpvc {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

inline rusage process_usage() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

/// Processor time of the whole process, user and system.
inline double cpu_seconds() {
  const rusage usage = process_usage();
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// The most memory that this process has had so far.
inline std::size_t peak_resident_bytes() {
  return static_cast<std::size_t>(process_usage().ru_maxrss) * 1024;  // Linux counts in KiB
}

}  // namespace gpvc
