// Pictures in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gpvc {

/// Of pixel (x, y) in a row-major raster.
inline std::size_t pixel_index(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

/// 8 bits a channel, row-major from the top-left, interleaved.
struct Image {
  int width = 0, height = 0, channels = 3;
  std::vector<std::uint8_t> pixels;  ///< width * height * channels

  const std::uint8_t* at(int x, int y) const {
    return pixels.data() + pixel_index(x, y, width) * static_cast<std::size_t>(channels);
  }
  std::uint8_t* at(int x, int y) { return const_cast<std::uint8_t*>(static_cast<const Image*>(this)->at(x, y)); }
};

}  // namespace gpvc
