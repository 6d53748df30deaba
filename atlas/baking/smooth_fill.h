// Smooth colours for unknown texels.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/baking/sampling.h"

namespace gpvc::atlas {

/// Push-pull (Gortler et al. 1996): fills the unknown texels of a row-major raster from the known ones, with detail
/// close to them and smoothly far away, and marks all as known. False if no texel is known. O(texels).
bool smooth_fill(std::vector<Color>& color, std::vector<std::uint8_t>& known, int width, int height);

}  // namespace gpvc::atlas
