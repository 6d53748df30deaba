#include "app/pipeline/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "app/pipeline/output_names.h"
#include "io/output_file.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnfinished = ".gpvc-unfinished-";
constexpr const char* kEarlier = ".gpvc-earlier-";

// True if the command may write this file at the top of OUT, as far as that is known before it runs.
bool is_written_by(std::string_view command, const std::string& name) {
  static const std::map<std::string_view, std::set<std::string_view>> kWritten = {
      {"texture",
       {"model.obj", "model.mtl", "model.glb", "model.gltf", "model.bin", "preview.png", "views.json", "labels.npy",
        "tags.npy", "faces.npy", "source_faces.npy", "offset.txt"}},
      {"visibility", {"views.json", "oracle.json"}},
      {"compare", {"report.html", "report.md", "report.json"}},
      {"compare --summarize", {"summary.html", "summary.md", "summary.json"}},
      {"evaluate", {"evaluate.json"}},
      {"label", {"labels.npy"}}};
  const auto written = kWritten.find(command);
  if (name == "run.json" || (written != kWritten.end() && written->second.contains(name))) return true;
  if (command != "texture" || !name.starts_with("model_")) return false;
  const std::size_t end = name.find_first_not_of("0123456789", 6);
  const std::string extension = end == std::string::npos || end == 6 ? "" : name.substr(end);
  return extension == ".png" || extension == ".jpg" || extension == ".bin";
}

std::optional<std::string> name_from_json(const nlohmann::json& entry) {
  if (entry.is_string()) return entry.get<std::string>();
  if (!entry.is_object() || !entry.contains("bytes") || !entry["bytes"].is_string()) return std::nullopt;
  const auto& digits = entry["bytes"].get_ref<const std::string&>();
  std::string name;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    int byte = 0;
    const char* first = digits.data() + i;
    if (std::from_chars(first, first + 2, byte, 16).ptr != first + 2) return std::nullopt;
    name += static_cast<char>(byte);
  }
  return name;
}

// The result of an earlier run of gpvc.
struct EarlierResult {
  std::string command;          ///< empty: there was none
  std::set<std::string> files;  ///< that its run.json lists, without names that lead out of the folder
};

EarlierResult earlier_result(const fs::path& out) {
  std::ifstream in(out / "run.json");
  const auto json = nlohmann::json::parse(in, nullptr, false);
  const bool ours = json.is_object() && json.value("program", nlohmann::json()) == "gpvc";
  if (!ours || !json.contains("command") || !json["command"].is_string()) return {};
  EarlierResult earlier{json["command"].get<std::string>(), {}};
  const nlohmann::json outputs = json.value("outputs", nlohmann::json());
  if (!outputs.is_array()) return earlier;
  for (const auto& entry : outputs) {
    const std::optional<std::string> name = name_from_json(entry);
    if (!name) continue;
    try {
      earlier.files.insert(contained_path(*name).generic_string());
    } catch (const OutputError&) {
      continue;
    }
  }
  return earlier;
}

bool is_there(const fs::path& path) { return fs::exists(fs::symlink_status(path)); }

void remove_empty_parents(const fs::path& out, fs::path folder) {
  std::error_code ignored;
  while (folder != out && folder.has_relative_path() && fs::is_empty(folder, ignored) && !ignored) {
    fs::remove(folder, ignored);
    folder = folder.parent_path();
  }
}

fs::path make_folder_like(const fs::path& prefix) {
  std::string name = prefix.string() + "XXXXXX";
  if (mkdtemp(name.data()) == nullptr)
    throw fs::filesystem_error("", prefix, std::error_code(errno, std::generic_category()));
  return name;
}

struct FolderLock {
  int descriptor = -1;  ///< -1: not locked by this process
  bool others = false;  ///< another process holds the lock; false with -1: the file system has no locks
};

// The lock lasts until the descriptor is closed or the process ends, in whatever way.
FolderLock locked(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0 || flock(descriptor, LOCK_EX | LOCK_NB) == 0) return {descriptor, false};
  const bool others = errno == EWOULDBLOCK;
  close(descriptor);
  return {-1, others};
}

// Removes what killed runs left: folders that no process has locked. (Process numbers would not do: they recur, at once in
// containers, and differ from machine to machine.)
void remove_abandoned(const fs::path& out) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(out))
    if (entry.path().filename().string().starts_with(kUnfinished)) found.push_back(entry.path());
  for (const fs::path& folder : found) {
    const FolderLock lock = locked(folder);
    if (lock.descriptor < 0) continue;
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    close(lock.descriptor);
  }
}

// Files on their way to their final names, and the earlier ones that they replace.
class MovedFiles {
 public:
  explicit MovedFiles(const fs::path& out) : out_(out) {}

  void move(const fs::path& from, const fs::path& to) {
    fs::create_directories(to.parent_path());
    fs::rename(from, to);
    moved_.push_back({from, to});
  }
  // Moves a file of the earlier result to a hidden folder.
  void set_aside(const std::string& name) {
    if (earlier_.empty()) earlier_ = make_folder_like(out_ / kEarlier);
    move(out_ / name, earlier_ / name);
    remove_empty_parents(out_, (out_ / name).parent_path());
  }
  // Moves all files back. Returns false if one could not be.
  bool undo() {
    bool all_back = true;
    for (auto it = moved_.rbegin(); it != moved_.rend(); ++it) {
      std::error_code failed;
      fs::create_directories(it->from.parent_path(), failed);
      fs::rename(it->to, it->from, failed);
      if (failed) all_back = false;
      remove_empty_parents(out_, it->to.parent_path());
    }
    return all_back;
  }
  const fs::path& earlier() const { return earlier_; }
  void remove_earlier() const {
    std::error_code ignored;
    if (!earlier_.empty()) fs::remove_all(earlier_, ignored);
  }

 private:
  struct Moved {
    fs::path from, to;
  };
  const fs::path& out_;
  fs::path earlier_;  ///< empty until a file is set aside
  std::vector<Moved> moved_;
};

}  // namespace

OutputFolder::OutputFolder(fs::path out) : out_(std::move(out)) {}

// The other constructor has finished: whatever is thrown here, the destructor clears away what was made.
OutputFolder::OutputFolder(fs::path out, bool force, std::string_view command) : OutputFolder(std::move(out)) {
  try {
    create();
    refuse_results_in_the_way(force, command);
    remove_abandoned(out_);
    make_unfinished();
  } catch (const fs::filesystem_error& e) {
    throw OutputError(out_, "cannot be written: " + e.code().message());
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!unfinished_.empty()) fs::remove_all(unfinished_, ignored);
  if (lock_ >= 0) close(lock_);
  for (auto it = created_.rbegin(); it != created_.rend(); ++it) fs::remove(*it, ignored);  // only when empty
}

void OutputFolder::create() {
  fs::path missing = fs::absolute(out_).lexically_normal();
  if (!missing.has_filename()) missing = missing.parent_path();
  for (; !fs::exists(missing) && missing.has_relative_path(); missing = missing.parent_path())
    created_.insert(created_.begin(), missing);
  if (fs::exists(out_) && !fs::is_directory(out_)) throw OutputError(out_, "exists and is not a folder");
  fs::create_directories(out_);
}

void OutputFolder::refuse_results_in_the_way(bool force, std::string_view command) {
  // Another command's result (a scene, a model) is likely to be the input of something.
  const EarlierResult earlier = earlier_result(out_);
  if (!earlier.command.empty() && earlier.command != command)
    throw OutputError(out_, fmt::format("holds the result of 'gpvc {}'; choose another folder", earlier.command));
  listed_ = earlier.files;
  if (!listed_.empty() && !force)
    throw OutputError(out_,
                      fmt::format("already holds a result ({}); choose another folder, or give --force to replace "
                                  "it when the new one is complete",
                                  *listed_.begin()));
  for (const auto& entry : fs::directory_iterator(out_)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(kEarlier))
      throw OutputError(entry.path(),
                        "holds an earlier result, as a run was killed while it replaced it; move the files back or "
                        "remove them first");
    if (is_written_by(command, name)) refuse_foreign_file(name);
  }
}

void OutputFolder::make_unfinished() {
  // Another run may take the new folder for abandoned and remove it before it is locked.
  for (bool taken = true; taken;) {
    if (lock_ >= 0) close(lock_);
    unfinished_ = make_folder_like(out_ / kUnfinished);
    const FolderLock lock = locked(unfinished_);
    lock_ = lock.descriptor;
    taken = lock.others || !fs::exists(unfinished_);
  }
  const io::OutputFile probe(unfinished_ / "probe");  // throws where no file can be made; removed at once
}

void OutputFolder::refuse_foreign_file(const std::string& name) const {
  const fs::path path = out_ / name;
  if (!is_there(path)) return;
  if (!listed_.contains(fs::path(name).lexically_normal().generic_string()))
    throw OutputError(path, "would be replaced, and belongs to no earlier result; choose another folder");
  if (fs::is_directory(path)) throw OutputError(path, "is a folder where a file is to be; choose another folder");
}

void OutputFolder::protect(const std::set<fs::path>& inputs) {
  for (const fs::path& input : inputs) protected_.insert(fs::weakly_canonical(input));
  for (const std::string& name : listed_)
    if (protected_.contains(fs::weakly_canonical(out_ / name)))
      throw OutputError(out_ / name,
                        "is read by this run and belongs to the result it would replace; choose another folder");
}

fs::path OutputFolder::file(const fs::path& relative) {
  const fs::path inside = contained_path(relative.generic_string());
  const fs::path path = unfinished_ / inside;
  refuse_foreign_file(inside.generic_string());
  try {
    fs::create_directories(path.parent_path());
  } catch (const fs::filesystem_error& e) {
    throw OutputError((out_ / inside).parent_path(), e.code().message());
  }
  promised_.push_back(inside.generic_string());
  return path;
}

void OutputFolder::promise_all() {
  promised_.clear();
  for (const auto& entry : fs::recursive_directory_iterator(unfinished_))
    if (entry.is_regular_file()) promised_.push_back(entry.path().lexically_relative(unfinished_).generic_string());
  std::sort(promised_.begin(), promised_.end());
}

void OutputFolder::publish() {
  for (const std::string& name : promised_) {
    if (!fs::is_regular_file(unfinished_ / name)) throw OutputError(out_ / name, "was not written");
    if (protected_.contains(fs::weakly_canonical(out_ / name)))
      throw OutputError(out_ / name, "is read by this run and would be replaced; choose another folder");
    refuse_foreign_file(name);
  }
  MovedFiles moved(out_);
  fs::path at;
  try {
    for (const std::string& name : listed_) {
      at = out_ / name;
      if (is_there(at) && !fs::is_directory(at)) moved.set_aside(name);
    }
    for (const std::string& name : promised_) {
      at = out_ / name;
      moved.move(unfinished_ / name, at);
    }
  } catch (const fs::filesystem_error& e) {
    const bool all_back = moved.undo();
    const std::string lost =
        all_back ? "" : fmt::format("; files of the earlier result are in {}", moved.earlier().string());
    if (all_back) moved.remove_earlier();
    throw OutputError(at, e.code().message() + lost);
  }
  moved.remove_earlier();
  std::error_code ignored;
  fs::remove_all(unfinished_, ignored);
}

nlohmann::ordered_json outputs_json(const std::vector<std::string>& names) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const std::string& name : names) {
    const nlohmann::ordered_json text = nlohmann::ordered_json::parse(
        nlohmann::ordered_json(name).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    if (text == name) {
      list.push_back(name);
      continue;
    }
    std::string digits;
    for (const char c : name) digits += fmt::format("{:02x}", static_cast<unsigned char>(c));
    list.push_back({{"name", text}, {"bytes", digits}});
  }
  return list;
}

std::string OutputFolder::with_final_names(std::string message) const {
  const std::string in_making = unfinished_.string();
  for (std::size_t at = message.find(in_making); at != std::string::npos; at = message.find(in_making, at))
    message.replace(at, in_making.size(), out_.string());
  return message;
}

fs::path contained_path(const std::string& name) {
  const fs::path path = fs::path(name).lexically_normal();
  const bool escapes = path.empty() || path == "." || path.has_root_path() || *path.begin() == "..";
  if (escapes || !path.has_filename()) throw OutputError(name, "is no name for a file inside the output folder");
  return path;
}

}  // namespace gpvc::pipeline
