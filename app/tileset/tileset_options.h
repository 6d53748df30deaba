// The options of tilesets (app/pipeline/options.h).
#pragma once

#include <tuple>

#include "../pipeline/options.h"
#include "tileset_settings.h"

namespace gpvc::tileset {

GPVC_MEMBERS(Place, latitude, longitude, height, heading)
GPVC_MEMBERS(TilesetSettings, faces_per_tile, compress, copyright, place)

template <io::Like<TilesetSettings> T>
auto options_of(T& o) {
  using enum pipeline::Affects;
  return std::tuple(
      pipeline::number(
          o.faces_per_tile, "tile-faces", views, pipeline::kSize, "N", 100, 1e8,
          "Faces of a tile of the finest level: as few tiles are made as have no more than N each, 100 or more"),
      pipeline::offered(o.compress, "compress", models, pipeline::kSize,
                        "Compress the geometry of GLBs without loss, for viewers that know EXT_meshopt_compression: "
                        "CesiumJS, three.js; for the web it is compressed in any case"),
      pipeline::offered(o.copyright, "copyright", models, pipeline::kOutput,
                        "Whose the tiles are, which viewers show: asset.copyright of tileset.json and of the GLBs"),
      pipeline::offered(o.place, "place", models, pipeline::kOutput,
                        "Put a scene without a reference system on the globe: its origin at this place (degrees, m "
                        "above the ellipsoid), its y axis towards HEADING (degrees from north to east), one unit a "
                        "metre"));
}
static_assert(pipeline::kListsAll<TilesetSettings>);

}  // namespace gpvc::tileset
