// The settings of orthophotos.
#pragma once

#include <optional>
#include <string>

#include "io/raster.h"
#include "io/textured_model.h"

namespace gpvc::ortho {

/// In the orthophoto's coordinates.
struct Bounds {
  double west = 0, south = 0, east = 0, north = 0;
};

struct OrthoSettings {
  double gsd = 0;                  ///< edge of a pixel, in the orthophoto's unit; 0: of the median texel on the ground
  std::optional<Bounds> bounds{};  ///< what it shows; nullopt: all that has a texture
  std::string crs{};               ///< its reference system; empty: the surface's own, or the UTM zone around it
  std::optional<io::UpAxis> up{};  ///< of a surface without a reference system; nullopt: found from the cameras
  io::RasterCompression compress = io::RasterCompression::deflate;
  int quality = 90;         ///< of jpeg and webp
  int tile_samples = 1024;  ///< edge of what a thread draws at a time; pixels are the same for any
};

}  // namespace gpvc::ortho
