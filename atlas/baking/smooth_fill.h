// Smooth colours where none is known.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/baking/sampling.h"

namespace gpvc::atlas {

/// Push-pull (Gortler et al. 1996): fills the texels of a row-major raster that are not known from those that are,
/// nearby ones sharply and distant ones smoothly, and marks all as known. False when none is. O(texels).
bool smooth_fill(std::vector<Color>& color, std::vector<std::uint8_t>& known, int width, int height);

}  // namespace gpvc::atlas
