// Gradient magnitude of a photo.
#pragma once

#include <cstdint>
#include <vector>

#include "io/image.h"

namespace gpvc::labeling {

/// Per pixel, row-major: gradient magnitude of luma in 1/kGradientUnit grey levels a pixel, rounded (Sobel's kernel,
/// whose weights sum to 8; the outermost pixels are repeated beyond the border). O(pixels), TBB inside.
std::vector<std::uint16_t> gradient_magnitude(const Image& photo);

inline constexpr int kGradientUnit = 8;

}  // namespace gpvc::labeling
