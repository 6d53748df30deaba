#include "io/file_hashes.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>

#include "io/error.h"

namespace gpvc::io {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::int64_t nanoseconds(const timespec& time) { return std::int64_t{time.tv_sec} * kSecond + time.tv_nsec; }

std::int64_t now_ns() {
  using namespace std::chrono;
  return duration_cast<std::chrono::nanoseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace

FileState file_state(const std::filesystem::path& file) {
  struct stat found {};
  if (stat(file.c_str(), &found) != 0)
    throw InputError(file, "", std::string("cannot be read: ") + std::strerror(errno));
  return {found.st_ino, static_cast<std::uint64_t>(found.st_size), nanoseconds(found.st_mtim),
          nanoseconds(found.st_ctim)};
}

bool HashedFile::proves_unchanged() const {
  return std::max(state.modified_ns, state.changed_ns) + 3 * kSecond < hashed_ns;
}

HashedFile FileHashes::look_at(const std::filesystem::path& file) const {
  HashedFile known;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = known_.find(file); found != known_.end()) known = found->second;
  }
  if (known.proves_unchanged() && known.state == file_state(file)) return known;
  // The state before: a file that changes while it is read is in another one from then on.
  HashedFile now{file_state(file), now_ns(), {}};
  WorkHash hash;
  hash.add_file(file);
  now.hash = hash.key();
  return now;
}

HashedFile FileHashes::of(const std::filesystem::path& file) {
  const HashedFile now = look_at(file);
  const std::lock_guard lock(mutex_);
  return known_[file] = now;
}

HashedFile FileHashes::unchanged(const std::filesystem::path& file) {
  const HashedFile now = look_at(file);
  const std::lock_guard lock(mutex_);
  const auto [place, first] = known_.try_emplace(file, now);
  if (!first && place->second.hash != now.hash)
    throw InputError(file, "", "has changed since it was first read: it must stay the same while it is used");
  return place->second = now;
}

void FileHashes::learn(const std::filesystem::path& file, const HashedFile& known) {
  const std::lock_guard lock(mutex_);
  known_.emplace(file, known);
}

}  // namespace gpvc::io
