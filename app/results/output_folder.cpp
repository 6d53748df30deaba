#include "app/results/output_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "app/results/folder_lock.h"
#include "app/results/observer.h"
#include "app/results/output_names.h"
#include "app/results/publication.h"
#include "io/output_file.h"
#include "io/paths.h"
#include "io/work_store.h"

namespace gpvc::results {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnfinished = ".gpvc-unfinished-";

// True if the command may write this file at the top of OUT, as far as that is known before it runs.
bool is_written_by(std::string_view command, const std::string& name) {
  static const std::map<std::string_view, std::set<std::string_view>> kWritten = {
      {"texture",
       {"model.obj", "model.mtl", "model.glb", "model.gltf", "model.bin", "preview.png", "misfit.png", "views.json",
        "labels.npy", "tags.npy", "faces.npy", "source_faces.npy", "offset.txt", "metadata.xml", "edit-views.bin",
        "edit-model.bin", "edit-hashes.txt"}},
      {"tileset", {"tileset.json", "index.html", "preview.png", "views.json"}},
      {"ortho",
       {"ortho.tif", "ortho_bands.tif", "ortho_height.tif", "ortho_photo.tif", "ortho_photos.csv", "views.json"}},
      {"visibility", {"views.json", "oracle.json"}},
      {"coverage",
       {"coverage.geojson", "coverage.csv", "coverage.png", "coverage_photos.npy", "coverage_gsd.npy",
        "coverage_angle.npy", "coverage_lack.npy"}},
      {"compare", {"report.html", "report.md", "report.json"}},
      {"compare --summarize", {"summary.html", "summary.md", "summary.json"}},
      {"evaluate", {"evaluate.json"}},
      {"label", {"labels.npy"}}};
  const auto written = kWritten.find(command);
  if (name == "run.json" || (written != kWritten.end() && written->second.contains(name))) return true;
  if (command != "texture" || !name.starts_with("model_")) return false;
  const std::size_t end = name.find_first_not_of("0123456789", 6);
  const std::string extension = end == std::string::npos || end == 6 ? "" : name.substr(end);
  return extension == ".png" || extension == ".jpg" || extension == ".tif" || extension == "_bands.png" ||
         extension == ".bin";
}

std::optional<std::string> name_from_json(const nlohmann::ordered_json& entry) {
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
  if (!io::is_file(out / "run.json")) return {};
  std::ifstream in(out / "run.json");
  const auto json = nlohmann::ordered_json::parse(in, nullptr, false);
  const bool ours = json.is_object() && json.value("program", nlohmann::ordered_json()) == "gpvc";
  if (!ours || !json.contains("command") || !json["command"].is_string()) return {};
  const std::vector<std::string> names = output_names(json.value("outputs", nlohmann::ordered_json()));
  return {json["command"].get<std::string>(), {names.begin(), names.end()}};
}

fs::path make_folder_like(const fs::path& prefix) {
  std::string name = prefix.string() + "XXXXXX";
  if (mkdtemp(name.data()) == nullptr)
    throw fs::filesystem_error("", prefix, std::error_code(errno, std::generic_category()));
  return name;
}

// The hidden folders in which runs make their files.
std::vector<fs::path> work_folders(const fs::path& out) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(out))
    if (entry.path().filename().string().starts_with(kUnfinished) && !entry.is_symlink() && entry.is_directory())
      found.push_back(entry.path().filename());
  return found;
}

void remove_tree(const fs::path& folder) noexcept {
  std::error_code ignored;
  fs::remove_all(folder, ignored);
}

}  // namespace

OutputFolder::OutputFolder(fs::path out, Unmade) : out_(std::move(out)) {}

// The other constructor has finished: whatever is thrown here, the destructor clears away what was made.
OutputFolder::OutputFolder(fs::path out, bool force, std::string_view command)
    : OutputFolder(std::move(out), Unmade{}) {
  try {
    create();
    files_ = std::make_unique<FolderFiles>(out_);
    lock_ = std::make_unique<FolderLock>(out_);
    const bool repaired = repair();
    refuse_results_in_the_way(force, command, repaired);
    make_work_folder();
  } catch (const fs::filesystem_error& e) {
    throw OutputError(out_, "cannot be written: " + e.code().message());
  }
}

void OutputFolder::finish_interrupted(const fs::path& out) {
  std::error_code failed;
  fs::directory_iterator(out, failed);
  if (failed) return;  // no folder, or one that cannot be read, as those say who read it
  OutputFolder folder(out, Unmade{});
  try {
    folder.files_ = std::make_unique<FolderFiles>(out);
    const auto is_interrupted = [&](const fs::path& work) {
      return Publication::interrupted(*folder.files_, work).has_value();
    };
    if (std::ranges::none_of(work_folders(out), is_interrupted)) return;
    folder.lock_ = std::make_unique<FolderLock>(out);
    folder.repair();
  } catch (const fs::filesystem_error& e) {
    throw OutputError(out, "cannot be written: " + e.code().message());
  }
}

OutputFolder::~OutputFolder() { discard(); }

void OutputFolder::discard() noexcept {
  if (!work_.empty()) {
    // Threads that still write to files of the old name find no folder.
    const fs::path made = out_ / work_, moved = made.string() + "-removed";
    std::error_code failed;
    fs::rename(made, moved, failed);
    remove_tree(failed ? made : moved);
    work_.clear();
  }
  lock_.reset();
  std::error_code ignored;
  for (auto it = created_.rbegin(); it != created_.rend(); ++it) fs::remove(*it, ignored);  // only when empty
  created_.clear();
}

// Finishes what a killed run was publishing and removes what others left. Returns true if a result was finished.
bool OutputFolder::repair() {
  bool repaired = false;
  for (const fs::path& work : work_folders(out_)) {
    // Without locks it may be that of a run under way.
    if (lock_->held()) {
      if (const std::optional<Publication> publication = Publication::interrupted(*files_, work)) {
        finish(*publication, work);
        repaired = true;
      }
      remove_tree(out_ / work);
    } else if (Publication::interrupted(*files_, work)) {
      throw OutputError(out_ / work,
                        "holds files of a result that another run is publishing, or was when it was killed");
    }
  }
  return repaired;
}

// Where a file has come in the way, the earlier result is brought back, and the files of the new one stay in WORK.
void OutputFolder::finish(const Publication& publication, const fs::path& work) {
  try {
    publication.forward();
  } catch (const OutputError& error) {
    publication.undo();
    throw OutputError(out_ / work, fmt::format("holds the result of a run that was killed while it published it, which "
                                               "cannot be finished ({}); clear the way, or remove this folder",
                                               error.what()));
  }
  complete(publication);
}

// Of a whole result. While the publication is listed, the next run does this again.
void OutputFolder::complete(const Publication& publication) {
  io::WorkStore(checkpoints(), kCheckpointHashes).clear();
  publication.end();
}

void OutputFolder::create() {
  fs::path missing = fs::absolute(out_).lexically_normal();
  if (!missing.has_filename()) missing = missing.parent_path();
  for (; !fs::exists(missing) && missing.has_relative_path(); missing = missing.parent_path())
    created_.insert(created_.begin(), missing);
  if (fs::exists(out_) && !fs::is_directory(out_)) throw OutputError(out_, "exists and is not a folder");
  fs::create_directories(out_);
}

void OutputFolder::refuse_results_in_the_way(bool force, std::string_view command, bool repaired) {
  static_cast<void>(checkpoints());  // refuses a link now rather than when the result is published
  // Another command's result (a scene, a model) is likely to be the input of something.
  const EarlierResult earlier = earlier_result(out_);
  if (!earlier.command.empty() && earlier.command != command)
    throw OutputError(out_, fmt::format("holds the result of 'gpvc {}'", earlier.command), {Cure::other_folder});
  listed_ = earlier.files;
  if (!listed_.empty() && !force)
    throw OutputError(out_,
                      fmt::format("already holds a result ({}{})", *listed_.begin(),
                                  repaired ? ", which a killed run had begun to publish and is complete now" : ""),
                      {Cure::other_folder, Cure::replace_result});
  for (const std::string& name : listed_) refuse_link(name);
  for (const auto& entry : fs::directory_iterator(out_)) {
    const std::string name = entry.path().filename().string();
    if (is_written_by(command, name)) refuse_foreign_file(name);
  }
}

void OutputFolder::make_work_folder() {
  const fs::path made = make_folder_like(out_ / kUnfinished);
  work_ = made.filename();
  unfinished_ = made / "new";
  fs::create_directory(unfinished_);
  const io::OutputFile probe(unfinished_ / "probe");  // throws where no file can be made; removed at once
}

void OutputFolder::refuse_link(const std::string& name) const {
  if (const std::optional<fs::path> link = files_->link_on_the_way(name))
    throw OutputError(out_ / *link,
                      "is a symbolic link where a folder of the result is to be; remove it or choose another folder");
}

void OutputFolder::refuse_foreign_file(const std::string& name) const {
  refuse_link(name);
  const fs::path path = out_ / name;
  if (!fs::exists(fs::symlink_status(path))) return;
  if (!listed_.contains(fs::path(name).lexically_normal().generic_string()))
    throw OutputError(path, "would be replaced, and belongs to no earlier result", {Cure::other_folder});
  if (fs::is_directory(path)) throw OutputError(path, "is a folder where a file is to be", {Cure::other_folder});
}

void OutputFolder::protect(const std::set<fs::path>& inputs) {
  for (const fs::path& input : inputs) protected_.insert(fs::weakly_canonical(input));
  for (const std::string& name : listed_)
    if (protected_.contains(fs::weakly_canonical(out_ / name)))
      throw OutputError(out_ / name, "is read by this run and belongs to the result it would replace",
                        {Cure::other_folder});
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

double OutputFolder::space() const {
  std::error_code failed;
  const fs::space_info space = fs::space(out_, failed);
  return failed ? std::numeric_limits<double>::infinity() : static_cast<double>(space.available);
}

fs::path OutputFolder::checkpoints() const {
  fs::path folder = out_ / ".work";
  if (fs::is_symlink(folder))
    throw OutputError(folder, "is a symbolic link where this run's work is kept; remove it or choose another folder");
  return folder;
}

bool OutputFolder::has_checkpoints() const { return fs::exists(checkpoints()); }

void OutputFolder::expect_space(double least, double likely, Observer& observer) const {
  const double free = space();
  if (free >= likely) return;
  const std::string has = fmt::format("the disk has {} free", readable_bytes(free));
  if (free < least)
    throw OutputError(out_, fmt::format("{}, the result takes at least {}", has, readable_bytes(least)), {},
                      {{"free_bytes", free}, {"least_bytes", least}});
  observer.warning(fmt::format("{}: {}, and the result may take {}", out_.string(), has, readable_bytes(likely)));
}

void OutputFolder::promise_all() {
  promised_.clear();
  for (const auto& entry : fs::recursive_directory_iterator(unfinished_))
    if (entry.is_regular_file()) promised_.push_back(entry.path().lexically_relative(unfinished_).generic_string());
  std::sort(promised_.begin(), promised_.end());
}

std::string OutputFolder::promised_json() const { return outputs_json(promised_).dump(); }

void OutputFolder::start_over() {
  for (const fs::directory_entry& entry : fs::directory_iterator(unfinished_)) fs::remove_all(entry.path());
  promised_.clear();
}

void OutputFolder::publish() {
  for (const std::string& name : promised_) {
    if (!fs::is_regular_file(unfinished_ / name)) throw OutputError(out_ / name, "was not written");
    if (protected_.contains(fs::weakly_canonical(out_ / name)))
      throw OutputError(out_ / name, "is read by this run and would be replaced", {Cure::other_folder});
    refuse_foreign_file(name);
  }
  std::vector<std::string> replaced;
  std::copy_if(listed_.begin(), listed_.end(), std::back_inserter(replaced),
               [&](const std::string& name) { return files_->has(name); });
  const Publication publication(*files_, work_, std::move(replaced), promised_);
  publication.begin();
  try {
    publication.forward();
  } catch (const OutputError& e) {
    if (publication.undo()) {
      publication.end();
      throw;
    }
    const fs::path left = out_ / std::exchange(work_, {});  // the next run repairs it
    throw OutputError(e.what(), "files of the earlier result are in " + left.string());
  }
  complete(publication);
  created_.clear();
  discard();
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

std::vector<std::string> output_names(const nlohmann::ordered_json& list) {
  std::vector<std::string> names;
  if (!list.is_array()) return names;
  for (const auto& entry : list) {
    const std::optional<std::string> name = name_from_json(entry);
    if (!name) continue;
    try {
      names.push_back(contained_path(*name).generic_string());
    } catch (const OutputError&) {
      continue;
    }
  }
  return names;
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

}  // namespace gpvc::results
