#include "app/results/file_hashes.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace gpvc::results {
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

bool HashedFile::tells_changes() const {
  return std::max(state.modified_ns, state.changed_ns) + 3 * kSecond < hashed_ns;
}

const HashedFile& FileHashes::of(const std::filesystem::path& file) {
  HashedFile& known = known_[file];
  if (known.tells_changes() && known.state == file_state(file)) return known;
  // The state before: a file that changes while it is read is in another one from then on.
  HashedFile now{file_state(file), now_ns(), {}};
  io::WorkHash hash;
  hash.add_file(file);
  now.hash = hash.key();
  return known = now;
}

}  // namespace gpvc::results
