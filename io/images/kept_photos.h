// Decoded photos under a byte limit: what sources of photos share that keep some for later.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <functional>
#include <future>
#include <iterator>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "io/photos.h"

namespace gpvc::io {

/// Photos by number, least recently used out first. Thread-safe; one that two threads ask for is decoded once, on one of them.
/// Photos handed out live on outside the limit until released, and are handed out again until then. `Decoded` has a function
/// bytes().
template <typename Decoded>
class KeptPhotos {
 public:
  using Photo = std::shared_ptr<const Decoded>;

  KeptPhotos(std::size_t photos, std::size_t limit_bytes) : limit_bytes_(limit_bytes), held_(photos) {}

  /// The photo, by decode() unless it is there and enough() of it is. What decode() throws reaches all who wait for the photo; the
  /// next request tries again.
  Photo fetch(
      std::size_t number, const std::function<Photo()>& decode,
      const std::function<bool(const Decoded&)>& enough = [](const Decoded&) { return true; }) {
    std::promise<Photo> promise;
    while (true) {
      std::unique_lock lock(mutex_);
      if (const auto found = entries_.find(number); found != entries_.end()) {
        by_age_.splice(by_age_.end(), by_age_, found->second.age);
        const std::shared_future<Photo> waited = found->second.photo;
        lock.unlock();
        Photo photo = waited.get();
        if (enough(*photo)) return photo;
        lock.lock();
        // By now there may be none, or another one.
        if (const auto poor = entries_.find(number); poor != entries_.end() && poor->second.bytes > 0) drop(poor);
        continue;
      }
      if (Photo photo = held_.at(number).lock(); photo && enough(*photo)) return photo;
      entries_[number] = {promise.get_future().share(), 0, by_age_.insert(by_age_.end(), number)};
      break;
    }
    try {
      Photo photo = decode();
      promise.set_value(photo);
      const std::lock_guard lock(mutex_);
      ++decodes_;
      decoded_.insert(number);
      held_[number] = photo;
      Entry& entry = entries_.at(number);
      entry.bytes = std::max<std::size_t>(1, photo->bytes());
      bytes_ += entry.bytes;
      drop_oldest_beyond_limit();
      return photo;
    } catch (...) {
      {
        const std::lock_guard lock(mutex_);
        drop(entries_.find(number));
      }
      promise.set_exception(std::current_exception());
      throw;
    }
  }

  void keep_at_most(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    limit_bytes_ = bytes;
    drop_oldest_beyond_limit();
  }

  PhotoDecodes decodes() const {
    const std::lock_guard lock(mutex_);
    return {decoded_.size(), decodes_};
  }

 private:
  struct Entry {
    std::shared_future<Photo> photo;
    std::size_t bytes = 0;  ///< 0 while it is decoded; such entries are never dropped
    std::list<std::size_t>::iterator age;
  };

  using Entries = std::unordered_map<std::size_t, Entry>;

  /// Returns the next one by age.
  std::list<std::size_t>::iterator drop(typename Entries::iterator entry) {
    bytes_ -= entry->second.bytes;
    const auto next = by_age_.erase(entry->second.age);
    entries_.erase(entry);
    return next;
  }
  void drop_oldest_beyond_limit() {
    for (auto age = by_age_.begin(); bytes_ > limit_bytes_ && age != by_age_.end();) {
      const auto entry = entries_.find(*age);
      age = entry->second.bytes == 0 ? std::next(age) : drop(entry);
    }
  }

  mutable std::mutex mutex_;
  std::size_t limit_bytes_;
  std::vector<std::weak_ptr<const Decoded>> held_;  ///< by number, what somebody may still hold of it
  std::unordered_set<std::size_t> decoded_;
  std::size_t decodes_ = 0;
  Entries entries_;
  std::list<std::size_t> by_age_;  ///< least recently used first
  std::size_t bytes_ = 0;
};

}  // namespace gpvc::io
