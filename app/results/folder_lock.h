// Keeps two runs from writing to one folder.
#pragma once

#include <filesystem>

namespace gpvc::results {

/// A lock on FOLDER/.gpvc-lock. It ends with the object or with the process, in whatever way; a killed run leaves the file,
/// which then means nothing.
class FolderLock {
 public:
  /// Throws OutputError when another run holds the lock (naming its process), filesystem_error when no file can be made.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// False where the file system has no locks: other runs may be under way.
  bool held() const { return held_; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  bool held_ = false;
};

}  // namespace gpvc::results
