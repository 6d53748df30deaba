// COLMAP's two files as bytes.
#pragma once

#include "io/scenes/scene_file.h"

namespace gpvc::io {

/// The files are used in error messages only. Throws InputError.
SceneFile parse_colmap(bool binary, const std::filesystem::path& cameras_file, std::string_view cameras_bytes,
                       const std::filesystem::path& images_file, std::string_view images_bytes);

}  // namespace gpvc::io
