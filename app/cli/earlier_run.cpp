#include "app/cli/earlier_run.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "app/cli/command_options.h"
#include "app/cli/usage.h"
#include "app/evaluate/json.h"
#include "io/file_bytes.h"
#include "io/paths.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;
using evaluate::Json;

template <class Options>
bool parses(const std::vector<std::string>& words, CLI::App* (*add)(CLI::App&, Options&), Options& options) {
  if (words.size() < 2) return false;
  CLI::App app;
  add(app, options);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend() - 1));
  } catch (const CLI::ParseError&) {
    return false;
  }
  return true;
}

}  // namespace

std::vector<std::string> words_to_change(const EarlierRun& earlier, const fs::path& result, const fs::path& rules) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < earlier.words.size(); ++i) {
    const std::string& word = earlier.words[i];
    if (word == "--force" || word.starts_with("--from=") || word.starts_with("--allow=")) continue;
    if (word == "--from" || word == "--allow")
      ++i;  // its value
    else
      words.push_back(word);
  }
  words.insert(words.end(), {"--force", "--from", result.string()});
  if (!rules.empty()) words.insert(words.end(), {"--allow", rules.string()});
  return words;
}

std::optional<EarlierRun> earlier_run(const fs::path& result) {
  const fs::path file = result / "run.json";
  if (!io::is_file(file)) return std::nullopt;
  const Json json = Json::parse(io::FileBytes(file).view(), nullptr, false);
  if (!json.is_object() || !json.contains("command_line")) return std::nullopt;
  EarlierRun earlier;
  for (const Json& word : json["command_line"])
    if (word.is_string()) earlier.words.push_back(word.get<std::string>());
  const std::string command = json.value("command", "");
  if (command == "texture" && parses(earlier.words, add_texture, earlier.options)) {
    earlier.changes = true;
    return earlier;
  }
  if (TilesetOptions options; command == "tileset" && parses(earlier.words, add_tileset, options)) {
    earlier.options.input = options.input;
    earlier.options.settings = options.settings;
    return earlier;
  }
  if (CompareOptions options; command == "compare" && parses(earlier.words, add_compare, options)) {
    earlier.options.input = options.input;
    earlier.options.settings = options.settings.texture;
    return earlier;
  }
  return std::nullopt;
}

SceneInput scene_of(const ViewOptions& options, const EarlierRun& earlier) {
  // What is not given is as it was: reduced photos, masks, views.
  const SceneInput& given = options.input;
  SceneInput input = earlier.options.input;
  if (!given.scene.empty()) {
    input.scene = given.scene;
    input.mesh = given.mesh;
    input.more_meshes.clear();
    input.images_dir = given.images_dir;
  }
  if (given.images_dir) input.images_dir = given.images_dir;
  if (given.masks_dir) input.masks_dir = given.masks_dir;
  if (!given.masks) input.masks = false;
  if (!given.views.empty()) input.views = given.views;
  if (!given.exclude_views.empty()) input.exclude_views = given.exclude_views;
  if (given.downscale != 1) input.downscale = given.downscale;
  if (!given.mesh_crs.empty()) input.mesh_crs = given.mesh_crs;
  if (given.skip_bad_photos) input.skip_bad_photos = true;
  if (!given.bands.empty()) input.bands = given.bands;
  if (!given.bands_by_name) input.bands_by_name = false;
  if (!given.composite.empty()) input.composite = given.composite;
  return input;
}

bool has_files(const SceneInput& input) {
  std::error_code ignored;
  const auto there = [&](const fs::path& file) { return fs::exists(file, ignored); };
  return !input.scene.empty() && there(input.scene) && there(input.mesh) &&
         std::ranges::all_of(input.more_meshes, there) && (!input.images_dir || there(*input.images_dir));
}

std::vector<fs::path> results_of_comparison(const fs::path& folder) {
  std::vector<fs::path> results;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder / "modes", none))
    if (io::is_file(entry.path() / "model.obj")) results.push_back(entry.path());
  std::ranges::sort(results);
  return results;
}

}  // namespace gpvc::cli
