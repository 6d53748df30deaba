// Files of a folder, moved and removed without following symbolic links out of it.
#pragma once

#include <filesystem>
#include <optional>

namespace gpvc::results {

/// A folder, held open. Names are relative to it. The folders on the way to a file are opened one by one, and none of them
/// may be a symbolic link, so that nothing outside is touched even if the tree changes meanwhile. Throws
/// std::filesystem::filesystem_error.
class FolderFiles {
 public:
  explicit FolderFiles(std::filesystem::path folder);
  ~FolderFiles();
  FolderFiles(const FolderFiles&) = delete;
  FolderFiles& operator=(const FolderFiles&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// True for anything but a folder; false where it, or a folder on the way to it, does not exist or is a link.
  bool has(const std::filesystem::path& name) const;
  /// The first symbolic link among the folders on the way to a file.
  std::optional<std::filesystem::path> link_on_the_way(const std::filesystem::path& name) const;
  /// Renames a file and creates the folders of its new name. Replaces nothing.
  void move(const std::filesystem::path& from, const std::filesystem::path& to) const;
  /// Removes the folders of `name` that are empty, inner ones first.
  void remove_empty_parents(const std::filesystem::path& name) const noexcept;
  /// Makes renamed files survive a power cut, as far as the file system can.
  void flush() const noexcept;

 private:
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace gpvc::results
