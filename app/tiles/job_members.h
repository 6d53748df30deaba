// The members of a job's structs, for its files (io/members.h), and its options.
#pragma once

#include <tuple>

#include "app/pipeline/options.h"
#include "app/pipeline/stored.h"
#include "app/tiles/job.h"
#include "app/tiles/tile_mesh.h"
#include "app/tileset/tileset_options.h"

namespace gpvc::io {
GPVC_MEMBERS(TiePoint, position, a, b)
}  // namespace gpvc::io

namespace gpvc {
GPVC_MEMBERS(Box, low, high)
}  // namespace gpvc

namespace gpvc::tiles {
GPVC_MEMBERS(JobSettings, texture, tiles, views_per_unit, levels)

template <io::Like<JobSettings> T>
auto options_of(T& o) {
  using enum pipeline::Affects;
  return std::tuple_cat(options_of(o.texture), options_of(o.tiles),
                        std::tuple(pipeline::number(o.views_per_unit, "unit-views", views, pipeline::kSize, "N", 1,
                                                    10000, "Most photos that one unit looks at"),
                                   pipeline::offered(o.levels, "levels", models, pipeline::kSize,
                                                     "Make no levels of detail above that of the mesh")));
}
static_assert(pipeline::kListsAll<JobSettings, pipeline::Settings, tileset::TilesetSettings>);

GPVC_MEMBERS(TileInfo, box, own_box, faces, all_faces, vertices, views, beside, around, color, pairs, texels)
GPVC_MEMBERS(Level, tiles, reduction, texel_size)
GPVC_MEMBERS(Job, settings, scene, mesh_file, views, tie_points, listed, model, tiles_model, color_profile, levels,
             groups)
GPVC_MEMBERS(TileMesh, mesh, face, vertex, tile, place)
GPVC_MEMBERS(CoarseTile, tile, error)
}  // namespace gpvc::tiles
