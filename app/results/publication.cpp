#include "app/results/publication.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "app/results/output_names.h"
#include "io/output_file.h"

namespace gpvc::results {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "publishing.json";

}  // namespace

Publication::Publication(const FolderFiles& out, fs::path work, std::vector<std::string> replaced,
                         std::vector<std::string> promised)
    : out_(&out), work_(std::move(work)), replaced_(std::move(replaced)), promised_(std::move(promised)) {}

std::optional<Publication> Publication::interrupted(const FolderFiles& out, const fs::path& work) {
  if (!out.has(work / kJournal)) return std::nullopt;
  const fs::path file = out.path() / work / kJournal;
  std::ifstream in(file);
  const auto json = nlohmann::ordered_json::parse(in, nullptr, false);
  const auto list = [&](const char* key) { return json.is_object() && json.contains(key) ? json[key] : nullptr; };
  if (!list("replaced").is_array() || !list("promised").is_array())
    throw OutputError(file,
                      "lists the files of a result that a killed run was publishing, and cannot be read; move the "
                      "files in its folder where they belong and remove it");
  return Publication(out, work, output_names(list("replaced")), output_names(list("promised")));
}

void Publication::begin() const {
  const nlohmann::ordered_json json{{"replaced", outputs_json(replaced_)}, {"promised", outputs_json(promised_)}};
  io::write_file(out_->path() / work_ / kJournal, json.dump(1));
}

void Publication::move(const fs::path& from, const fs::path& to, const std::string& name) const {
  try {
    out_->move(from, to);
  } catch (const fs::filesystem_error& error) {
    throw OutputError(out_->path() / name, error.code().message());
  }
}

void Publication::forward() const {
  for (const std::string& name : replaced_) {
    if (!out_->has(name) || out_->has(earlier(name))) continue;
    move(name, earlier(name), name);
    out_->remove_empty_parents(name);
  }
  for (const std::string& name : promised_)
    if (out_->has(fresh(name))) move(fresh(name), name, name);
  out_->flush();
}

bool Publication::undo() const {
  bool all_back = true;
  const auto back = [&](const fs::path& from, const fs::path& to) {
    try {
      out_->move(from, to);
      out_->remove_empty_parents(from);
    } catch (const std::exception&) {
      all_back = false;
    }
  };
  for (auto name = promised_.rbegin(); name != promised_.rend(); ++name)
    if (!out_->has(fresh(*name)) && out_->has(*name)) back(*name, fresh(*name));
  for (auto name = replaced_.rbegin(); name != replaced_.rend(); ++name)
    if (out_->has(earlier(*name))) back(earlier(*name), *name);
  return all_back;
}

void Publication::end() const {
  const fs::path file = out_->path() / work_ / kJournal;
  std::error_code failed;
  fs::remove(file, failed);
  if (failed) throw OutputError(file, "cannot be removed: " + failed.message());
}

}  // namespace gpvc::results
