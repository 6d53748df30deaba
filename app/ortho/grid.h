// The pixels of an orthophoto, and what lies in them.
#pragma once

#include "app/ortho/ortho_settings.h"
#include "app/ortho/surface.h"

namespace gpvc::ortho {

/// Rows run from north to south. A pixel has samples x samples samples, an odd number, so that one is its middle.
struct Grid {
  double west = 0, north = 0;  ///< outer corner of the first pixel: multiples of the pixel size
  double gsd = 1;              ///< edge of a pixel
  int width = 0, height = 0;   ///< pixels
  int samples = 3;

  double spacing() const { return gsd / samples; }
};

/// What pixels without a height have.
inline constexpr float kNoHeight = -9999;

/// The pixels that show what of a surface is textured, or those of the bounds. There are as many samples as nine tenths of the ground
/// have texels, five at least along an edge, so that a pixel is a mean over its area and outlines lie within a tenth of a pixel. \pre
/// the surface's positions are the orthophoto's. Throws InputError where the bounds lie beside the surface, and for more pixels than
/// a raster can have. O(faces).
Grid grid_of(const Surface& surface, const PageStore& pages, const OrthoSettings& settings);

}  // namespace gpvc::ortho
