#include "io/push_pull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

namespace gpvc::io {
namespace {

/// The mean of a block of 2^level x 2^level pixels as fill_holes() defines it; false if none of its pixels is known.
bool block_mean(const Image& image, const std::vector<std::uint8_t>& known, int level, int x, int y,
                std::array<int, 3>& mean) {
  if (x << level >= image.width || y << level >= image.height) return false;
  if (level == 0) {
    std::copy_n(image.at(x, y), 3, mean.begin());
    return known[pixel_index(x, y, image.width)] != 0;
  }
  std::array<int, 3> sum{};
  int count = 0;
  for (int part = 0; part < 4; ++part) {
    std::array<int, 3> color{};
    if (!block_mean(image, known, level - 1, 2 * x + part % 2, 2 * y + part / 2, color)) continue;
    ++count;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += color[c];
  }
  for (std::size_t c = 0; c < 3 && count > 0; ++c) mean[c] = (sum[c] + count / 2) / count;
  return count > 0;
}

// Runs of known and unknown pixels of all lengths: rows are looked at in words.
TEST(FillHoles, TakesTheMeanOfTheSmallestBlockWithAKnownPixel) {
  std::mt19937 random(7);
  for (const auto& [width, height] : {std::pair(1, 1), {1, 9}, {7, 3}, {16, 16}, {33, 20}, {64, 17}, {90, 41}})
    for (const unsigned run : {1u, 5u, 40u, 4000u}) {
      Image image{width, height, 3, {}};
      std::vector<std::uint8_t> known;
      for (std::uint8_t value = 1; known.size() < pixel_index(0, height, width);) {
        value = value == 0 ? static_cast<std::uint8_t>(1 + random() % 3) : std::uint8_t{0};
        known.insert(known.end(), 1 + random() % run, value);
      }
      known.resize(pixel_index(0, height, width));
      for (std::size_t i = 0; i < 3 * known.size(); ++i) image.pixels.push_back(static_cast<std::uint8_t>(random()));
      Image expected = image;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          std::array<int, 3> mean{};
          int level = 0;
          while (level < 8 && !block_mean(image, known, level, x >> level, y >> level, mean)) ++level;
          if (level > 0 && level < 8)
            std::ranges::transform(mean, expected.at(x, y), [](int value) { return static_cast<std::uint8_t>(value); });
        }
      for (const bool parallel : {false, true}) {
        Image filled = image;
        fill_holes(filled, known, parallel);
        EXPECT_EQ(filled.pixels, expected.pixels) << width << " x " << height << ", runs of " << run;
      }
    }
}

}  // namespace
}  // namespace gpvc::io
