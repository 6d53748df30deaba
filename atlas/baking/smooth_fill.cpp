#include "atlas/baking/smooth_fill.h"

#include <algorithm>

namespace gpvc::atlas {

namespace {

struct Level {
  int width = 0, height = 0;
  std::vector<Color> color;
  std::vector<float> weight;
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(std::clamp(y, 0, height - 1)) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(std::clamp(x, 0, width - 1));
  }
};

/// Means over 2 x 2 cells. A cell's weight is at most 1, which a single known texel reaches.
Level push(const Level& fine) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  coarse.color.resize(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
  coarse.weight.resize(coarse.color.size());
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      ColorMean mean;
      for (int fy = 2 * y; fy < std::min(fine.height, 2 * y + 2); ++fy) {
        for (int fx = 2 * x; fx < std::min(fine.width, 2 * x + 2); ++fx) {
          const std::size_t i = fine.at(fx, fy);
          mean.add(fine.color[i], fine.weight[i]);
        }
      }
      coarse.color[coarse.at(x, y)] = mean.mean().value_or(Color{});
      coarse.weight[coarse.at(x, y)] = std::min(1.0f, mean.weight);
    }
  }
  return coarse;
}

/// Bilinear between the centres of the coarse level's cells.
Color interpolate(const Level& coarse, int x, int y) {
  const int nx = x / 2 + (x % 2 ? 1 : -1), ny = y / 2 + (y % 2 ? 1 : -1);
  const auto at = [&](int i, int j) { return coarse.color[coarse.at(i, j)]; };
  return 0.5625f * at(x / 2, y / 2) + 0.1875f * (at(nx, y / 2) + at(x / 2, ny)) + 0.0625f * at(nx, ny);
}

}  // namespace

bool smooth_fill(std::vector<Color>& color, std::vector<std::uint8_t>& known, int width, int height) {
  if (std::find(known.begin(), known.end(), 1) == known.end()) return false;
  if (std::find(known.begin(), known.end(), 0) == known.end()) return true;
  std::vector<Level> levels(1);
  levels[0] = {width, height, std::move(color), std::vector<float>(known.begin(), known.end())};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(push(levels.back()));
  for (std::size_t k = levels.size() - 1; k-- > 0;) {
    Level& fine = levels[k];
    for (int y = 0; y < fine.height; ++y) {
      for (int x = 0; x < fine.width; ++x) {
        const std::size_t i = fine.at(x, y);
        const float w = fine.weight[i];
        if (w < 1) fine.color[i] = w * fine.color[i] + (1 - w) * interpolate(levels[k + 1], x, y);
      }
    }
  }
  color = std::move(levels[0].color);
  std::fill(known.begin(), known.end(), std::uint8_t{1});
  return true;
}

}  // namespace gpvc::atlas
