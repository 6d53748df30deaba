#include "app/results/folder_files.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace gpvc::results {
namespace {

namespace fs = std::filesystem;

constexpr int kFolderFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;

[[noreturn]] void fail(const fs::path& path) {
  throw fs::filesystem_error("", path, std::error_code(errno, std::generic_category()));
}

// The folder of a file.
class Parent {
 public:
  // A descriptor of -1 and errno tell that it cannot be opened.
  Parent(int root, const fs::path& name, bool create) : descriptor_(fcntl(root, F_DUPFD_CLOEXEC, 0)) {
    for (const fs::path& part : name.parent_path()) {
      if (descriptor_ < 0) return;
      const bool there = !create || mkdirat(descriptor_, part.c_str(), 0777) == 0 || errno == EEXIST;
      const int inner = there ? openat(descriptor_, part.c_str(), kFolderFlags) : -1;
      shut();
      descriptor_ = inner;
    }
  }
  ~Parent() { shut(); }
  Parent(const Parent&) = delete;
  Parent& operator=(const Parent&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  void shut() {
    const int error = errno;
    if (descriptor_ >= 0) close(descriptor_);
    descriptor_ = -1;
    errno = error;
  }
  int descriptor_;
};

// File systems that cannot refuse to replace get the test before.
int rename_without_replacing(int from, const fs::path& name, int to, const fs::path& new_name) {
  const int result = renameat2(from, name.c_str(), to, new_name.c_str(), RENAME_NOREPLACE);
  if (result == 0 || (errno != EINVAL && errno != ENOSYS)) return result;
  struct stat there {};
  if (fstatat(to, new_name.c_str(), &there, AT_SYMLINK_NOFOLLOW) == 0) {
    errno = EEXIST;
    return -1;
  }
  return renameat(from, name.c_str(), to, new_name.c_str());
}

}  // namespace

FolderFiles::FolderFiles(fs::path folder)
    : path_(std::move(folder)), descriptor_(open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) fail(path_);
}

FolderFiles::~FolderFiles() { close(descriptor_); }

bool FolderFiles::has(const fs::path& name) const {
  const Parent parent(descriptor_, name, false);
  struct stat there {};
  return parent.descriptor() >= 0 &&
         fstatat(parent.descriptor(), name.filename().c_str(), &there, AT_SYMLINK_NOFOLLOW) == 0 &&
         !S_ISDIR(there.st_mode);
}

std::optional<fs::path> FolderFiles::link_on_the_way(const fs::path& name) const {
  fs::path way;
  for (const fs::path& part : name.parent_path()) {
    way /= part;
    struct stat there {};
    if (fstatat(descriptor_, way.c_str(), &there, AT_SYMLINK_NOFOLLOW) != 0) return std::nullopt;
    if (S_ISLNK(there.st_mode)) return way;
  }
  return std::nullopt;
}

void FolderFiles::move(const fs::path& from, const fs::path& to) const {
  const Parent old_parent(descriptor_, from, false);
  if (old_parent.descriptor() < 0) fail(path_ / from);
  const Parent new_parent(descriptor_, to, true);
  if (new_parent.descriptor() < 0 ||
      rename_without_replacing(old_parent.descriptor(), from.filename(), new_parent.descriptor(), to.filename()) != 0)
    fail(path_ / to);
}

void FolderFiles::remove_empty_parents(const fs::path& name) const noexcept {
  for (fs::path folder = name.parent_path(); !folder.empty(); folder = folder.parent_path()) {
    const Parent parent(descriptor_, folder, false);
    if (parent.descriptor() < 0 || unlinkat(parent.descriptor(), folder.filename().c_str(), AT_REMOVEDIR) != 0) return;
  }
}

void FolderFiles::flush() const noexcept { static_cast<void>(fsync(descriptor_)); }

}  // namespace gpvc::results
