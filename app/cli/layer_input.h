// The photos of --layers.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/scene_input.h"
#include "app/pipeline/layers.h"
#include "io/photos.h"

namespace gpvc::cli {

/// A folder of photos that are called as the scene's.
struct LayerInput {
  std::string name;  ///< the folder's own
  Scene scene;       ///< with the cameras of the scene that is textured
};

/// Of each folder, with a note of its bands. Throws UsageError for two folders of one name, InputError where a used view's photo is
/// missing, damaged or of another size.
std::vector<LayerInput> read_layers(const std::vector<std::filesystem::path>& folders, const SceneInput& input,
                                    const SceneInputData& data, RunRecord& record);

}  // namespace gpvc::cli
