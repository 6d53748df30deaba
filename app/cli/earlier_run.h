// How a result was made, by its run.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/options.h"

namespace gpvc::cli {

struct EarlierRun {
  TextureOptions
      options;  ///< of its command line, with paths as they were given; of other commands the input and settings alone
  std::vector<std::string> words;  ///< of that
  bool changes = false;            ///< of gpvc texture: other commands' results cannot be changed
};

/// The command line that changes a result, from that which made it. \param rules empty: none
std::vector<std::string> words_to_change(const EarlierRun& earlier, const std::filesystem::path& result,
                                         const std::filesystem::path& rules);

/// Of a result of gpvc texture, tileset or compare; nullopt where the folder holds none, or one whose command line this version does not know.
std::optional<EarlierRun> earlier_run(const std::filesystem::path& result);

/// The scene, mesh and photos given, and what is not given as it was in the earlier run.
SceneInput scene_of(const ViewOptions& options, const EarlierRun& earlier);
/// True if scene, meshes and the folder of photos are there.
bool has_files(const SceneInput& input);

/// The models of a comparison that keeps them, by name.
std::vector<std::filesystem::path> results_of_comparison(const std::filesystem::path& folder);

}  // namespace gpvc::cli
