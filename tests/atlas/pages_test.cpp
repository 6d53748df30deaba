// Padding of charts on pages.
#include "atlas/baking/pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace gpvc::atlas {
namespace {

struct Padded {
  Image image;
  std::vector<TexelState> state;
  std::size_t count = 0;
};

/// pad_charts() by its definition: all texels are looked at for each layer.
Padded padded_slowly(Page page, int padding) {
  std::size_t count = 0;
  for (int round = 0;; ++round) {
    const std::vector<TexelState> before = page.state;
    const Image colors = page.image;
    std::size_t layer = 0;
    for (int y = 0; y < page.image.height; ++y)
      for (int x = 0; x < page.image.width; ++x) {
        const TexelState own = before[page.at(x, y)];
        const std::uint32_t owner = page.owner(x, y);
        ColorMean mean;
        bool beside = round == 0 && own == TexelState::ring;
        for (int near_y = std::max(0, y - 1); near_y <= std::min(y + 1, page.image.height - 1); ++near_y)
          for (int near_x = std::max(0, x - 1); near_x <= std::min(x + 1, page.image.width - 1); ++near_x) {
            const TexelState state = before[page.at(near_x, near_y)];
            if (state == TexelState::empty || (owner != kNoOwner && owner != page.owner(near_x, near_y))) continue;
            mean.add(load(colors.at(near_x, near_y)), near_x != x && near_y != y ? 0.5f : 1.0f);
            beside |= own == TexelState::empty && state == (round == 0 ? TexelState::chart : TexelState::padding);
          }
        if (!beside || (round > 0 && round >= padding && owner == kNoOwner)) continue;
        ++layer;
        page.state[page.at(x, y)] = TexelState::padding;
        if (own == TexelState::empty) store(page.image.at(x, y), *mean.mean());
      }
    if (layer == 0) return {page.image, page.state, count};
    if (round < padding) count += layer;
  }
}

/// Charts of random parts of their blocks, some with rings, on a page with free blocks.
Page random_page(int edge, unsigned seed) {
  std::mt19937 random(seed);
  Page page({8, 5}, edge, nullptr);
  page.open();
  for (std::uint32_t& owner : page.block_owner) owner = random() % 3 == 0 ? kNoOwner : random() % 4;
  for (int y = 0; y < page.image.height; ++y)
    for (int x = 0, left = 0; x < page.image.width; ++x, --left) {
      if (left <= 0) left = static_cast<int>(random() % 40);
      const bool chart = left > 12 && page.owner(x, y) != kNoOwner;
      if (!chart) continue;
      const Color color{static_cast<float>(random() % 256), static_cast<float>(random() % 256), 7};
      page.put(x, y, {&color, 1}, random() % 5 == 0 ? TexelState::ring : TexelState::chart);
    }
  return page;
}

TEST(PadCharts, GrowsByLayersOfMeans) {
  for (const int padding : {0, 1, 2, 5, 8})
    for (unsigned seed = 0; seed < 4; ++seed) {
      Page page = random_page(std::min(8, std::max(1, padding & ~1)), seed);
      const Padded expected = padded_slowly(page, padding);
      EXPECT_EQ(pad_charts(page, padding), expected.count);
      EXPECT_EQ(page.state, expected.state) << padding << ", " << seed;
      EXPECT_EQ(page.image.pixels, expected.image.pixels) << padding << ", " << seed;
    }
}

}  // namespace
}  // namespace gpvc::atlas
