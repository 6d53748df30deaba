#include "app/python/worker.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "app/python/python.h"

namespace gpvc::python {
namespace {

constexpr auto kBetweenSignals = std::chrono::milliseconds(50);
constexpr auto kPatience = std::chrono::milliseconds(500);

// Of all workers, what runs. Never destroyed: threads may outlive main().
struct Running {
  std::mutex mutex;
  std::condition_variable ended;
  std::size_t count = 0;
  bool last = false;  // the interpreter ends
};
Running& running() {
  static auto* all = new Running;
  return *all;
}

}  // namespace

struct Worker::Job {
  std::function<void()> work;
  bool done = false;
  std::exception_ptr error{};
};

struct Worker::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::shared_ptr<Job>> jobs;  // the first one runs
  bool ends = false;

  void loop() {
    for (;;) {
      std::shared_ptr<Job> job;
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return ends || !jobs.empty(); });
        if (jobs.empty()) return;
        job = jobs.front();
        jobs.pop_front();
      }
      std::exception_ptr thrown;
      try {
        job->work();
      } catch (...) {
        thrown = std::current_exception();
      }
      job->work = nullptr;  // lets go of what it owned
      {
        const std::lock_guard lock(mutex);
        job->error = std::move(thrown);
        job->done = true;
      }
      changed.notify_all();
      job.reset();
      const std::lock_guard lock(running().mutex);
      --running().count;
      running().ended.notify_all();
    }
  }

  bool is_done(const Job& job, std::chrono::milliseconds time) {
    const py::gil_scoped_release unlocked;
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, time, [&] { return job.done; });
  }
};

Worker::Worker() : state_(std::make_shared<State>()) {
  std::thread([state = state_] { state->loop(); }).detach();
}

Worker::~Worker() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->ends = true;
  }
  state_->changed.notify_all();
}

std::shared_ptr<Worker::Job> Worker::begin(std::function<void()> work) {
  auto job = std::make_shared<Job>(Job{std::move(work)});
  {
    const std::lock_guard lock(running().mutex);
    ++running().count;
  }
  {
    const std::lock_guard lock(state_->mutex);
    state_->jobs.push_back(job);
  }
  state_->changed.notify_all();
  return job;
}

void Worker::post(std::function<void()> work) {
  {
    const std::lock_guard lock(running().mutex);
    if (running().last) {
      static_cast<void>(new std::function<void()>(std::move(work)));  // the process ends, and takes along what it owns
      return;
    }
  }
  begin(std::move(work));
}

void Worker::call(std::function<void()> work, const CancelFlag& cancelled) {
  const std::shared_ptr<State> state = state_;
  const std::shared_ptr<Job> job = begin(std::move(work));
  while (!state->is_done(*job, kBetweenSignals)) {
    if (PyErr_CheckSignals() == 0) continue;
    const py::error_already_set raised;
    *cancelled = true;
    state->is_done(*job, kPatience);
    throw raised;
  }
  if (job->error) std::rethrow_exception(job->error);
}

void Worker::wait_for_all() {
  const py::gil_scoped_release unlocked;
  std::unique_lock lock(running().mutex);
  running().last = true;
  running().ended.wait(lock, [] { return running().count == 0; });
}

}  // namespace gpvc::python
