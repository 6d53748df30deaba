// Hashes of files, taken again only where a file may have changed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>

#include "work_store.h"

namespace gpvc::io {

/// What a file system tells of a file without reading it. Programs can set the time of modification to anything, but not
/// that of the last change of the file's entry (ctime). (Devices have other numbers on other machines.)
struct FileState {
  std::uint64_t inode = 0, bytes = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;  ///< since 1970
  bool operator==(const FileState&) const = default;
};
GPVC_MEMBERS(FileState, inode, bytes, modified_ns, changed_ns)

/// Throws InputError.
FileState file_state(const std::filesystem::path& file);

/// The hash of a file that was in this state when it was hashed.
struct HashedFile {
  FileState state;
  std::int64_t hashed_ns = 0;  ///< when, since 1970
  WorkKey hash;

  /// True if an equal state now means equal bytes. False if the file was changed shortly before it was hashed: a later change might have the same times then, which count in
  /// steps of up to two seconds (FAT, old NFS), by clocks that differ between machines.
  bool proves_unchanged() const;
  bool operator==(const HashedFile&) const = default;
};
GPVC_MEMBERS(HashedFile, state, hashed_ns, hash)

/// Hashes of files, each with the state that the file was in. Thread-safe. A file whose hash is known is not read again
/// unless its state is another one, or would not tell; else each call takes O(bytes of the file).
class FileHashes {
 public:
  /// The hash of the file's bytes, which is what is known from now on. Throws InputError.
  HashedFile of(const std::filesystem::path& file);
  /// The same for a file that must stay what it is while it is used: throws InputError where it has other bytes than those
  /// that are known. One that was merely touched passes.
  HashedFile unchanged(const std::filesystem::path& file);
  /// Takes over what was known earlier, for files of which nothing is known yet.
  void learn(const std::filesystem::path& file, const HashedFile& known);

 private:
  /// What is known, or, where that may not hold any more, what the file is now.
  HashedFile look_at(const std::filesystem::path& file) const;

  mutable std::mutex mutex_;
  std::map<std::filesystem::path, HashedFile> known_;
};

}  // namespace gpvc::io
