// Whether what a unit has left can be of its job. Files tell damage by a hash, which keeps nobody from writing other values.
#pragma once

#include <span>

#include "app/tiles/tile_mesh.h"
#include "app/tiles/tile_work.h"

namespace gpvc::tiles {

/// Views, groups and tiles that are there; each level a quarter of the tiles of the one below.
bool is_sound(const Job& job);
/// Lists of fitting lengths; corners and tiles that are there; numbers that ascend. \param tiles of its level
bool is_sound(const TileMesh& tile, std::size_t tiles);
/// Of a view of the scene, in its frame. \param faces of the tile with its border
bool is_sound(const TileSight& seen, const Scene& scene, std::size_t faces);
bool is_sound(const TileCosts& costs, const Scene& scene, std::size_t faces);
bool is_sound(const labeling::PhotoJudgement& photos, const Scene& scene);
bool is_sound(std::span<const ViewTells> views, const Scene& scene);
bool is_sound(const atlas::SeamRatio& ratio, const Scene& scene);
/// Views of the scene, or none.
bool is_sound(std::span<const ViewId> labels, const Scene& scene);

}  // namespace gpvc::tiles
