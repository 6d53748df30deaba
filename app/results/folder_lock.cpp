#include "app/results/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "io/error.h"

namespace gpvc::results {
namespace {

namespace fs = std::filesystem;

// "process 123 on HOST"
std::string this_process() {
  std::array<char, 256> host{};
  const bool known = gethostname(host.data(), host.size() - 1) == 0 && host[0] != '\0';
  return "process " + std::to_string(getpid()) + (known ? " on " + std::string(host.data()) : "");
}

// " (process 123 on HOST)", empty if the file does not say.
std::string holder_of(int descriptor) {
  std::array<char, 300> text{};
  const ssize_t size = pread(descriptor, text.data(), text.size() - 1, 0);
  return size > 0 ? " (" + std::string(text.data()) + ")" : "";
}

// A run that ends removes the file, so the one that was opened may no longer be the one of that name.
bool is_still_there(int descriptor, const fs::path& file) {
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && lstat(file.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : file_(folder / ".gpvc-lock") {
  for (;;) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw OutputError(folder, std::string("cannot be written: ") + std::strerror(errno));
    held_ = flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
    if (!held_ && errno == EWOULDBLOCK) {
      const std::string holder = holder_of(descriptor_);
      close(descriptor_);
      throw OutputError(
          folder, "is written to by another run of gpvc" + holder + "; wait for its end or choose another folder");
    }
    if (!held_ || is_still_there(descriptor_, file_)) break;
    close(descriptor_);
  }
  const std::string text = this_process();
  // What the file says helps in a message alone.
  static_cast<void>(ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) > 0);
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  unlink(file_.c_str());
  close(descriptor_);
}

}  // namespace gpvc::results
