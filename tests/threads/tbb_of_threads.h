// The part of oneTBB that this tree uses, made of std::thread, for builds under ThreadSanitizer (GPVC_TSAN). Debian's
// libtbb is not instrumented: the sanitizer does not see how it hands work to threads and waits for them, and would
// report every loop as a race. Here it sees everything, so nothing has to be suppressed. Loops within loops run on
// their thread; the others on kThreads, each time new ones.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace tbb {

inline constexpr std::size_t kThreads = 4;

class global_control {
 public:
  enum parameter { max_allowed_parallelism };
  global_control(parameter, std::size_t value) : before_(allowed().exchange(std::min(value, kThreads))) {}
  ~global_control() { allowed() = before_; }
  global_control(const global_control&) = delete;
  global_control& operator=(const global_control&) = delete;
  static std::size_t active_value(parameter) { return allowed(); }

 private:
  static std::atomic<std::size_t>& allowed() {
    static std::atomic<std::size_t> value{kThreads};
    return value;
  }
  std::size_t before_;
};

namespace this_task_arena {
inline int max_concurrency() {
  return static_cast<int>(global_control::active_value(global_control::max_allowed_parallelism));
}
}  // namespace this_task_arena
namespace info {
inline int default_concurrency() { return static_cast<int>(kThreads); }
}  // namespace info

inline thread_local bool inside_loop = false;

/// Calls work(i) for i < count, on several threads. Throws what one of the calls threw. Which thread makes which calls
/// is fixed, neighbours on different ones: the calls of a short loop would else all be over before a second thread has
/// started, and nothing orders the calls of different threads, which would hide their races.
template <class Work>
void run_numbered(std::size_t count, const Work& work) {
  const std::size_t allowed = global_control::active_value(global_control::max_allowed_parallelism);
  const std::size_t stride = inside_loop ? 1 : std::min(count, allowed);
  std::atomic<bool> failed = false;
  std::exception_ptr error;
  std::mutex guard;
  const auto take = [&](std::size_t first) {
    const bool before = std::exchange(inside_loop, true);
    try {
      for (std::size_t i = first; i < count && !failed.load(std::memory_order_relaxed); i += stride) work(i);
    } catch (...) {
      const std::lock_guard lock(guard);
      error = std::current_exception();
      failed.store(true, std::memory_order_relaxed);
    }
    inside_loop = before;
  };
  std::vector<std::thread> threads;
  for (std::size_t t = 1; t < stride; ++t) threads.emplace_back(take, t);
  take(0);
  for (std::thread& thread : threads) thread.join();
  if (error) std::rethrow_exception(error);
}

struct simple_partitioner {};

template <class Value>
class blocked_range {
 public:
  using const_iterator = Value;
  blocked_range(Value begin, Value end, std::size_t grain = 1) : begin_(begin), end_(end), grain_(grain) {}
  Value begin() const { return begin_; }
  Value end() const { return end_; }
  std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }
  std::size_t grainsize() const { return grain_; }
  bool empty() const { return !(begin_ < end_); }
  /// At most 64 of at least a grain.
  std::vector<blocked_range> parts() const {
    std::vector<blocked_range> all;
    const std::size_t step = std::max(grain_, (size() + 63) / 64);
    for (std::size_t at = 0; at < size(); at += step)
      all.emplace_back(static_cast<Value>(begin_ + static_cast<Value>(at)),
                       static_cast<Value>(begin_ + static_cast<Value>(std::min(at + step, size()))), grain_);
    return all;
  }

 private:
  Value begin_, end_;
  std::size_t grain_;
};

template <class Value>
class blocked_range2d {
 public:
  blocked_range2d(Value row0, Value row1, std::size_t rows, Value column0, Value column1, std::size_t columns)
      : rows_(row0, row1, rows), columns_(column0, column1, columns) {}
  blocked_range2d(const blocked_range<Value>& rows, const blocked_range<Value>& columns)
      : rows_(rows), columns_(columns) {}
  const blocked_range<Value>& rows() const { return rows_; }
  const blocked_range<Value>& cols() const { return columns_; }
  std::vector<blocked_range2d> parts() const {
    std::vector<blocked_range2d> all;
    for (const auto& rows : rows_.parts())
      for (const auto& columns : columns_.parts()) all.emplace_back(rows, columns);
    return all;
  }

 private:
  blocked_range<Value> rows_, columns_;
};

template <class Range, class Body>
requires requires(const Range& range) { range.parts(); }
void parallel_for(const Range& range, const Body& body) {
  const auto parts = range.parts();
  run_numbered(parts.size(), [&](std::size_t i) { body(parts[i]); });
}

template <class Index, class Body>
requires std::is_integral_v<Index>
void parallel_for(Index first, std::type_identity_t<Index> end, std::type_identity_t<Index> step, const Body& body) {
  if (!(first < end)) return;
  run_numbered((static_cast<std::size_t>(end - first) - 1) / static_cast<std::size_t>(step) + 1,
               [&](std::size_t i) { body(static_cast<Index>(first + static_cast<Index>(i) * step)); });
}

template <class Index, class Body>
requires std::is_integral_v<Index>
void parallel_for(Index first, std::type_identity_t<Index> end, const Body& body) {
  parallel_for(first, end, Index{1}, body);
}

template <class Index, class Body>
requires std::is_integral_v<Index>
void parallel_for(Index first, std::type_identity_t<Index> end, const Body& body, simple_partitioner) {
  parallel_for(first, end, Index{1}, body);
}

template <class Range, class Body>
requires requires(const Range& range) { range.parts(); }
void parallel_for(const Range& range, const Body& body, simple_partitioner) { parallel_for(range, body); }

template <class Range, class Value, class Body, class Join>
Value parallel_reduce(const Range& range, const Value& identity, const Body& body, const Join& join) {
  const auto parts = range.parts();
  std::vector<Value> values(parts.size(), identity);
  run_numbered(parts.size(), [&](std::size_t i) { values[i] = body(parts[i], identity); });
  Value sum = identity;
  for (const Value& value : values) sum = join(sum, value);
  return sum;
}

template <class Range, class Value, class Body, class Join>
Value parallel_deterministic_reduce(const Range& range, const Value& identity, const Body& body, const Join& join) {
  return parallel_reduce(range, identity, body, join);
}

template <class... Work>
void parallel_invoke(const Work&... work) {
  const std::vector<std::function<void()>> all{std::cref(work)...};
  run_numbered(all.size(), [&](std::size_t i) { all[i](); });
}

template <class Iterator, class Less>
void parallel_sort(Iterator begin, Iterator end, const Less& less) {
  std::sort(begin, end, less);
}

template <class List>
void parallel_sort(List& list) {
  std::sort(list.begin(), list.end());
}

class task_arena {
 public:
  explicit task_arena(int threads) : threads_(static_cast<std::size_t>(threads)) {}
  template <class Work>
  auto execute(const Work& work) {
    const global_control limit(global_control::max_allowed_parallelism, threads_);
    return work();
  }

 private:
  std::size_t threads_;
};

class task_group {
 public:
  task_group() = default;
  ~task_group() { join(); }
  task_group(const task_group&) = delete;
  task_group& operator=(const task_group&) = delete;
  template <class Work>
  void run(Work work) {
    threads_.emplace_back([this, work = std::move(work)] {
      try {
        work();
      } catch (...) {
        const std::lock_guard lock(guard_);
        error_ = std::current_exception();
      }
    });
  }
  void wait() {
    join();
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

 private:
  void join() {
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }
  std::vector<std::thread> threads_;
  std::mutex guard_;
  std::exception_ptr error_;
};

/// A deque whose elements stay where they are.
template <class Value>
class concurrent_vector {
 public:
  void push_back(const Value& value) {
    const std::lock_guard lock(guard_);
    values_.push_back(value);
  }
  void clear() { values_.clear(); }
  std::size_t size() const { return values_.size(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

 private:
  std::mutex guard_;
  std::deque<Value> values_;
};

template <class Value>
class enumerable_thread_specific {
  using Slots = std::vector<std::unique_ptr<Value>>;
  template <class Inner>
  struct Iterator {
    using difference_type = std::ptrdiff_t;
    using value_type = Value;
    Inner at{};
    decltype(auto) operator*() const { return **at; }
    auto* operator->() const { return at->get(); }
    Iterator& operator++() {
      ++at;
      return *this;
    }
    Iterator operator++(int) { return {at++}; }
    bool operator==(const Iterator&) const = default;
  };

 public:
  enumerable_thread_specific() : make_([] { return Value(); }) {}
  explicit enumerable_thread_specific(const Value& exemplar) : make_([exemplar] { return exemplar; }) {}
  /// Locks only when a thread asks for the first time: a lock at every call would order what the threads do between
  /// them.
  Value& local() {
    static thread_local std::map<std::size_t, Value*> mine;
    Value*& value = mine[serial_];
    if (value == nullptr) {
      const std::lock_guard lock(*guard_);
      slots_.push_back(std::unique_ptr<Value>(new Value(make_())));
      value = slots_.back().get();
    }
    return *value;
  }
  void clear() {
    slots_.clear();
    serial_ = next_serial();
  }
  std::size_t size() const { return slots_.size(); }
  bool empty() const { return slots_.empty(); }
  auto begin() { return Iterator<typename Slots::iterator>{slots_.begin()}; }
  auto end() { return Iterator<typename Slots::iterator>{slots_.end()}; }
  auto begin() const { return Iterator<typename Slots::const_iterator>{slots_.begin()}; }
  auto end() const { return Iterator<typename Slots::const_iterator>{slots_.end()}; }

 private:
  static std::size_t next_serial() {
    static std::atomic<std::size_t> next{0};
    return next.fetch_add(1, std::memory_order_relaxed);
  }
  std::size_t serial_ = next_serial();  ///< Tells this object from an earlier one at its address
  std::unique_ptr<std::mutex> guard_ = std::make_unique<std::mutex>();
  Slots slots_;
  std::function<Value()> make_;
};

}  // namespace tbb
