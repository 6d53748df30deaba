// Progress reports from within a step.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>

#include "io/clock.h"
#include "io/progress.h"

namespace gpvc::atlas {

/// Calls progress, which may throw to stop the work, while a photo is in use.
class Poll {
 public:
  Poll(const Progress& progress, std::size_t done, std::size_t total)
      : progress_(progress), done_(done), total_(total) {}

  /// From any thread.
  void operator()() {
    if (!progress_) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || Clock::now() < next_) return;
    next_ = Clock::now() + kInterval;
    progress_(done_, total_);
  }

 private:
  static constexpr std::chrono::milliseconds kInterval{100};
  const Progress& progress_;
  std::size_t done_, total_;
  std::mutex mutex_;
  Clock::time_point next_{};  ///< not before
};

}  // namespace gpvc::atlas
