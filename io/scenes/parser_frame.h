// The coordinates of nerfstudio's trainings, from bytes, for tests.
#pragma once

#include <filesystem>
#include <string_view>

#include "io/scene.h"

namespace gpvc::io {

/// A dataparser_transforms.json. Throws InputError.
SceneFrame parse_parser_frame(const std::filesystem::path& file, std::string_view text);

}  // namespace gpvc::io
