// Gradient magnitude of a photo.
#pragma once

#include <cstdint>
#include <vector>

#include "io/io.h"

namespace gpvc::labeling {

/// Per pixel, row-major: |gradient| of luma in 1/kGradientUnit grey levels a pixel (Sobel's kernel, whose weights sum
/// to 8), rounded; at the border the outermost pixels are repeated. O(pixels), TBB inside.
std::vector<std::uint16_t> gradient_magnitude(const Image& photo);

inline constexpr int kGradientUnit = 8;

}  // namespace gpvc::labeling
