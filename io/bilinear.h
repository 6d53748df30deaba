// Bilinear lookup in pictures.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "image.h"

namespace gpvc {

using Rgb = std::array<double, 3>;

/// The first three channels at a position in pixels, whose centres are at halves, of a picture of a size whose pixels
/// pixel(x, y) gives, as something with three channels; clamped to the outermost centres. T: the type to compute in.
template <typename T, typename Pixel>
std::array<T, 3> bilinear_of(int width, int height, double x, double y, const Pixel& pixel) {
  const double u = std::clamp(x - 0.5, 0.0, width - 1.0), v = std::clamp(y - 0.5, 0.0, height - 1.0);
  const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
  const int x1 = std::min(x0 + 1, width - 1), y1 = std::min(y0 + 1, height - 1);
  const T fx = static_cast<T>(u - x0), fy = static_cast<T>(v - y0);
  const auto a = pixel(x0, y0), b = pixel(x1, y0), c = pixel(x0, y1), d = pixel(x1, y1);
  std::array<T, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const T top = T(a[i]) * (1 - fx) + T(b[i]) * fx, bottom = T(c[i]) * (1 - fx) + T(d[i]) * fx;
    color[i] = top * (1 - fy) + bottom * fy;
  }
  return color;
}

/// A texture coordinate of a face that reaches beyond its page, 0 .. 1, where textures repeat.
inline double repeated(double coordinate) {
  return coordinate >= 0 && coordinate <= 1 ? coordinate : coordinate - std::floor(coordinate);
}

template <typename T = double>
std::array<T, 3> bilinear(const Image& image, double x, double y) {
  return bilinear_of<T>(image.width, image.height, x, y,
                        [&](int column, int row) -> const std::uint8_t* { return image.at(column, row); });
}

}  // namespace gpvc
