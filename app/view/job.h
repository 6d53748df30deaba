// A run in the background of the page: one at a time, with progress, and cancelled when the page says so.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "app/results/observer.h"

namespace gpvc::view {

/// How a run reports, as one line of JSON: {"stage": "view selection", "done": 3, "total": 12, "unit": "views"}; with "ended" "done",
/// "cancelled" or "failed" and "why" at the end.
using Tell = std::function<void(const std::string& json)>;

class Job {
 public:
  explicit Job(Tell tell) : tell_(std::move(tell)) {}
  ~Job();
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  /// False where another one runs. `work` is called on a thread of its own; the run ends by itself or by results::Cancelled.
  bool start(std::function<void(results::Observer&)> work);
  void cancel() { cancelled_ = true; }
  bool runs() const { return runs_; }

 private:
  Tell tell_;
  std::mutex mutex_;
  std::thread thread_;
  std::atomic<bool> runs_ = false, cancelled_ = false;
};

}  // namespace gpvc::view
