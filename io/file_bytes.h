// A whole file as bytes, and a bounds-checked cursor over little-endian records.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "error.h"

namespace gpvc::io {

static_assert(std::endian::native == std::endian::little, "files are read and written as little endian");

/// The bytes of a file: read, or memory-mapped where they are many or looked at in places, so that they do not count as the
/// process's memory. Throws InputError when the file cannot be opened or read, is a pipe or a device, or the pointer that Git LFS
/// leaves where it has not fetched a file.
class FileBytes {
 public:
  /// `whole` reads all of a file ahead; with `in_places` only the pages that are looked at are read.
  enum class Use { whole, in_places };
  explicit FileBytes(const std::filesystem::path& file, Use use = Use::whole);
  ~FileBytes();
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;
  std::string_view view() const { return bytes_; }

 private:
  void unmap();
  std::string_view bytes_;
  void* mapping_ = nullptr;
  std::unique_ptr<char[]> buffer_;
};

/// Gives the bytes of a file piece by piece to a function that needs each once, without room for all of them. Throws as FileBytes
/// does.
void read_pieces(const std::filesystem::path& file, const std::function<void(std::string_view bytes)>& take);

/// A file that is read a part at a time and not held. Throws InputError as FileBytes does, except for a pointer of Git LFS.
class FileParts {
 public:
  explicit FileParts(const std::filesystem::path& file);
  ~FileParts();
  FileParts(const FileParts&) = delete;
  FileParts& operator=(const FileParts&) = delete;
  std::size_t size() const { return size_; }
  /// Returns how many of the bytes from `offset` on there are; nullopt: they cannot be read. Thread-safe.
  std::optional<std::size_t> read(std::size_t offset, std::span<char> to) const;

 private:
  int descriptor_;
  std::size_t size_ = 0;
};

/// Throws InputError if the bytes, which `file` begins with, are of the pointer that Git LFS leaves in a file's place.
void refuse_lfs_pointer(const std::filesystem::path& file, std::string_view bytes);

/// Reads values one after another; running past the end is an InputError that says what was being read.
class ByteReader {
 public:
  ByteReader(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  template <typename T>
  T read(const char* what) {
    T value;
    std::memcpy(&value, take(sizeof(T), what).data(), sizeof(T));
    return value;
  }
  /// `count` bytes.
  std::string_view take(std::uint64_t count, const char* what) {
    if (count > bytes_.size() - position_) fail(std::string("the file ends inside ") + what);
    position_ += static_cast<std::size_t>(count);
    return bytes_.substr(position_ - static_cast<std::size_t>(count), static_cast<std::size_t>(count));
  }
  /// Text up to a zero byte, which is consumed.
  std::string_view take_text(const char* what) {
    const std::size_t end = bytes_.find('\0', position_);
    if (end == std::string_view::npos) fail(std::string("the file ends inside ") + what);
    const std::string_view text = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    return text;
  }
  std::size_t remaining() const { return bytes_.size() - position_; }
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_, "byte " + std::to_string(position_), reason);
  }

 private:
  const std::filesystem::path& file_;
  std::string_view bytes_;
  std::size_t position_ = 0;
};

}  // namespace gpvc::io
