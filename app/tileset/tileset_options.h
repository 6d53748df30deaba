// The options of tilesets (app/pipeline/options.h).
#pragma once

#include <tuple>

#include "app/pipeline/options.h"
#include "app/tileset/tileset.h"

namespace gpvc::tileset {

GPVC_MEMBERS(TilesetSettings, faces_per_tile, compress)

inline constexpr const char* kTiles = "Tiles";

template <io::Like<TilesetSettings> T>
auto options_of(T& o) {
  using pipeline::Option, pipeline::Affects;
  return std::tuple(Option(o.faces_per_tile, {.name = "tile-faces",
                                              .affects = Affects::views,
                                              .group = kTiles,
                                              .kind = "N",
                                              .least = 100,
                                              .most = 1e8,
                                              .help = "Most faces of a tile, 100 or more"}),
                    Option(o.compress, {.name = "compress",
                                        .affects = Affects::models,
                                        .group = kTiles,
                                        .help = "Compress the geometry of GLBs without loss, for viewers that know "
                                                "EXT_meshopt_compression: CesiumJS, three.js"}));
}
static_assert(pipeline::kListsAll<TilesetSettings>);

}  // namespace gpvc::tileset
