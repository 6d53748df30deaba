#include "io/file_bytes.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "io/files/paths.h"

namespace gpvc::io {

namespace {

struct Descriptor {
  int number = -1;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

/// A file that is cut while it is mapped ends the process with SIGBUS. Larger ones, which are few, are mapped all the same.
constexpr std::size_t kRead = 64 << 20;

/// Reads the file, of which `expected` bytes are known to be there.
std::vector<char> read_all(const std::filesystem::path& file, int descriptor, std::size_t expected) {
  std::vector<char> bytes(expected + 1);  // one more tells that this was all
  std::size_t size = 0;
  for (;;) {
    if (size == bytes.size()) bytes.resize(std::max<std::size_t>(2 * bytes.size(), 1u << 17));
    const ssize_t got = ::read(descriptor, bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(file, "", std::string("cannot be read: ") + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  bytes.resize(size);
  return bytes;
}

/// Returns the size that the system tells. Throws InputError for what is no regular file.
std::size_t open_regular(const std::filesystem::path& file, Descriptor& descriptor) {
  // A pipe without a writer would wait for one.
  descriptor.number = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor.number < 0) throw InputError(file, "", std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  if (::fstat(descriptor.number, &status) != 0)
    throw InputError(file, "", std::string("cannot be read: ") + std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw InputError(file, "", "is a folder, expected a file");
  if (!S_ISREG(status.st_mode)) throw InputError(file, "", kNotRegular);
  return static_cast<std::size_t>(status.st_size);
}

}  // namespace

FileBytes::FileBytes(const std::filesystem::path& file, Use use) {
  Descriptor descriptor;
  const std::size_t size = open_regular(file, descriptor);
  if (size > (use == Use::whole ? kRead : 0)) {
    const int ahead = use == Use::whole ? MAP_POPULATE : 0;
    void* mapping = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | ahead, descriptor.number, 0);
    if (mapping != MAP_FAILED) {
      if (use == Use::in_places) ::madvise(mapping, size, MADV_RANDOM);  // or neighbours are read, too
      mapping_ = mapping;
      bytes_ = {static_cast<const char*>(mapping), size};
    }
  }
  if (mapping_ == nullptr) {
    buffer_ = read_all(file, descriptor.number, std::min(size, kRead));  // what is told may be no size, as in /proc
    bytes_ = {buffer_.data(), buffer_.size()};
  }
  try {
    refuse_lfs_pointer(file, bytes_);
  } catch (const InputError&) {
    unmap();
    throw;
  }
}

void refuse_lfs_pointer(const std::filesystem::path& file, std::string_view bytes) {
  if (bytes.starts_with("version https://git-lfs.github.com/"))
    throw InputError(file, "", "is a pointer that Git LFS left instead of the file: fetch it by 'git lfs pull'");
}

void FileBytes::unmap() {
  if (mapping_ != nullptr) ::munmap(mapping_, bytes_.size());
  mapping_ = nullptr;
}

FileBytes::~FileBytes() { unmap(); }

FileParts::FileParts(const std::filesystem::path& file) {
  Descriptor descriptor;
  size_ = open_regular(file, descriptor);
  descriptor_ = std::exchange(descriptor.number, -1);
}

FileParts::~FileParts() { ::close(descriptor_); }

std::optional<std::size_t> FileParts::read(std::size_t offset, std::span<char> to) const {
  std::size_t count = 0;
  while (count < to.size()) {
    const ssize_t got = ::pread(descriptor_, to.data() + count, to.size() - count, static_cast<off_t>(offset + count));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    count += static_cast<std::size_t>(got);
  }
  return count;
}

}  // namespace gpvc::io
