// COLMAP's points3D as bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "io/scene.h"

namespace gpvc::io {

/// A point with its number and the numbers of the images in its track.
using TakeColmapPoint = std::function<void(std::uint64_t, const WorldPoint&, std::span<const std::uint32_t>)>;

/// Calls `take` for each point in the order of the file. The file is used in error messages only. Throws InputError.
/// O(bytes).
void parse_colmap_points(bool binary, const std::filesystem::path& file, std::string_view bytes,
                         const TakeColmapPoint& take);

/// Where an image shows a point: the numbers of both, and the place in pixels of the size that the model states.
using TakeColmapSighting = std::function<void(std::uint32_t image, std::uint64_t point, const PhotoPoint& at)>;

/// The same for each point of each image that belongs to one of the model's points, from images.bin or images.txt.
void parse_colmap_sightings(bool binary, const std::filesystem::path& file, std::string_view bytes,
                            const TakeColmapSighting& take);

}  // namespace gpvc::io
