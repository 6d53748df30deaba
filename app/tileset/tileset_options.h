// The options of tilesets (app/pipeline/options.h).
#pragma once

#include <tuple>

#include "../pipeline/options.h"
#include "tileset.h"

namespace gpvc::tileset {

GPVC_MEMBERS(TilesetSettings, faces_per_tile, compress)

template <io::Like<TilesetSettings> T>
auto options_of(T& o) {
  using enum pipeline::Affects;
  return std::tuple(
      pipeline::number(o.faces_per_tile, "tile-faces", views, pipeline::kSize, "N", 100, 1e8,
                       "Most faces of a tile, 100 or more"),
      pipeline::offered(o.compress, "compress", models, pipeline::kSize,
                        "Compress the geometry of GLBs without loss, for viewers that know EXT_meshopt_compression: "
                        "CesiumJS, three.js"));
}
static_assert(pipeline::kListsAll<TilesetSettings>);

}  // namespace gpvc::tileset
