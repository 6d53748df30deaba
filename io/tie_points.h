// The points that photogrammetry found beside the cameras.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "scene.h"

namespace gpvc::io {

/// A surface point that was found in two photos or more.
struct TiePoint {
  WorldPoint position;  ///< in the scene's coordinates
  ViewId a{}, b{};      ///< two that show it: the first of its track, and the one seen from farthest apart
};

/// COLMAP's points3D.bin or .txt; nullopt for other formats and where it is missing.
std::optional<std::filesystem::path> tie_points_file(const Scene& scene);

/// Some of the scene's tie points, at most `most` and evenly from its file; none without one. Points of fewer than two of the
/// scene's views are left out. Throws InputError. O(bytes of the file).
std::vector<TiePoint> read_tie_points(const Scene& scene, std::size_t most);

/// Where a photo shows a tie point.
struct Sighting {
  ViewId view{};
  PhotoPoint at;     ///< in the view's photo, as its camera counts pixels
  WorldPoint point;  ///< in the scene's coordinates
};

/// Some of the places at which photos show the scene's tie points, at most `most` or one for each view, about as many of each.
/// Empty where the format states none (COLMAP's does). Throws InputError. O(bytes of the files).
std::vector<Sighting> read_sightings(const Scene& scene, std::size_t most);

}  // namespace gpvc::io
