#include <gtest/gtest.h>

#include <algorithm>

#include "atlas/blending/blend_weights.h"
#include "atlas/blending/coarse_photo.h"
#include "atlas/leveling/limit_offsets.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

/// A plane of 8 x 8 squares of a metre, seen whole by `views` cameras at a height of 10 m and at 64 pixels a metre, each a
/// few decimetres beside the one before. The first is the main view of every face.
struct BlendScene : AtlasScene {
  explicit BlendScene(std::size_t views) {
    add_plane(8, 8, 1.0);
    for (std::size_t v = 0; v < views; ++v) add_view(4 + 0.3 * static_cast<double>(v), 4, 10, 700, 640, 640);
    set_costs([](std::size_t, std::size_t) { return 0.0f; });
  }

  /// Gives every face all views as candidates.
  void set_costs(const std::function<float(std::size_t face, std::size_t view)>& cost) {
    candidates = {};
    candidates.first.push_back(0);
    for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
      for (std::uint32_t view = 0; view < scene.views.size(); ++view) {
        candidates.views.push_back(view);
        candidates.costs.push_back(cost(face, view));
      }
      candidates.first.push_back(candidates.views.size());
    }
  }

  /// Paints view v in one grey, plus `detail` by pixel.
  void paint(std::size_t v, float grey, const std::function<float(int x, int y)>& detail = nullptr) {
    photograph(
        v,
        [=](double, double) {
          return Color{grey, grey, grey};
        },
        [&](int x, int y, Color color) {
          const float d = detail ? detail(x, y) : 0;
          return color + Color{d, d, d};
        });
  }

  BlendWeights weights(double full_cost) {
    io::PhotoCache photos(scene, std::size_t{1} << 30);
    return BlendWeights({mesh, scene, photos, graph, labels, tags, candidates, coverage, border, exposure}, full_cost);
  }
};

AtlasOptions blended() {
  AtlasOptions options;
  options.seams = SeamLeveling::none;
  return options;
}

Color color_at(const TextureAtlas& atlas, std::size_t face, double a = 1.0 / 3, double b = 1.0 / 3) {
  return lookup(atlas.pages.at(atlas.model.face_page[face]), texcoord_at(atlas.model, face, a, b));
}

TEST(BlendWeights, FactorsOfAllViewsAddUpToNothing) {
  BlendScene s(3);
  s.set_costs(
      [](std::size_t face, std::size_t view) { return 0.001f * static_cast<float>((7 * face + 13 * view) % 40); });
  const BlendWeights weights = s.weights(0.1);
  for (std::uint32_t v = 0; v < s.mesh.positions.size(); ++v) {
    ASSERT_EQ(weights.at(v).size(), 3u);
    EXPECT_NEAR(weights.share(v, 0, 0).factor + weights.share(v, 1, 0).factor + weights.share(v, 2, 0).factor, 0, 1e-6);
    EXPECT_LT(weights.share(v, 0, 0).factor, 0);
    EXPECT_GT(weights.share(v, 1, 0).factor, 0);
  }
}

TEST(BlendWeights, ViewWeighsAtAVertexWhatItWeighsInTheWorstFaceAround) {
  BlendScene s(2);
  const std::size_t bad = 60;
  s.set_costs([&](std::size_t face, std::size_t view) { return view == 1 && face == bad ? 0.075f : 0.0f; });
  const BlendWeights weights = s.weights(0.1);
  for (std::uint32_t v = 0; v < s.mesh.positions.size(); ++v) {
    const auto& corners = s.mesh.faces[bad];
    const bool touched = std::ranges::find(corners, v) != corners.end();
    ASSERT_EQ(weights.at(v).size(), 2u);
    EXPECT_NEAR(weights.weight(v, weights.at(v)[1]), touched ? 0.25 : 1.0, 1e-6) << v;
  }
}

TEST(BlendWeights, VerticesOfFacesThatAreNotSeenWholeBlendNothing) {
  BlendScene s(2);
  s.tags[40] = labeling::FaceTag::partial;
  s.leave_unseen(90);
  const BlendWeights weights = s.weights(0.1);
  for (const std::size_t face : {std::size_t{40}, std::size_t{90}})
    for (const std::uint32_t v : s.mesh.faces[face]) {
      EXPECT_TRUE(weights.at(v).empty());
      EXPECT_EQ(weights.share(v, 1, 0).factor, 0);
    }
  EXPECT_FALSE(weights.empty());
}

// The lens of view 1 is known up to 2 m around what lies below it. Faces that reach a little beyond may still be seen whole, as
// no pixel's centre lies there.
TEST(BlendWeights, ViewHasNoShareBeyondTheEndOfItsLens) {
  BlendScene s(2);
  s.scene.views[1].camera.distortion.k1 = -0.01;
  s.scene.views[1].camera.distortion.max_r2 = 0.2 * 0.2;
  const BlendWeights weights = s.weights(0.1);
  std::size_t shared = 0;
  for (std::uint32_t v = 0; v < s.mesh.positions.size(); ++v) {
    const WorldPoint& p = s.mesh.positions[v];
    const bool inside = std::hypot(p.x - 4.3, p.y - 4) <= 2;
    EXPECT_EQ(weights.at(v).size(), inside ? 2u : 0u) << p.x << " " << p.y;
    shared += inside ? 1 : 0;
  }
  EXPECT_GT(shared, 4u);
}

TEST(BlendWeights, MainViewThatFadesChangesNothing) {
  BlendScene s(2);
  s.set_costs([](std::size_t, std::size_t view) { return view == 0 ? 0.2f : 0.0f; });
  const BlendWeights weights = s.weights(0.1);
  for (std::uint32_t v = 0; v < s.mesh.positions.size(); ++v) EXPECT_EQ(weights.share(v, 1, 0).factor, 0);
}

// Also beyond the photo's borders, and with sums of other views.
TEST(CoarseRows, RowsAddBilinearMeansTimesTheFactor) {
  Image photo{40, 30, 3, std::vector<std::uint8_t>(40 * 30 * 3)};
  for (std::size_t i = 0; i < photo.pixels.size(); ++i) photo.pixels[i] = static_cast<std::uint8_t>(i * i % 251);
  const auto means = std::make_shared<const Image>(io::coarse_image(photo));
  const CoarseRows coarse(*means);
  const CoarsePhoto expected(means);
  const Color factor{0.5f, -0.7f, 1.2f}, change{0.01f, 0.02f, -0.05f};
  for (const PhotoPoint& first : {PhotoPoint{3.3, 28.9}, PhotoPoint{-4, -1.7}, PhotoPoint{31.2, 21.4}}) {
    const PhotoPoint step{1.3, -0.9};
    std::vector<ColorSum> sums(12, {100, -200, 300});
    coarse.add_row(first, step, {factor}, {change, {}}, sums);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const auto n = static_cast<float>(i);
      const Color color = expected.at({first.x + n * step.x, first.y + n * step.y});
      const Color added = kSumUnit * ((factor + n * change) * color);
      // Half a unit is from rounding.
      EXPECT_NEAR(sums[i][0], 100 + added.r, 0.51) << first.x << ' ' << i;
      EXPECT_NEAR(sums[i][1], -200 + added.g, 0.51) << first.x << ' ' << i;
      EXPECT_NEAR(sums[i][2], 300 + added.b, 0.51) << first.x << ' ' << i;
    }
  }
}

// Three photos of 90, 120 and 150: the main one moves by six tenths of its distance from the mean.
TEST(Blending, BrightnessMovesTowardsTheMeanOfTheViews) {
  BlendScene s(3);
  for (std::size_t v = 0; v < 3; ++v) s.paint(v, 90 + 30 * static_cast<float>(v));
  const TextureAtlas atlas = s.build(blended());
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face)
    for (const auto& [a, b] : {std::pair{1.0 / 3, 1.0 / 3}, {0.9, 0.05}, {0.0, 0.5}})
      EXPECT_NEAR(color_at(atlas, face, a, b).r, 90 + 0.6 * 30, 0.6) << face;

  AtlasOptions alone = blended();
  alone.blend = Blending::none;
  const TextureAtlas plain = s.build(alone);
  EXPECT_EQ(atlas.statistics.blended_faces, s.mesh.faces.size());
  EXPECT_EQ(plain.statistics.blended_faces, 0u);
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) EXPECT_EQ(color_at(plain, face).r, 90);
}

// A chequerboard of single pixels is finer than what is blended: all of it stays, and none of the other photo's comes in.
TEST(Blending, FineDetailIsThatOfOnePhoto) {
  BlendScene s(2);
  const auto chequers = [](int x, int y) { return (x + y) % 2 ? 40.0f : -40.0f; };
  s.paint(0, 100, chequers);
  s.paint(1, 140, [](int x, int y) { return (x + y) % 2 ? -60.0f : 60.0f; });
  AtlasOptions alone = blended();
  alone.blend = Blending::none;
  const TextureAtlas plain = s.build(alone), atlas = s.build(blended());
  ASSERT_EQ(plain.pages.size(), 1u);
  const Image &before = plain.pages[0], &after = atlas.pages[0];
  ASSERT_EQ(before.pixels.size(), after.pixels.size());
  // Away from the page's border every texel is raised by 0.6 x 20.
  for (int y = 20; y < before.height - 20; ++y)
    for (int x = 20; x < before.width - 20; ++x) ASSERT_NEAR(after.at(x, y)[0], before.at(x, y)[0] + 12, 1.5);
}

// Ramps that agree in the world, through lenses of their own: what is blended lies where it belongs.
TEST(Blending, ViewsThatAgreeChangeNothing) {
  BlendScene s(3);
  s.scene.views[1].camera.distortion = {-0.1, 0.02};
  s.scene.views[2].camera.distortion = {0.08, -0.01, 0.001, -0.001};
  for (View& view : s.scene.views) limit_distortion(view.camera);
  const auto ramp = [](double x, double y) {
    return Color{static_cast<float>(40 + 20 * x), static_cast<float>(200 - 15 * y),
                 static_cast<float>(60 + 8 * (x + y))};
  };
  for (std::size_t v = 0; v < 3; ++v) s.photograph(v, ramp);
  const TextureAtlas atlas = s.build(blended());
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) {
    const WorldPoint p = point_at(s.mesh, face, 0.5, 0.2);
    const Color truth = ramp(p.x, p.y), got = color_at(atlas, face, 0.5, 0.2);
    EXPECT_NEAR(got.r, truth.r, 1.5) << face;
    EXPECT_NEAR(got.g, truth.g, 1.5) << face;
  }
}

// Two large triangles of hundreds of texels, seen at a slant and through lenses: positions in other views follow the
// perspective, and what a lens bends.
TEST(Blending, LargeFacesSeenAtASlantStayInPlace) {
  for (const double k1 : {0.0, -0.12, 0.1}) {
    BlendScene s(1);
    s.mesh = {};
    s.labels.clear();
    s.tags.clear();
    s.add_plane(1, 1, 8.0);
    View& slanted = s.add_view(4, -3, 9, 900, 900, 640);
    const double c = std::cos(0.6), d = std::sin(0.6);
    slanted.pose.rotation = {1, 0, 0, 0, -c, -d, 0, d, -c};
    slanted.camera.distortion.k1 = k1;
    limit_distortion(slanted.camera);
    s.set_costs([](std::size_t, std::size_t) { return 0.0f; });
    const auto waves = [](double x, double y) {
      const float w = static_cast<float>(128 + 90 * std::sin(3 * x) * std::sin(3 * y));
      return Color{w, w, w};
    };
    for (std::size_t v = 0; v < 2; ++v) s.photograph(v, waves);
    const TextureAtlas atlas = s.build(blended());
    double worst = 0;
    for (std::size_t face = 0; face < 2; ++face)
      for (int i = 1; i < 20; ++i)
        for (int j = 1; i + j < 20; ++j) {
          const WorldPoint p = point_at(s.mesh, face, i / 20.0, j / 20.0);
          worst = std::max(worst, std::abs(double{color_at(atlas, face, i / 20.0, j / 20.0).r - waves(p.x, p.y).r}));
        }
    // A pixel of the slanted photo, 2 cm of a wave of at most 270 grey levels a metre; a shift of it would give 3.2 or more.
    EXPECT_LE(worst, 3) << k1;
  }
}

// The second photo is white. Its exposure would multiply it by 2.5 in the middle and by 250 at a corner of the plane, which
// is nine times what a sum holds.
TEST(Blending, WhiteThatIsExposedTenfoldIsBlendedAsWhite) {
  BlendScene s(2);
  s.paint(0, 100);
  s.paint(1, 255);
  s.exposure.resize(2);
  s.exposure[1] = {{2.5f, 2.5f, 2.5f}, 350, 350, 1 / (2 * 350.0 * 350), 8, 0};
  AtlasOptions options;
  options.seams = SeamLeveling::global;
  const TextureAtlas atlas = s.build(options);
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face)
    EXPECT_NEAR(color_at(atlas, face).r, 100 + 0.6 * (255 - 100) / 2, 1) << face;
}

// The seam is at x = 4; the left half shows view 0 and the right half view 1, which is brighter.
TEST(Blending, SeamsAreLeveledAsTheyAreBlended) {
  BlendScene s(2);
  s.paint(0, 100);
  s.paint(1, 130);
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face)
    s.labels[face] = ViewId{point_at(s.mesh, face, 1.0 / 3, 1.0 / 3).x < 4 ? 0u : 1u};
  s.exposure.resize(2);  // that of a camera whose exposure is fixed
  AtlasOptions options;
  options.seams = SeamLeveling::global;
  const TextureAtlas atlas = s.build(options);
  EXPECT_NEAR(atlas.statistics.seam_step_before, 30, 0.5);
  EXPECT_LE(atlas.statistics.seam_step_after, 2);
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) EXPECT_NEAR(color_at(atlas, face).r, 115, 7) << face;
}

/// What is left of an offset of a vertex in the middle.
float limited(BlendScene& s, float offset) {
  io::PhotoCache photos(s.scene, std::size_t{1} << 30);
  const AtlasInput input{s.mesh, s.scene,      photos,     s.graph,  s.labels,
                         s.tags, s.candidates, s.coverage, s.border, s.exposure};
  ColorCorrection correction;
  for (const Triangle& t : s.mesh.faces) correction.nodes.push_back(t);
  correction.offsets.assign(s.mesh.positions.size(), Color{offset, offset, offset});
  limit_offsets(find_added_ranges(input, BlendWeights(input, 0.1), correction), correction);
  return correction.offsets[4 * 9 + 4].g;
}

TEST(LimitOffsets, KeepColoursInTheRangeOfThePhotosThatAreBlended) {
  BlendScene s(3);
  s.paint(0, 100);
  s.paint(1, 100);
  s.paint(2, 120);
  // Blending makes 100 + 0.6 x 20 / 3 = 104 of it.
  EXPECT_NEAR(limited(s, 30), 120 + kOffsetTolerance - 104, 1);
  EXPECT_NEAR(limited(s, -30), 100 - kOffsetTolerance - 104, 1);
  EXPECT_EQ(limited(s, 10), 10);
  EXPECT_EQ(limited(s, -5), -5);
  s.set_costs([](std::size_t, std::size_t view) { return view == 0 ? 0.0f : 1.0f; });
  EXPECT_EQ(limited(s, 30), 30) << "one photo alone tells no range";
}

TEST(LimitStrips, LeaveTheRangeThatOffsetsDoNotTake) {
  // A strip of 20 grey levels along the left edge of one chart, a texel a decimetre: nodes there have taken 10 of 15 levels.
  BlendScene s(1);
  io::PhotoCache photos(s.scene, std::size_t{1} << 30);
  const AtlasInput input{s.mesh, s.scene,      photos,     s.graph,  s.labels,
                         s.tags, s.candidates, s.coverage, s.border, s.exposure};
  ChartSet set;
  Chart& chart = set.charts.emplace_back();
  chart.width = chart.height = 80;
  set.face_chart.assign(s.mesh.faces.size(), 0);
  ColorCorrection correction;
  for (const Triangle& t : s.mesh.faces) {
    correction.nodes.push_back(t);
    TexelTriangle& corners = set.corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) corners[k] = {10 * s.mesh.positions[t[k]].x, 10 * s.mesh.positions[t[k]].y};
  }
  std::vector<SeamStep> steps;
  for (int y = 0; y < 80; ++y) steps.push_back({0, static_cast<float>(y), 1, {20, 20, -20}});
  correction.strips.push_back(make_strip(chart, steps));
  correction.offsets.assign(s.mesh.positions.size(), {10, 0, 0});
  std::vector<AddedRange> ranges(s.mesh.positions.size(), {{-15, -15, -15}, {15, 30, 15}});
  limit_strips(ranges, input, set, correction);
  const Color strip = strip_offset(correction.strip(0), 0, 40);
  ASSERT_GT(strip.r, 15);
  for (std::uint32_t vertex = 0; vertex < s.mesh.positions.size(); ++vertex) {
    const WorldPoint& p = s.mesh.positions[vertex];
    const Color& share = correction.strip_shares[vertex];
    if (p.x > 2 || p.y < 3 || p.y > 5) continue;
    const Color here = strip_offset(correction.strip(0), 10 * p.x, 10 * p.y);
    EXPECT_NEAR(share.r * here.r, std::min(5.0f, here.r), 1e-3);
    EXPECT_EQ(share.g, 1);
    EXPECT_NEAR(share.b * here.b, std::max(-15.0f, here.b), 1e-3);
  }
  // Faces take it as their corners do.
  for (std::uint32_t face = 0; face < s.mesh.faces.size(); ++face) {
    const TexelTriangle& t = set.corners[face];
    for (std::size_t k = 0; k < 3; ++k) {
      const Color taken = correction.taken({1, 1, 1}, face, t, t[k].x, t[k].y);
      EXPECT_NEAR(taken.r, correction.strip_shares[s.mesh.faces[face][k]].r, 1e-5);
    }
    EXPECT_EQ(correction.limits_strip(face), std::ranges::any_of(s.mesh.faces[face], [&](std::uint32_t vertex) {
                return correction.strip_shares[vertex].r < 1 || correction.strip_shares[vertex].b < 1;
              }));
  }
}

// A half of what the photo shows, exposed by a gain that rises along the row, and held against highlights of single colours.
TEST(CoarseRows, CompressHighlightsAsTheMainPhotosAre) {
  Image photo{80, 8, 3, std::vector<std::uint8_t>(80 * 8 * 3)};
  for (std::size_t i = 0; i < photo.pixels.size(); ++i) photo.pixels[i] = static_cast<std::uint8_t>(i % 240 + 15);
  const auto means = std::make_shared<const Image>(io::coarse_image(photo));
  const CoarsePhoto at(means);
  const Color gain{0.9f, 1.1f, 1.0f}, change{0, 0.01f, 0.005f};
  std::vector<ColorSum> sums(38);
  CoarseRows(*means).add_row({2.5, 3}, {2, 0}, {0.5f * gain, gain}, {0.5f * change, change}, sums);
  std::size_t bright = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto n = static_cast<float>(i);
    const Color here = gain + n * change, exposed = here * at.at({2.5 + 2 * n, 3}),
                expected = corrected(exposed, {}, here);
    bright += exposed.g > expected.g + 1 ? 1 : 0;
    EXPECT_NEAR(sums[i][0] / kSumUnit, expected.r / 2, 0.04);
    EXPECT_NEAR(sums[i][1] / kSumUnit, expected.g / 2, 0.04);
    EXPECT_NEAR(sums[i][2] / kSumUnit, expected.b / 2, 0.04);
  }
  EXPECT_GT(bright, 5u);
}

TEST(Blending, NoPhotoAgreesWithAColourThatOffsetsMake) {
  // The left half shows view 0, the right one view 1, which is brighter along the seam alone, by what no exposure explains.
  const auto share = [](Blending blend) {
    BlendScene s(2);
    s.photograph(0, [](double x, double) { return Color{x < 0 ? 0.0f : 100.0f, 110, 90}; });
    s.photograph(1, [](double x, double) { return Color{std::abs(x - 4) < 0.5 ? 180.0f : 100.0f, 110, 90}; });
    for (std::size_t face = 0; face < s.mesh.faces.size(); ++face)
      if (face % 16 >= 8) s.labels[face] = ViewId{1};
    AtlasOptions options;
    options.blend = blend;
    s.exposure.resize(2);  // known to be equal
    options.align = PhotoAlignment::none;
    return s.build(options).statistics.invented_color;
  };
  const InventedColor found = share(Blending::coarse);
  EXPECT_GT(found.texels, 1000u);
  EXPECT_EQ(found.outside, 0u);
  EXPECT_EQ(share(Blending::none).texels, 0u) << "nothing is blended, and nothing is compared";
}

}  // namespace
}  // namespace gpvc::atlas
