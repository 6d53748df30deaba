// Whether what a unit has left can be of its job. Files tell damage by a hash, which keeps nobody from writing other values.
#pragma once

#include <span>

#include "app/tiles/tile_mesh.h"
#include "app/tiles/tile_work.h"

namespace gpvc::tiles {

/// Options and cameras as they may be; views, groups and tiles that are there; a power of four of tiles, each level a quarter of
/// the one below.
bool is_sound(const Job& job);
/// Lists of fitting lengths; corners and tiles that are there; numbers that ascend; as many faces as the job knows of.
bool is_sound(const TileMesh& mesh, const Job& job, int level, std::uint32_t tile);
/// Of views that look at the tile in a group, each once, in their frames. \param scene at the tile's level
bool is_sound(std::span<const TileSight> sights, std::span<const ViewId> group, const TileInfo& tile, const Mesh& mesh,
              const Scene& scene);
/// \param faces of the tile with its border
bool is_sound(const TileCosts& costs, const Scene& scene, std::size_t faces);
bool is_sound(const labeling::PhotoJudgement& photos, const Scene& scene);
bool is_sound(std::span<const ViewTells> views, const Scene& scene);
bool is_sound(const atlas::SeamRatio& ratio, const Scene& scene);
/// Views of the scene, or none.
bool is_sound(std::span<const ViewId> labels, const Scene& scene);

}  // namespace gpvc::tiles
