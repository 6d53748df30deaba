// What a scene format's reader hands to read_scene, which does what all formats share: photos on disk, order,
// reduction. Adding a format adds a file and a line in read_scene.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/scene.h"

namespace gpvc {

struct SceneFile {
  /// Names, cameras at full size and poses, in any order; photo paths are still empty.
  std::vector<View> views;
  /// The file that lists the images; named when something about them is wrong.
  std::filesystem::path listing;
  /// Where photos usually lie for this format, best guess first.
  std::vector<std::filesystem::path> image_folders;
};

/// nullopt when neither `source` nor its usual sub-folders hold a COLMAP model.
std::optional<SceneFile> read_colmap(const std::filesystem::path& source);

}  // namespace gpvc
