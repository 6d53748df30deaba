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
  explicit Descriptor(int opened) : number(opened) {}
  Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
  int number;
};

/// A file that is cut while it is mapped ends the process with SIGBUS. Larger ones, which are few, are mapped all the same.
constexpr std::size_t kRead = 64 << 20;

/// Opens a file and finds out how large it is, or is said to be, as /proc has files without a size.
Descriptor open_file(const std::filesystem::path& file, std::size_t& size) {
  // A pipe without a writer would wait for one.
  Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (descriptor.number < 0) throw InputError(file, "", std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  if (::fstat(descriptor.number, &status) != 0)
    throw InputError(file, "", std::string("cannot be read: ") + std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw InputError(file, "", "is a folder, expected a file");
  if (!S_ISREG(status.st_mode)) throw InputError(file, "", kNotRegular);
  size = static_cast<std::size_t>(status.st_size);
  return descriptor;
}

/// Reads up to `room` bytes; fewer only where the file ends.
std::size_t read_some(const std::filesystem::path& file, const Descriptor& descriptor, char* to, std::size_t room) {
  std::size_t size = 0;
  while (size < room) {
    const ssize_t got = ::read(descriptor.number, to + size, room - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(file, "", std::string("cannot be read: ") + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  return size;
}

/// Bytes that are written before they are read: nothing clears them.
std::unique_ptr<char[]> new_bytes(std::size_t bytes) { return std::make_unique_for_overwrite<char[]>(bytes); }

/// Reads the file, of which `expected` bytes are known to be there. \param size how many there are
std::unique_ptr<char[]> read_all(const std::filesystem::path& file, const Descriptor& descriptor, std::size_t expected,
                                 std::size_t& size) {
  // One byte more, to see the end of the file. Rounded up, so that the allocator can reuse the block for the next file of this size.
  constexpr std::size_t kStep = 1 << 20;
  std::size_t room = expected < kStep ? expected + 1 : (expected / kStep + 1) * kStep;
  std::unique_ptr<char[]> bytes = new_bytes(room);
  size = read_some(file, descriptor, bytes.get(), room);
  while (size == room) {
    const std::size_t more = std::max<std::size_t>(2 * room, 1u << 17);
    std::unique_ptr<char[]> larger = new_bytes(more);
    std::memcpy(larger.get(), bytes.get(), size);
    bytes = std::move(larger);
    room = more;
    size += read_some(file, descriptor, bytes.get() + size, room - size);
  }
  return bytes;
}

}  // namespace

FileBytes::FileBytes(const std::filesystem::path& file, Use use) {
  std::size_t size = 0;
  const Descriptor descriptor = open_file(file, size);
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
    std::size_t read = 0;
    buffer_ = read_all(file, descriptor, std::min(size, kRead), read);
    bytes_ = {buffer_.get(), read};
  }
  try {
    refuse_lfs_pointer(file, bytes_);
  } catch (const InputError&) {
    unmap();
    throw;
  }
}

void read_pieces(const std::filesystem::path& file, const std::function<void(std::string_view bytes)>& take) {
  std::size_t told = 0;
  const Descriptor descriptor = open_file(file, told);
  constexpr std::size_t kPiece = 1 << 18;  // stays in the cache of a core
  const std::unique_ptr<char[]> piece = new_bytes(kPiece);
  bool first = true;
  for (std::size_t size = kPiece; size == kPiece; first = false) {
    size = read_some(file, descriptor, piece.get(), kPiece);
    if (first) refuse_lfs_pointer(file, {piece.get(), size});
    take({piece.get(), size});
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
  Descriptor descriptor = open_file(file, size_);
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
