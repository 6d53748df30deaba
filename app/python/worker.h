// Library work on threads of its own, while the Python thread that asked for it listens for Ctrl-C.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

namespace gpvc::python {

/// Set by the thread that waits; what works looks at it and throws Cancelled.
using CancelFlag = std::shared_ptr<std::atomic<bool>>;
inline CancelFlag cancel_flag() { return std::make_shared<std::atomic<bool>>(false); }

/// One thread, on which all of its calls run: what belongs to a thread, as an OpenGL context does, may live from call to call.
class Worker {
 public:
  Worker();
  /// Calls that run are not waited for.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Runs `work` and returns when it has ended; throws what it throws. The interpreter's lock is released meanwhile. Where a
  /// Python signal handler raises (Ctrl-C), sets `cancelled` and throws that within a second: work that has not ended by then
  /// ends at its next look at the flag. So `work` must own what it uses. \pre the lock is held
  void call(std::function<void()> work, const CancelFlag& cancelled);

  /// Runs `work`, which throws nothing, after all calls, and does not wait for it; not at all once wait_for_all() was called.
  void post(std::function<void()> work);

  /// Waits for work that calls have left behind, before the interpreter ends. \pre the interpreter's lock is held
  static void wait_for_all();

 private:
  struct State;
  struct Job;
  std::shared_ptr<Job> begin(std::function<void()> work);

  std::shared_ptr<State> state_;
};

}  // namespace gpvc::python
