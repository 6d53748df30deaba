// Averages over cells of 2, 4 and 8 texels: cells that a face touches hold the colours of one chart only, and no cell
// holds an empty texel.
#include <gtest/gtest.h>

#include "atlas/charts/triangle_spans.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

/// The colour of a view's photo. No average of two of them equals a third.
Color color_of(std::size_t view) {
  return {view & 1 ? 250.0f : 10.0f, view & 2 ? 250.0f : 10.0f, view & 4 ? 250.0f : 10.0f};
}

/// Patches of many sizes on a plane, a colour for each view, and some unseen faces.
void patchwork(AtlasScene& s, unsigned seed) {
  s.add_plane(30, 24, 0.5);
  const auto cell = [&](double x, double y) {
    return static_cast<std::uint32_t>((7 * std::floor(x / 1.3) + 5 * std::floor(y / (0.6 + 0.2 * x)) + seed));
  };
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    s.labels[f] = ViewId{cell(p.x, p.y) % 8};
    if ((f * 2654435761u + seed) % 97 < 5) s.leave_unseen(f);
  }
  for (std::size_t v = 0; v < 8; ++v) {
    s.add_view(7.5, 6, 10, 500, 420, 243 + 7 * double(v));
    s.photograph(v, [v](double, double) { return color_of(v); });
  }
}

/// Texels of page p that faces of each view touch.
template <typename Visit>
void touched_texels(const TextureAtlas& atlas, const AtlasScene& s, const Visit& visit) {
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    if (s.labels[f] == kNoView) continue;
    const std::uint32_t p = atlas.model.face_page[f];
    const Image& page = atlas.pages[p];
    TexelTriangle t;
    for (std::size_t i = 0; i < 3; ++i) {
      const io::TexCoord c = atlas.model.texcoords[atlas.model.face_texcoords[f][i]];
      t[i] = {double(c.u) * page.width, double(c.v) * page.height};
    }
    // Texture coordinates are floats: 2^-24 of a page is less than a thousandth of a texel.
    triangle_spans(t, 0.499, {0, 0, page.width, page.height}, [&](int y, int first, int last) {
      for (int x = first; x <= last; ++x) visit(index(s.labels[f]), page, x, y);
    });
  }
}

TEST(Mips, CellsThatAFaceTouchesHoldItsChartAlone) {
  for (const int page_size : {512, 4096}) {
    AtlasScene s;
    patchwork(s, static_cast<unsigned>(page_size));
    AtlasOptions options;
    options.seams = SeamLeveling::none;
    options.page_size = page_size;
    const TextureAtlas atlas = s.build(options);
    EXPECT_GT(atlas.statistics.charts, 60u);
    for (const int cell : {2, 4, 8}) {
      std::size_t wrong = 0, cells = 0;
      touched_texels(atlas, s, [&](std::size_t view, const Image& page, int x, int y) {
        ASSERT_EQ(page.width % cell, 0);
        Color sum;
        for (int j = 0; j < cell; ++j)
          for (int i = 0; i < cell; ++i) sum = sum + load(page.at(x / cell * cell + i, y / cell * cell + j));
        const Color d = (1.0f / static_cast<float>(cell * cell)) * sum - color_of(view);
        wrong += std::abs(d.r) + std::abs(d.g) + std::abs(d.b) > 0.5f;
        ++cells;
      });
      EXPECT_EQ(wrong, 0u) << "of " << cells << " at 1/" << cell << ", pages of " << page_size;
    }
  }
}

/// Bilinear lookups within a face, as a renderer makes them, read one chart on levels 1 and 2. On level 3 a cell of
/// another chart has at most a quarter of the weight.
TEST(Mips, BilinearLookupsStayWithinTheChart) {
  AtlasScene s;
  patchwork(s, 3);
  AtlasOptions options;
  options.seams = SeamLeveling::none;
  const TextureAtlas atlas = s.build(options);
  for (const int cell : {2, 4, 8}) {
    std::vector<Image> level;
    for (const Image& page : atlas.pages) {
      Image small{page.width / cell, page.height / cell, 3, {}};
      small.pixels.resize(3 * static_cast<std::size_t>(small.width) * static_cast<std::size_t>(small.height));
      for (int y = 0; y < small.height; ++y) {
        for (int x = 0; x < small.width; ++x) {
          Color sum;
          for (int j = 0; j < cell; ++j)
            for (int i = 0; i < cell; ++i) sum = sum + load(page.at(x * cell + i, y * cell + j));
          store(small.at(x, y), (1.0f / static_cast<float>(cell * cell)) * sum);
        }
      }
      level.push_back(std::move(small));
    }
    float worst = 0;
    for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
      if (s.labels[f] == kNoView) continue;
      for (int i = 0; i <= 6; ++i) {
        for (int j = 0; i + j <= 6; ++j) {
          const Color c = lookup(level[atlas.model.face_page[f]], texcoord_at(atlas.model, f, i / 6.0, j / 6.0));
          const Color d = c - color_of(index(s.labels[f]));
          worst = std::max({worst, std::abs(d.r), std::abs(d.g), std::abs(d.b)});
        }
      }
    }
    // Colours differ by 240. At a corner of a cell the weights of both axes combine: at most 1 - (3/4)^2.
    EXPECT_LE(worst, cell < 8 ? 0.5f : 240 * 0.4376f) << "at 1/" << cell;
  }
}

/// All photos have one colour, so any other colour on a page would be background.
TEST(Mips, NothingOfAPageIsBackground) {
  AtlasScene s;
  patchwork(s, 5);
  for (std::size_t v = 0; v < 8; ++v) s.photograph(v, [](double, double) { return Color{200, 30, 30}; });
  for (const int padding : {1, 3, 8, 16}) {
    AtlasOptions options;
    options.padding = padding;
    const TextureAtlas atlas = s.build(options);
    for (const Image& page : atlas.pages)
      for (std::size_t i = 0; i < page.pixels.size(); i += 3)
        ASSERT_TRUE(page.pixels[i] == 200 && page.pixels[i + 1] == 30) << "texel " << i / 3 << ", " << padding;
    EXPECT_LT(atlas.statistics.chart_texels, atlas.statistics.padded_texels);
    EXPECT_LE(atlas.statistics.padded_texels, atlas.statistics.page_texels);
  }
}

}  // namespace
}  // namespace gpvc::atlas
