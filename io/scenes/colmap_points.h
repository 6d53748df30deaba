// COLMAP's points3D as bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "io/scene.h"

namespace gpvc::io {

/// Calls `take` for each point with the numbers of the images in its track, in the order of the file. The file is used in
/// error messages only. Throws InputError. O(bytes).
void parse_colmap_points(bool binary, const std::filesystem::path& file, std::string_view bytes,
                         const std::function<void(const WorldPoint&, std::span<const std::uint32_t>)>& take);

}  // namespace gpvc::io
