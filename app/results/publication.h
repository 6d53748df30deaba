// Replacing an earlier result by a new one, so that a kill at any moment can be repaired.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/results/folder_files.h"

namespace gpvc::results {

/// A hidden folder WORK inside OUT holds WORK/new (the new files), WORK/earlier (those that they replace) and, while files
/// are being moved, WORK/publishing.json, which lists both. Every file is at one of two places, and which one tells how
/// far the work has come: forward() and undo() can be started at any point, any number of times.
class Publication {
 public:
  /// `work`: the folder's name. `replaced` exist in OUT, `promised` in WORK/new.
  Publication(const FolderFiles& out, std::filesystem::path work, std::vector<std::string> replaced,
              std::vector<std::string> promised);
  /// The publication that WORK/publishing.json lists; nothing where there is none. Throws OutputError when it cannot be
  /// read.
  static std::optional<Publication> interrupted(const FolderFiles& out, const std::filesystem::path& work);

  /// From now on a kill is repaired by finishing. Throws OutputError.
  void begin() const;
  /// Moves what is not at its final place. Throws OutputError with the file's name.
  void forward() const;
  /// Brings the earlier result back. Returns false when a file cannot be moved.
  bool undo() const;
  /// Nothing is left to do, or everything is undone. Throws OutputError.
  void end() const;

 private:
  std::filesystem::path fresh(const std::string& name) const { return work_ / "new" / name; }
  std::filesystem::path earlier(const std::string& name) const { return work_ / "earlier" / name; }
  void move(const std::filesystem::path& from, const std::filesystem::path& to, const std::string& name) const;

  const FolderFiles* out_;
  std::filesystem::path work_;
  std::vector<std::string> replaced_, promised_;
};

}  // namespace gpvc::results
