// Whether a projection contains a pixel centre anywhere on the unbounded grid.
#pragma once

#include "visibility/raster/raster.h"

namespace gpvc::visibility {

/// Exact, for front and back faces, not for edge-on ones. True for faces that cross the camera plane, whose projection
/// is unbounded and wider than a line, and for those that reach further than kFarthestCentre from the origin. O(log
/// size).
bool covers_a_pixel(const RasterFace& face);

/// Pixels. Faces reach this far when a corner lies within millimetres of the camera plane.
inline constexpr double kFarthestCentre = 0x1p24 + 1;

}  // namespace gpvc::visibility
