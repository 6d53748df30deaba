// A file without a name, for what does not fit in memory.
#include "io/scratch_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

namespace gpvc::io {

namespace {

[[noreturn]] void fail(const std::filesystem::path& folder, const char* what) {
  throw OutputError(folder,
                    std::string("a temporary file in this folder cannot be ") + what + ": " + std::strerror(errno));
}

/// Some file systems have no files without a name: there the name is removed at once.
int open_nameless(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0) return descriptor;
  std::string name = (folder / ".gpvc-scratch-XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

}  // namespace

ScratchFile::ScratchFile(std::filesystem::path folder)
    : folder_(std::move(folder)), descriptor_(open_nameless(folder_)) {
  if (descriptor_ < 0) fail(folder_, "made");
}

ScratchFile::~ScratchFile() {
  if (mapping_ != nullptr) ::munmap(mapping_, mapped_bytes_);
  ::close(descriptor_);
}

void ScratchFile::write(std::size_t place, const void* data, std::size_t bytes) {
  const char* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t done = ::pwrite(descriptor_, from, bytes, static_cast<off_t>(place));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) fail(folder_, "written");
    from += done;
    place += static_cast<std::size_t>(done);
    bytes -= static_cast<std::size_t>(done);
  }
}

void ScratchFile::read(std::size_t place, void* data, std::size_t bytes) const {
  char* to = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t done = ::pread(descriptor_, to, bytes, static_cast<off_t>(place));
    if (done < 0 && errno == EINTR) continue;
    if (done == 0) errno = EIO;  // the file ends
    if (done <= 0) fail(folder_, "read");
    to += done;
    place += static_cast<std::size_t>(done);
    bytes -= static_cast<std::size_t>(done);
  }
}

std::span<const std::uint8_t> ScratchFile::map(std::size_t bytes) {
  if (bytes == 0) return {};
  void* mapping = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, descriptor_, 0);
  if (mapping == MAP_FAILED) fail(folder_, "read");
  mapping_ = mapping;
  mapped_bytes_ = bytes;
  return {static_cast<const std::uint8_t*>(mapping), bytes};
}

}  // namespace gpvc::io
