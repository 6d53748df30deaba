// The options of orthophotos (app/pipeline/options.h).
#pragma once

#include <tuple>

#include "app/ortho/ortho_settings.h"
#include "app/pipeline/options.h"

namespace gpvc::io {
constexpr const auto& names_of(RasterCompression) { return kRasterCompressionNames; }
}  // namespace gpvc::io

namespace gpvc::ortho {

GPVC_MEMBERS(OrthoSettings, gsd, bounds, crs, up, compress, quality, tile_samples)

template <io::Like<OrthoSettings> T>
auto options_of(T& o) {
  using enum pipeline::Affects;
  return std::tuple(
      pipeline::number(
          o.gsd, "gsd", models, pipeline::kSize, "X", 1e-9, 1e9,
          "Edge of a pixel, in the unit of the orthophoto's coordinates (ground sampling distance). Without it that of "
          "a texel: half of the ground has finer ones"),
      pipeline::offered(
          o.bounds, "bounds", models, pipeline::kSize,
          "What the orthophoto shows, in its own coordinates; enlarged to multiples of the pixel size. Without it "
          "all that has a texture"),
      pipeline::offered(
          o.compress, "compress", models, pipeline::kOutput,
          "Compression of the orthophoto. deflate, lzw and zstd lose nothing; jpeg and webp are smaller. Heights "
          "and photo numbers always lose nothing"),
      pipeline::number(o.quality, "quality", models, pipeline::kOutput, "N", 1, 100,
                       "Quality of jpeg and webp, 1 to 100"),
      pipeline::text(
          o.crs, "crs", models, pipeline::kOutput, "CRS",
          "Reference system of the orthophoto (EPSG:25832, a WKT or PROJ string). Without it the one that the model's "
          "coordinates are in; the UTM zone where these are degrees or geocentric; and a transverse Mercator "
          "projection around the origin where they are east, north and up from a place"),
      pipeline::offered(
          o.up, "up", models, pipeline::kOutput,
          "Without a reference system: the axis of the scene that points up. auto: away from the cameras' mean "
          "viewing direction, and the axis next to that if it is within 5 degrees"),
      pipeline::hidden(o.tile_samples, "tile-samples", nothing, 64, 1 << 14));
}
static_assert(pipeline::kListsAll<OrthoSettings>);

}  // namespace gpvc::ortho
