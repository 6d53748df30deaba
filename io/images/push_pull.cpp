#include "io/push_pull.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "io/images/image_file.h"

namespace gpvc::io {
namespace {

/// A picture of which only some pixels are known.
struct Level {
  Image image;
  std::vector<std::uint8_t> known;
};

template <class Row>
void for_rows(int height, bool parallel, const Row& row) {
  if (parallel)
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
      for (int y = rows.begin(); y < rows.end(); ++y) row(y);
    });
  else
    for (int y = 0; y < height; ++y) row(y);
}

std::size_t pixel_index(const Image& image, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
}

/// Blocks of 2 x 2 pixels, smaller at the right and lower edge: the mean of their known pixels, rounded to nearest.
Level halved(const Image& image, const std::vector<std::uint8_t>& known, bool parallel) {
  Level half{black_image((image.width + 1) / 2, (image.height + 1) / 2, 3), {}};
  half.known.resize(half.image.pixels.size() / 3);
  for_rows(half.image.height, parallel, [&](int y) {
    for (int x = 0; x < half.image.width; ++x) {
      std::array<unsigned, 3> sum{};
      unsigned count = 0;
      for (int fine_y = 2 * y; fine_y < std::min(2 * y + 2, image.height); ++fine_y)
        for (int fine_x = 2 * x; fine_x < std::min(2 * x + 2, image.width); ++fine_x) {
          if (known[pixel_index(image, fine_x, fine_y)] == 0) continue;
          ++count;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += image.at(fine_x, fine_y)[c];
        }
      if (count == 0) continue;
      half.known[pixel_index(half.image, x, y)] = 1;
      for (std::size_t c = 0; c < 3; ++c)
        half.image.at(x, y)[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
    }
  });
  return half;
}

}  // namespace

void fill_holes(Image& image, const std::vector<std::uint8_t>& known, bool parallel) {
  const auto has = [&](std::uint8_t value) { return std::find(known.begin(), known.end(), value) != known.end(); };
  if (!has(0) || !has(1)) return;
  Level half = halved(image, known, parallel);
  fill_holes(half.image, half.known, parallel);
  for_rows(image.height, parallel, [&](int y) {
    for (int x = 0; x < image.width; ++x)
      if (known[pixel_index(image, x, y)] == 0) std::copy_n(half.image.at(x / 2, y / 2), 3, image.at(x, y));
  });
}

}  // namespace gpvc::io
