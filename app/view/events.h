// What the server tells the pages that listen.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <string>

namespace gpvc::view {

/// Server-sent events, which each listening page takes at its own pace. Thread-safe.
class Events {
 public:
  void tell(const std::string& event, const std::string& data) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(fmt::format("event: {}\ndata: {}\n\n", event, data));
    if (messages_.size() > kKept) {
      messages_.pop_front();
      ++first_;
    }
    changed_.notify_all();
  }
  std::size_t end() const {
    const std::lock_guard lock(mutex_);
    return first_ + messages_.size();
  }
  /// What came since `next`, which moves on; a line that means nothing after a second without any.
  std::string since(std::size_t& next) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(1), [&] { return closed || first_ + messages_.size() > next; });
    std::string text;
    for (next = std::max(next, first_); next < first_ + messages_.size(); ++next) text += messages_[next - first_];
    return text.empty() ? ": still here\n\n" : text;
  }
  void close() {
    closed = true;
    changed_.notify_all();
  }
  std::atomic<bool> closed = false;
  std::atomic<std::size_t> listeners = 0, ever = 0;

 private:
  static constexpr std::size_t kKept = 256;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> messages_;
  std::size_t first_ = 0;  // number of messages_.front()
};

}  // namespace gpvc::view
