// Limits on texels: there are fewer, each the mean of the pixels that it covers, and no limit aborts the program.
#include <gtest/gtest.h>

#include <set>

#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

/// Smooth waves, and in the blue channel stripes a pixel wide, which a reduction must average without aliasing.
Color stripes(double x, double y) {
  return {static_cast<float>(128 + 60 * std::sin(0.9 * x)), static_cast<float>(120 + 50 * std::cos(0.7 * y)),
          std::sin(2 * 3.141592653589793 * x / 0.04) > 0 ? 220.0f : 20.0f};
}

void plane_in_one_photo(AtlasScene& s) {
  s.add_plane(10, 8, 1.0);
  s.add_view(5, 4, 10, 640, 520, 500);  // 50 px a metre
  s.photograph(0, stripes);
}

AtlasOptions without_leveling() {
  AtlasOptions options;
  options.seams = SeamLeveling::none;
  return options;
}

std::size_t texels(const TextureAtlas& atlas) {
  std::size_t sum = 0;
  for (const Image& page : atlas.pages)
    sum += static_cast<std::size_t>(page.width) * static_cast<std::size_t>(page.height);
  return sum;
}

/// Mean of the albedo over a square of edge `size` around a point.
Color area_mean(double x, double y, double size) {
  constexpr int kTaps = 24;
  Color sum;
  for (int j = 0; j < kTaps; ++j)
    for (int i = 0; i < kTaps; ++i)
      sum = sum + stripes(x + ((i + 0.5) / kTaps - 0.5) * size, y + ((j + 0.5) / kTaps - 0.5) * size);
  return (1.0f / (kTaps * kTaps)) * sum;
}

TEST(Density, TexelSizeReducesChartsAndAverages) {
  AtlasScene s;
  plane_in_one_photo(s);
  AtlasOptions options = without_leveling();
  options.texel_size = 0.08;  // four pixels
  const TextureAtlas atlas = s.build(options);
  EXPECT_NEAR(static_cast<double>(atlas.statistics.chart_texels), 10 * 8 / (0.08 * 0.08), 900);
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) {
    for (const auto& [a, b] : {std::pair(0.3, 0.3), std::pair(0.5, 0.2), std::pair(0.2, 0.6)}) {
      const WorldPoint p = point_at(s.mesh, face, a, b);
      const Color got = lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, a, b));
      const Color d = got - area_mean(p.x, p.y, 0.16);  // a bilinear lookup covers two texels
      squares += double(d.r * d.r + d.g * d.g) / 2;
      // A texel is four stripes wide; a single sample in it would be 100 off.
      EXPECT_LT(std::abs(got.b - 120), 10) << face;
      ++count;
    }
  }
  EXPECT_GT(10 * std::log10(255 * 255 / (squares / static_cast<double>(count))), 40);
}

TEST(Density, TexelSizeCoarserThanThePhotoChangesNothing) {
  AtlasScene s;
  plane_in_one_photo(s);
  AtlasOptions options = without_leveling();
  const TextureAtlas plain = s.build(options);
  options.texel_size = 0.0199;
  const TextureAtlas limited = s.build(options);
  ASSERT_EQ(plain.pages.size(), limited.pages.size());
  EXPECT_EQ(plain.pages[0].pixels, limited.pages[0].pixels);
}

/// For texels of any size, the cost is bounded by the photo, and the colour is that of the chart, not of its
/// surroundings.
TEST(Density, TexelsLargerThanAChartHaveTheColorOfTheChart) {
  AtlasScene s;
  s.add_plane(4, 4, 1.0);
  View& view = s.add_view(0, 0, 10, 640, 520, 500);  // 50 px a metre
  view.camera.distortion = {-0.05, 0.01, 0, 0, 0};
  limit_distortion(view.camera);
  s.photograph(0, [](double x, double y) {
    return x > 0 && y > 0 && x < 4 && y < 4 ? Color{200, 40, 10} : Color{0, 0, 255};
  });
  AtlasOptions options = without_leveling();
  for (const double pixels : {400.0, 2000.0, 1e6, 1e11, 5e300}) {
    options.texel_size = pixels / 50;
    const TextureAtlas atlas = s.build(options);
    EXPECT_LE(atlas.statistics.chart_texels, 4u);
    for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) {
      const Color c = lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, 0.3, 0.3));
      EXPECT_NEAR(c.r, 200, 10) << pixels;
      EXPECT_NEAR(c.b, 10, 12) << pixels;
    }
  }
}

/// Texels of just under and just over sixteen pixels are averaged in different ways.
TEST(Density, CoarseTexelsContinueWhatFinerOnesShow) {
  AtlasScene s;
  plane_in_one_photo(s);
  AtlasOptions options = without_leveling();
  for (const double pixels : {16.0, 17.5, 64.0}) {
    options.texel_size = pixels / 50;
    const TextureAtlas atlas = s.build(options);
    for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) {
      const WorldPoint p = point_at(s.mesh, face, 0.3, 0.3);
      const Color d = lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, 0.3, 0.3)) -
                      area_mean(p.x, p.y, 2 * options.texel_size);
      EXPECT_LT(std::abs(d.r) + std::abs(d.g), pixels < 20 ? 8 : 50) << pixels << " " << face;
    }
  }
}

TEST(Density, MaxTexelsIsMetAndNearlyUsed) {
  AtlasScene s;
  plane_in_one_photo(s);
  for (const std::size_t limit : {std::size_t{100000}, std::size_t{20000}, std::size_t{5000}}) {
    AtlasOptions options = without_leveling();
    options.max_texels = limit;
    const TextureAtlas atlas = s.build(options);
    EXPECT_LE(texels(atlas), limit);
    EXPECT_GE(texels(atlas), 0.7 * static_cast<double>(limit));
    EXPECT_LT(atlas.statistics.reduction, 1);
    EXPECT_EQ(atlas.statistics.page_texels, texels(atlas));
  }
}

TEST(Density, MaxPagesIsMet) {
  AtlasScene s;
  plane_in_one_photo(s);
  AtlasOptions options = without_leveling();
  options.page_size = 256;
  const std::size_t unlimited = s.build(options).pages.size();
  EXPECT_GE(unlimited, 4u);
  options.max_pages = 2;
  const TextureAtlas atlas = s.build(options);
  EXPECT_LE(atlas.pages.size(), 2u);
  EXPECT_GE(texels(atlas), std::size_t{256 * 256});
}

TEST(Density, LimitsThatNothingMeetsAreAnError) {
  AtlasScene s;
  s.add_plane(30, 30, 1.0);
  s.labels.assign(s.labels.size(), kNoView);
  s.tags.assign(s.tags.size(), labeling::FaceTag::unseen);
  AtlasOptions options = without_leveling();
  options.max_texels = 4096;  // 1800 faces of 4 texels each
  try {
    s.build(options);
    FAIL() << "no error";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("4096 texels"), std::string::npos) << e.what();
  }
}

TEST(Density, ThePlanTellsWhatPagesTake) {
  AtlasScene s;
  plane_in_one_photo(s);
  s.graph = labeling::face_graph(s.mesh);
  s.candidates.first.assign(s.mesh.faces.size() + 1, 0);
  io::PhotoCache photos(s.scene, std::size_t{1} << 28);
  const AtlasInput input{s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage};
  AtlasOptions options = without_leveling();
  options.page_size = 300;
  const AtlasPlan plan = plan_atlas(input, options);
  const TextureAtlas atlas = bake_atlas(plan, input, nullptr);
  EXPECT_EQ(plan.estimate().pages, atlas.pages.size());
  EXPECT_EQ(plan.estimate().page_texels, texels(atlas));
  EXPECT_EQ(plan.estimate().charts, atlas.statistics.charts);
}

TEST(Density, UnseenFacesTakeTheColorAskedFor) {
  AtlasScene s;
  plane_in_one_photo(s);
  for (std::size_t f = 40; f < 60; ++f) s.leave_unseen(f);
  AtlasOptions options = without_leveling();
  options.unseen = UnseenFaces::color;
  options.unseen_color = {255, 0, 200};
  const TextureAtlas atlas = s.build(options);
  for (std::size_t f = 40; f < 60; ++f) {
    for (const auto& [a, b] : {std::pair(1.0, 0.0), std::pair(0.0, 1.0), std::pair(0.3, 0.3)}) {
      const Color c = lookup(atlas.pages[atlas.model.face_page[f]], texcoord_at(atlas.model, f, a, b));
      // Texture coordinates are floats: an error of 2^-24 of the page is a few millionths of a texel.
      EXPECT_NEAR(c.r, 255, 0.01);
      EXPECT_NEAR(c.g, 0, 0.01);
      EXPECT_NEAR(c.b, 200, 0.01);
    }
  }
}

}  // namespace
}  // namespace gpvc::atlas
