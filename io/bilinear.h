// Bilinear lookup in pictures.
#pragma once

#include <algorithm>
#include <array>

#include "image.h"

namespace gpvc {

using Rgb = std::array<double, 3>;

/// The first three channels at a position in pixels, whose centres are at halves; clamped to the outermost centres. T:
/// the type to compute in.
template <typename T = double>
std::array<T, 3> bilinear(const Image& image, double x, double y) {
  const double u = std::clamp(x - 0.5, 0.0, image.width - 1.0), v = std::clamp(y - 0.5, 0.0, image.height - 1.0);
  const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
  const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const T fx = static_cast<T>(u - x0), fy = static_cast<T>(v - y0);
  const std::uint8_t *a = image.at(x0, y0), *b = image.at(x1, y0), *c = image.at(x0, y1), *d = image.at(x1, y1);
  std::array<T, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const T top = T(a[i]) * (1 - fx) + T(b[i]) * fx, bottom = T(c[i]) * (1 - fx) + T(d[i]) * fx;
    color[i] = top * (1 - fy) + bottom * fy;
  }
  return color;
}

}  // namespace gpvc
