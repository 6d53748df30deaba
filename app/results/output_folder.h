// A folder of results. No file appears under its final name before all are complete, and no file is overwritten that does
// not belong to an earlier result of the same command.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gpvc::results {

class FolderFiles;
class Observer;
class FolderLock;
class Publication;

/// In OutputFolder::checkpoints(): the hashes of what is kept (io::WorkStore).
inline constexpr const char* kCheckpointHashes = "hashes.txt";

/// Files are written to a hidden folder inside OUT and moved to their final names all together at the end, `run.json` last.
/// Until then an earlier result stays unchanged. A run that fails or is interrupted leaves OUT unchanged; what a killed
/// one left is cleared away by the next, which also finishes a result that was being published. OUT is locked meanwhile.
/// Below OUT no symbolic link is followed to remove or replace a file.
class OutputFolder {
 public:
  /// Creates OUT and its parents. `command`: what makes the result; its results replace each other. Throws OutputError when
  /// it cannot be written, when another run has it locked, when it holds an earlier result and `force` is false, when a
  /// folder of that is a symbolic link, when the run.json there is of another `command`, and when a file that `command`
  /// will write, as far as that is known beforehand, exists and belongs to no earlier result. (file() and publish() check
  /// the others.)
  explicit OutputFolder(std::filesystem::path out, bool force = false, std::string_view command = "library");
  /// Finishes the result that a killed run was publishing in OUT, if there is one, for those who read it; nothing where OUT
  /// is no folder that can be listed. Throws OutputError when that is not possible, and when a run is publishing it now.
  static void finish_interrupted(const std::filesystem::path& out);
  /// Removes files that were not published, and the folders made for them.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Protects files that the run reads: they are neither removed with an earlier result nor replaced by the new one.
  /// Throws OutputError when the earlier result holds one of them. O(n log n).
  void protect(const std::set<std::filesystem::path>& inputs);

  /// Throws OutputError when OUT's file system has less than `least` bytes free; warns when it has less than `likely`.
  void expect_space(double least, double likely, Observer& observer) const;

  /// Bytes free on OUT's file system; infinite where that is unknown.
  double space() const;

  /// A folder in OUT for what a run keeps of its work until the result is complete. publish() removes what is in it. Throws
  /// OutputError when it is a symbolic link.
  std::filesystem::path checkpoints() const;
  /// True if an earlier run has kept some.
  bool has_checkpoints() const;

  /// Where to write the file that will be OUT/`relative`; creates its parents. The file is promised from now on. Throws
  /// OutputError when `relative` would leave OUT, or a foreign file has that name.
  std::filesystem::path file(const std::filesystem::path& relative);
  /// Throws OutputError when OUT/`name` exists and is foreign (no file of the earlier result), or lies behind a symbolic
  /// link in OUT.
  void refuse_foreign_file(const std::string& name) const;
  /// The hidden folder. promise_all() promises the files that were written there without file().
  const std::filesystem::path& in_making() const { return unfinished_; }
  void promise_all();
  /// Removes the files that were written so far: none is promised any more.
  void start_over();
  /// Files promised so far, in the order of the calls.
  const std::vector<std::string>& promised() const { return promised_; }
  /// Their names as the JSON array that run.json has as "outputs".
  std::string promised_json() const;
  const std::filesystem::path& path() const { return out_; }
  /// Files of the earlier result.
  const std::set<std::string>& listed() const { return listed_; }

  /// Replaces the earlier result by the promised files and unlocks OUT. Throws OutputError when one is missing, when its
  /// name is that of a protected or foreign file, and when a file cannot be moved; then the earlier result is back. If the
  /// process is killed in here, the next run in OUT finishes it.
  void publish();
  /// Removes files that were not published, unlocks OUT and removes the folders made for it. Nothing else may be called
  /// afterwards. Threads that still write files get errors.
  void discard() noexcept;
  /// `message` with the path of the hidden folder replaced by OUT, as errors about unfinished files name it.
  std::string with_final_names(std::string message) const;

 private:
  struct Unmade {};
  OutputFolder(std::filesystem::path out, Unmade);
  void create();
  bool repair();
  void finish(const Publication& publication, const std::filesystem::path& work);
  void complete(const Publication& publication);
  void refuse_results_in_the_way(bool force, std::string_view command, bool repaired);
  void refuse_link(const std::string& name) const;
  void make_work_folder();

  std::filesystem::path out_, unfinished_;
  std::filesystem::path work_;  ///< name of the hidden folder in OUT, see Publication; empty: none
  std::unique_ptr<FolderFiles> files_;
  std::unique_ptr<FolderLock> lock_;
  std::set<std::string> listed_;
  std::vector<std::filesystem::path> created_;  ///< folders made on the way to OUT, outermost first
  std::vector<std::string> promised_;
  std::set<std::filesystem::path> protected_;  ///< canonical
};

/// The relative path that a name from a scene file stands for. Keeps sub-folders; throws OutputError for a path that leaves
/// the folder ("..", a root).
std::filesystem::path contained_path(const std::string& name);

}  // namespace gpvc::results
