#include "app/output_folder.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/io.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnfinished = ".gpvc-unfinished-";

// What some command of ours leaves behind; enough to know an earlier result by, not enough to remove it for.
bool is_result_name(const std::string& name) {
  constexpr const char* kNames[] = {"run.json",  "model.obj",   "model.mtl",  "model.glb",  "model.gltf",
                                    "model.bin", "preview.png", "views.json", "labels.npy", "tags.npy",
                                    "faces.npy", "visibility",  "ivm"};
  const bool named = std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
  return named || (name.starts_with("model_") &&
                   (name.ends_with(".png") || name.ends_with(".jpg") || name.ends_with(".bin")));
}

std::vector<std::string> earlier_result(const fs::path& out) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(out))
    if (is_result_name(entry.path().filename().string())) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

// What an earlier run left beside its result; discarded where there is none of ours.
nlohmann::json earlier_run(const fs::path& out) {
  std::ifstream in(out / "run.json");
  return nlohmann::json::parse(in, nullptr, false);
}

// The command of an earlier run; empty where that is not known.
std::string earlier_command(const fs::path& out) {
  const auto json = earlier_run(out);
  const bool ours = json.is_object() && json.value("program", nlohmann::json()) == "gpvc";
  if (!ours || !json.contains("command") || !json["command"].is_string()) return {};
  return json["command"].get<std::string>();
}

// The files an earlier run.json lists, if they are what a run.json lists: relative, inside.
std::vector<std::string> listed_outputs(const fs::path& out) {
  std::vector<std::string> names;
  const auto json = earlier_run(out);
  if (!json.is_object() || !json.contains("outputs") || !json["outputs"].is_array()) return names;
  for (const auto& name : json["outputs"]) {
    if (!name.is_string()) continue;
    try {
      names.push_back(contained_path(name.get<std::string>()).string());
    } catch (const OutputError&) {
      continue;  // not ours to touch
    }
  }
  return names;
}

void remove_empty_parents(const fs::path& out, fs::path folder) {
  std::error_code ignored;
  while (folder != out && folder.has_relative_path() && fs::is_empty(folder, ignored) && !ignored) {
    fs::remove(folder, ignored);
    folder = folder.parent_path();
  }
}

// Left by a run that was killed: its process is gone.
void remove_abandoned(const fs::path& out) {
  for (const auto& entry : fs::directory_iterator(out)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kUnfinished)) continue;
    pid_t pid = 0;
    const char* digits = name.c_str() + std::string(kUnfinished).size();
    std::from_chars(digits, name.c_str() + name.size(), pid);
    std::error_code ignored;
    if (pid > 0 && kill(pid, 0) != 0 && errno == ESRCH) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

OutputFolder::OutputFolder(fs::path out, bool force, std::string_view command) : out_(std::move(out)) {
  try {
    fs::path missing = fs::absolute(out_).lexically_normal();
    if (!missing.has_filename()) missing = missing.parent_path();
    for (; !fs::exists(missing) && missing.has_relative_path(); missing = missing.parent_path())
      created_.insert(created_.begin(), missing);
    if (fs::exists(out_) && !fs::is_directory(out_)) throw OutputError(out_, "exists and is not a folder");
    fs::create_directories(out_);
    // Another command's result is somebody's input as likely as not: a scene, a model.
    if (const std::string other = earlier_command(out_); !other.empty() && other != command)
      throw OutputError(out_, fmt::format("holds the result of 'gpvc {}'; choose another folder", other));
    const auto earlier = earlier_result(out_);
    if (!earlier.empty() && !force)
      throw OutputError(out_,
                        fmt::format("already holds a result ({}); choose another folder, or give --force to "
                                    "replace it when the new one is complete",
                                    earlier.front()));
    remove_abandoned(out_);
    unfinished_ = out_ / fmt::format("{}{}", kUnfinished, getpid());
    fs::create_directory(unfinished_);
    const OutputFile probe(unfinished_ / "probe");  // opens a file; removed at once
  } catch (const fs::filesystem_error& e) {
    std::error_code ignored;
    if (!unfinished_.empty()) fs::remove_all(unfinished_, ignored);
    for (auto it = created_.rbegin(); it != created_.rend(); ++it) fs::remove(*it, ignored);
    throw OutputError(out_, "cannot be written: " + e.code().message());
  } catch (...) {
    std::error_code ignored;
    if (!unfinished_.empty()) fs::remove_all(unfinished_, ignored);
    throw;
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(unfinished_, ignored);
  for (auto it = created_.rbegin(); it != created_.rend(); ++it) fs::remove(*it, ignored);  // only when empty
}

void OutputFolder::protect(const std::set<fs::path>& inputs) {
  for (const fs::path& input : inputs) protected_.insert(fs::weakly_canonical(input));
  for (const std::string& name : listed_outputs(out_))
    if (protected_.contains(fs::weakly_canonical(out_ / name)))
      throw OutputError(
          out_ / name,
          "is read by this run and belongs to the result it would replace; choose another folder");
}

fs::path OutputFolder::file(const fs::path& relative) {
  const fs::path inside = contained_path(relative.generic_string());
  const fs::path path = unfinished_ / inside;
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
    if (entry.is_regular_file())
      promised_.push_back(entry.path().lexically_relative(unfinished_).generic_string());
  std::sort(promised_.begin(), promised_.end());
}

void OutputFolder::publish() {
  for (const std::string& name : promised_)
    if (!fs::is_regular_file(unfinished_ / name)) throw OutputError(out_ / name, "was not written");
  for (const std::string& name : promised_)
    if (protected_.contains(fs::weakly_canonical(out_ / name)))
      throw OutputError(out_ / name, "is read by this run and would be replaced; choose another folder");
  fs::path at;
  std::vector<fs::path> moved;
  try {
    for (const std::string& name : listed_outputs(out_)) {
      at = out_ / name;
      if (fs::is_regular_file(at)) fs::remove(at);
      remove_empty_parents(out_, at.parent_path());
    }
    for (const std::string& name : promised_) {
      at = out_ / name;
      fs::create_directories(at.parent_path());
      fs::rename(unfinished_ / name, at);
      moved.push_back(at);
    }
  } catch (const fs::filesystem_error& e) {
    std::error_code ignored;
    for (const fs::path& file : moved) fs::remove(file, ignored);
    throw OutputError(at, e.code().message());
  }
  fs::remove_all(unfinished_);
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
  if (escapes || !path.has_filename())
    throw OutputError(name, "is no name for a file inside the output folder");
  return path;
}

}  // namespace gpvc
