// Whether what a unit has left can be of its job. Files tell damage by a hash, which keeps nobody from writing other values.
#pragma once

#include <span>

#include "app/tiles/tile_mesh.h"
#include "app/tiles/tile_work.h"

namespace gpvc::tiles {

/// True if options and cameras are in their ranges, views, groups and tiles that are named exist, the number of tiles is a power of
/// four, and each level has a quarter of those below.
bool is_sound(const Job& job);
/// True if the lengths of lists fit together, corners and tiles exist, numbers ascend, and it has as many faces as the job says.
bool is_sound(const TileMesh& mesh, const Job& job, int level, std::uint32_t tile);
/// True if they are of views of the group that look at the tile, each once, and lie in their frames. \param scene at the tile's
/// level
bool is_sound(std::span<const TileSight> sights, std::span<const ViewId> group, const TileInfo& tile, const Mesh& mesh,
              const Scene& scene);
/// \param faces how many the tile has with its border
bool is_sound(const TileCosts& costs, const Scene& scene, std::size_t faces);
bool is_sound(const labeling::PhotoJudgement& photos, const Scene& scene);
bool is_sound(std::span<const ViewTells> views, const Scene& scene);
bool is_sound(const atlas::ColorRatio& ratio, const Scene& scene);
/// True if each label is a view of the scene, or none.
bool is_sound(std::span<const ViewId> labels, const Scene& scene);

}  // namespace gpvc::tiles
