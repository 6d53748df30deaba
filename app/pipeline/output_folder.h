// The folder a command promises its files in: nothing half-written under a final name, nobody's result overwritten by
// mistake.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gpvc::pipeline {

/// Files are made in a hidden folder inside OUT and move to their final names all together at the end, `run.json` last.
/// Until then an earlier result stays as it is; a run that fails or is interrupted leaves OUT as it found it.
class OutputFolder {
 public:
  /// Creates OUT and its parents. Throws OutputError when it cannot be written, when it holds an earlier result and
  /// `force` is false, when the run.json there is of another `command`, and when a file is in the way that belongs to
  /// no earlier result (as far as it is known what `command` will write; else file() and publish() tell).
  OutputFolder(std::filesystem::path out, bool force, std::string_view command);
  /// Removes what was not published, and folders made in vain.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Files that the run reads: neither removed with an earlier result nor replaced by the new one. Throws OutputError
  /// when the earlier result holds one of them. O(n log n).
  void protect(const std::set<std::filesystem::path>& inputs);

  /// Where to write the file that will be OUT/`relative`; parents are made. The file is promised from now on. Throws
  /// OutputError when `relative` would leave OUT, or a stranger's file has that name.
  std::filesystem::path file(const std::filesystem::path& relative);
  /// Throws OutputError when OUT/`name` exists and is no file of the earlier result.
  void refuse_strangers(const std::string& name) const;
  /// Where file() leads; what a stage leaves here on its own is promised by promise_all().
  const std::filesystem::path& in_making() const { return unfinished_; }
  void promise_all();
  /// Promised so far, in the order of file().
  const std::vector<std::string>& promised() const { return promised_; }
  const std::filesystem::path& path() const { return out_; }
  /// Files of the earlier result.
  const std::set<std::string>& listed() const { return listed_; }

  /// Puts every promised file in the place of the earlier result. Throws OutputError when one is missing, when its name
  /// is a protected file's or a stranger's, and when a file cannot be moved; then the earlier result is back. A run
  /// that is killed within this leaves the earlier files in a hidden folder inside OUT.
  void publish();
  /// `message` with the names of files in the making replaced by their final names.
  std::string with_final_names(std::string message) const;

 private:
  void clear_away();

  std::filesystem::path out_, unfinished_;
  int lock_ = -1;  ///< on unfinished_: tells other runs that it is not abandoned
  std::set<std::string> listed_;
  std::vector<std::filesystem::path> created_;  ///< folders made on the way to OUT, outermost first
  std::vector<std::string> promised_;
  std::set<std::filesystem::path> protected_;  ///< canonical
};

/// A path below a folder from a name that a scene file gives: keeps sub-folders, refuses what leaves the folder ("..",
/// a root). Throws OutputError.
std::filesystem::path contained_path(const std::string& name);

}  // namespace gpvc::pipeline
