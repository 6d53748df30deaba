#include <gtest/gtest.h>

#include <random>
#include <tuple>

#include "atlas/leveling/color_correction.h"
#include "atlas/leveling/seam_leveling.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

Color weak_waves(double x, double y) {
  return {static_cast<float>(110 + 40 * std::sin(2 * x) * std::cos(1.7 * y)),
          static_cast<float>(100 + 30 * std::cos(1.3 * x + y)), static_cast<float>(70 + 5 * x + 3 * y)};
}

/// A plane of 12 x 6 m: the left half from view 0, the right half from view 1, a ragged border between them.
void two_views(AtlasScene& s) {
  s.add_plane(24, 12, 0.5);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    s.labels[f] = ViewId{p.x > 6 + std::sin(3 * p.y) ? 1u : 0u};
  }
  s.add_view(5, 3, 10, 720, 400, 400);
  s.add_view(7, 3, 10, 720, 400, 400);
}

struct Colors {
  double step = 0;   ///< mean absolute difference across the seam, at its edges' middles
  Color mean;        ///< over all faces
  double worst = 0;  ///< difference to `truth`, if given
};

Colors measure(const TextureAtlas& atlas, const AtlasScene& s, const Albedo& truth = nullptr) {
  Colors result;
  const auto color = [&](std::size_t face, double a, double b) {
    return lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, a, b));
  };
  double steps = 0;
  std::size_t count = 0;
  for (const auto& [f, g] : s.graph.edges) {
    if (s.labels[f] == s.labels[g]) continue;
    // Barycentric coordinates of the shared edge's middle in a face: one half at shared vertices.
    const auto middle = [&](std::size_t face, std::size_t other) {
      const auto& t = s.mesh.faces[other];
      const auto has = [&](std::size_t i) {
        return std::find(t.begin(), t.end(), s.mesh.faces[face][i]) != t.end() ? 0.5 : 0.0;
      };
      return color(face, has(0), has(1));
    };
    const Color d = middle(f, g) - middle(g, f);
    steps += (std::abs(d.r) + std::abs(d.g) + std::abs(d.b)) / 3;
    ++count;
  }
  result.step = steps / static_cast<double>(count);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const Color c = color(f, 1.0 / 3, 1.0 / 3);
    result.mean = result.mean + (1.0f / static_cast<float>(s.mesh.faces.size())) * c;
    if (!truth) continue;
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    const Color d = c - truth(p.x, p.y);
    result.worst = std::max<double>(result.worst, std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b)}));
  }
  return result;
}

AtlasOptions with(SeamLeveling seams) {
  AtlasOptions options;
  options.seams = seams;
  return options;
}

TEST(ColorCorrection, LocalGainIsTheGain) {
  ViewExposure exposure;
  exposure.gain = {0.8f, 1, 1.3f};
  exposure.centre_x = 1000;
  exposure.centre_y = 700;
  exposure.inverse_radius2 = 1 / (1000.0 * 1000 + 700 * 700);
  exposure.k1 = -0.4;
  exposure.k2 = 0.1;
  const LocalGain local(exposure, {1800, 1300});
  for (const double shift : {-8.0, 0.0, 3.5, 8.0}) {
    const PixelPoint p{1800 + shift, 1300 - shift / 2};
    EXPECT_NEAR(local.at(p).r, gain_at(exposure, p).r, 1e-5);
    EXPECT_NEAR(local.at(p).b, gain_at(exposure, p).b, 1e-5);
  }
}

// As of a fit to seams near the middle of photos, at a corner. A principal point far from the middle doubles the radius.
TEST(ColorCorrection, NoFallOffMultipliesByMoreThanFour) {
  ViewExposure exposure;
  exposure.gain = {2.5f, 1, 0.4f};
  exposure.inverse_radius2 = 1 / (1000.0 * 1000 + 700 * 700);
  for (const auto& [k1, k2, most] : {std::tuple(20.0, 0.0, 4.0f), {-20.0, 0.0, 0.25f}, {-0.5, 2.0, 4.0f}}) {
    exposure.k1 = k1;
    exposure.k2 = k2;
    for (const double radius : {1.0, 2.0}) {
      const PixelPoint corner{1000 * radius, 700 * radius};
      EXPECT_FLOAT_EQ(gain_at(exposure, corner).r, 2.5f * most) << k1 << ' ' << k2 << ' ' << radius;
      EXPECT_FLOAT_EQ(gain_at(exposure, corner).b, 0.4f * most) << k1 << ' ' << k2 << ' ' << radius;
      EXPECT_FLOAT_EQ(LocalGain(exposure, corner).at({corner.x - 3, corner.y}).r, 2.5f * most) << k1 << ' ' << k2;
    }
  }
  exposure.k1 = 1e308;
  exposure.k2 = -1e308;
  EXPECT_LE(gain_at(exposure, {2000, 1400}).r, 10);
}

TEST(ColorCorrection, SmallOffsetsAreAdded) {
  const Color c = corrected({100, 60, 40}, {4, -3, 2}, {1, 1, 1});
  EXPECT_FLOAT_EQ(c.r, 104);
  EXPECT_FLOAT_EQ(c.g, 57);
  EXPECT_FLOAT_EQ(c.b, 42);
}

// A leaf beside a shaded road, whose step asks for less red and more blue, was made navy.
TEST(ColorCorrection, OffsetsMakeNoColorThatThePhotoDoesNotHave) {
  const Color leaf{40, 55, 25};
  const Color c = corrected(leaf, {-40, -25, 10}, {1, 1, 1});
  EXPECT_GT(c.r, 8);
  EXPECT_GT(c.g, c.r);
  EXPECT_LT(c.b, c.g);
  // Where all channels ask for the same, they get it.
  const Color darker = corrected(leaf, {-20, -27.5f, -12.5f}, {1, 1, 1});
  EXPECT_NEAR(darker.r, 20, 2);
  EXPECT_NEAR(darker.g, 27.5f, 2);
  EXPECT_NEAR(darker.b, 12.5f, 2);
}

// No step where the limit begins.
TEST(ColorCorrection, LimitsOfOffsetsBeginGradually) {
  Color last = corrected({30, 60, 20}, {}, {1, 1, 1});
  for (int i = 1; i <= 400; ++i) {
    const float t = 0.1f * static_cast<float>(i);
    const Color next = corrected({30, 60, 20}, {t, -t, 0.5f * t}, {1, 1, 1});
    for (const auto channel : {&Color::r, &Color::g, &Color::b})
      ASSERT_LT(std::abs(next.*channel - last.*channel), 0.4f) << t;
    last = next;
  }
}

TEST(ColorCorrection, GainsLeaveHighlightsTheirStructure) {
  EXPECT_EQ(with_highlights(150, 1.5f), 150);
  EXPECT_EQ(with_highlights(250, 1), 250);
  EXPECT_EQ(with_highlights(250, 0.9f), 250);
  EXPECT_NEAR(with_highlights(1.5f * 255, 1.5f), 255, 1e-3);
  for (int level = 0; level < 255; ++level) {
    const float here = with_highlights(1.5f * static_cast<float>(level), 1.5f);
    const float next = with_highlights(1.5f * static_cast<float>(level + 1), 1.5f);
    EXPECT_GT(next, here);
    EXPECT_LT(here, 255);
  }
}

TEST(ColorCorrection, OffsetPlaneIsTheFacesOffsetWithinIt) {
  ColorCorrection correction;
  correction.nodes = {{2, 0, 1}};
  correction.offsets = {{10, -4, 0}, {-20, 3, 1}, {5, 5, 8}};
  const TexelTriangle corners{TexelPoint{3, 1}, TexelPoint{40, 9}, TexelPoint{7, 30}};
  const OffsetPlane plane = correction.offset_plane(0, corners);
  for (const auto& [b, c] : {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(0.2, 0.7), std::pair(0.5, 0.5)}) {
    const double x = 3 + 37 * b + 4 * c, y = 1 + 8 * b + 29 * c;
    const Color slow = correction.face_offset(0, corners, x, y), fast = plane.at(x, y);
    EXPECT_NEAR(fast.r, slow.r, 1e-4);
    EXPECT_NEAR(fast.g, slow.g, 1e-4);
    EXPECT_NEAR(fast.b, slow.b, 1e-4);
  }
}

TEST(SeamLeveling, NoneLeavesPhotosAsTheyAre) {
  AtlasScene s;
  two_views(s);
  s.photograph(0, weak_waves);
  s.photograph(1, weak_waves, [](int, int, Color c) { return 0.7f * c; });
  const TextureAtlas atlas = s.build(with(SeamLeveling::none));
  EXPECT_GT(measure(atlas, s).step, 20);
  EXPECT_EQ(atlas.statistics.seam_step_before, 0);
}

/// Gains of 0.8 and 1.25, whose geometric mean is one: exactly the albedo must come back.
TEST(SeamLeveling, ExposureDifferenceDisappearsAndBrightnessStays) {
  AtlasScene s;
  two_views(s);
  s.photograph(0, weak_waves, [](int, int, Color c) { return 0.8f * c; });
  s.photograph(1, weak_waves, [](int, int, Color c) { return 1.25f * c; });
  for (const auto mode : {SeamLeveling::global, SeamLeveling::full}) {
    const TextureAtlas atlas = s.build(with(mode));
    const Colors c = measure(atlas, s, weak_waves);
    EXPECT_LT(c.step, 1.0);
    EXPECT_LT(c.worst, 3.0);
    EXPECT_GT(atlas.statistics.seam_step_before, 30);
    EXPECT_LT(atlas.statistics.seam_step_after, 1.0);
    EXPECT_GT(atlas.statistics.seam_edges, 10u);
  }
}

TEST(SeamLeveling, ColorCastIsRemovedPerChannel) {
  AtlasScene s;
  two_views(s);
  s.photograph(0, weak_waves, [](int, int, Color c) { return Color{1.1f, 1.0f, 0.85f} * c; });
  s.photograph(1, weak_waves, [](int, int, Color c) { return Color{1 / 1.1f, 1.0f, 1 / 0.85f} * c; });
  const TextureAtlas atlas = s.build(with(SeamLeveling::full));
  EXPECT_LT(measure(atlas, s, weak_waves).worst, 3.0);
}

/// A fall-off towards the corners that both views share shows as a step that changes sign along the seam.
TEST(SeamLeveling, VignettingIsRemoved) {
  AtlasScene s;
  two_views(s);
  const auto vignette = [](int x, int y, Color c) {
    const double dx = x + 0.5 - 360, dy = y + 0.5 - 200, r2 = (dx * dx + dy * dy) / (360 * 360 + 200 * 200);
    return static_cast<float>(1 / (1 + 0.5 * r2)) * c;
  };
  s.photograph(0, weak_waves, vignette);
  s.photograph(1, weak_waves, vignette);
  const TextureAtlas leveled = s.build(with(SeamLeveling::full));
  const Colors c = measure(leveled, s);
  EXPECT_LT(c.step, 1.0);
}

/// A texel's centre may lie far outside the photo, where the fitted fall-off means nothing.
TEST(SeamLeveling, FallOffOfCoarseTexelsIsThatOfThePhotoTheyShow) {
  AtlasScene s;
  two_views(s);
  for (std::size_t v = 0; v < 2; ++v) {
    s.photograph(v, weak_waves, [](int x, int y, Color c) {
      const double dx = x + 0.5 - 360, dy = y + 0.5 - 200;
      return static_cast<float>(1 / (1 + 0.5 * (dx * dx + dy * dy) / (360 * 360 + 200 * 200))) * c;
    });
  }
  AtlasOptions options = with(SeamLeveling::global);
  const Color fine = measure(s.build(options), s).mean;
  options.texel_size = 50;  // 2000 px
  const Color coarse = measure(s.build(options), s).mean;
  EXPECT_NEAR(coarse.r, fine.r, 10);
  EXPECT_NEAR(coarse.g, fine.g, 10);
  EXPECT_NEAR(coarse.b, fine.b, 10);
}

/// An offset, which no gain models: the two sides meet halfway, and colours far away move less than that.
TEST(SeamLeveling, StepsThatNoGainExplainsAreSpreadAndBounded) {
  AtlasScene s;
  two_views(s);
  s.photograph(0, weak_waves);
  // Brighter along a stripe that crosses the border once.
  s.photograph(1, weak_waves, [](int, int y, Color c) {
    return c + (y > 150 && y < 250 ? Color{12, 12, 12} : Color{});
  });
  const Colors none = measure(s.build(with(SeamLeveling::none)), s);
  const Colors global = measure(s.build(with(SeamLeveling::global)), s);
  const TextureAtlas atlas = s.build(with(SeamLeveling::full));
  const Colors full = measure(atlas, s, weak_waves);
  EXPECT_GT(none.step, 3);
  EXPECT_LT(global.step, 0.5 * none.step);
  EXPECT_LT(full.step, 1.5);
  EXPECT_LT(full.step, global.step);
  // The stripe itself, half its step, the rounding of texels, and the stripe's edge, which coarse photos blur by half a pixel.
  EXPECT_LT(full.worst, 12 + 6 + 0.5 + 0.5);
}

/// The lowest sixth of the seam lies on the edge of a dark surface, which one photo shows 2 px to the right and the other 2 px
/// to the left: one side of the seam is dark, the other bright, and neither is where a photo has a gradient. The brightness
/// is the same in both photos.
TEST(SeamLeveling, EdgesThatAreOffByPixelsChangeColorsLittle) {
  AtlasScene s;
  s.add_plane(24, 12, 0.5);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    s.labels[f] = ViewId{point_at(s.mesh, f, 1.0 / 3, 1.0 / 3).x > 6 ? 1u : 0u};
  s.add_view(5, 3, 10, 720, 400, 400);
  s.add_view(7, 3, 10, 720, 400, 400);
  const auto edge_at = [](double edge) -> Albedo {
    return [=](double x, double y) { return x < edge && y < 1 ? Color{80, 80, 80} : Color{120, 120, 120}; };
  };
  constexpr double kPixel = 10.0 / 400;
  s.photograph(0, edge_at(6 + 2 * kPixel));
  s.photograph(1, edge_at(6 - 2 * kPixel));
  EXPECT_LT(measure(s.build(with(SeamLeveling::full)), s, edge_at(6)).worst, 10);  // half of the step would be 20
}

TEST(SeamLeveling, ClippedPhotosDoNotMislead) {
  AtlasScene s;
  two_views(s);
  const Albedo bright = [](double x, double y) { return 1.5f * weak_waves(x, y); };
  s.photograph(0, bright);
  s.photograph(1, bright, [](int, int, Color c) { return 1.4f * c; });  // much of it above 255
  const TextureAtlas atlas = s.build(with(SeamLeveling::full));
  EXPECT_LT(atlas.statistics.seam_step_after, 0.1 * atlas.statistics.seam_step_before);
}

TEST(SeamLeveling, FacesWithoutSeamsKeepTheirColors) {
  AtlasScene s;
  s.add_plane(4, 4, 1.0);
  s.add_view(2, 2, 10, 500, 500, 500);
  s.photograph(0, weak_waves);
  EXPECT_EQ(s.build(with(SeamLeveling::full)).pages.at(0).pixels, s.build(with(SeamLeveling::none)).pages.at(0).pixels);
}

TEST(SeamLeveling, GainsOfManyViewsAreFound) {
  AtlasScene s;
  s.add_plane(40, 8, 0.5);
  constexpr std::size_t kViews = 8;
  const auto gain = [](std::size_t v) { return static_cast<float>(std::exp(0.35 * std::sin(2.4 * double(v)))); };
  double logs = 0;
  for (std::size_t v = 0; v < kViews; ++v) logs += std::log(gain(v)) / double(kViews);
  for (std::size_t v = 0; v < kViews; ++v) {
    s.add_view(1.25 + 2.5 * double(v), 2, 10, 400, 300, 400);
    s.photograph(v, weak_waves, [&](int, int, Color c) { return gain(v) * c; });
  }
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    s.labels[f] = ViewId{static_cast<std::uint32_t>(point_at(s.mesh, f, 0.3, 0.3).x / 2.5)};
  s.graph = labeling::face_graph(s.mesh);
  io::PhotoCache photos(s.scene, std::size_t{1} << 28);
  s.candidates.first.assign(s.mesh.faces.size() + 1, 0);
  const AtlasInput input{s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage};
  const CoverageIndex coverage(s.coverage);
  const auto exposure = fit_exposure(input);
  for (std::size_t v = 0; v < kViews; ++v)
    EXPECT_NEAR(std::log(exposure[v].gain[1]) + std::log(gain(v)) - logs, 0, 0.015) << v;
}

// The seam is halfway between two photos, whose fall-off takes as much from both sides of it.
TEST(SeamLeveling, OverlapsTellAFallOffThatSeamsDoNot) {
  AtlasScene s;
  s.add_plane(24, 12, 0.5);
  for (std::uint32_t v = 0; v < 2; ++v) {
    s.add_view(5 + 2.0 * v, 3, 10, 720, 400, 400);
    s.photograph(v, weak_waves, [](int x, int y, Color c) {
      const double dx = x + 0.5 - 360, dy = y + 0.5 - 200, r2 = (dx * dx + dy * dy) / (360 * 360 + 200 * 200);
      return static_cast<float>(1 - 0.3 * r2) * c;
    });
  }
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    s.labels[f] = ViewId{point_at(s.mesh, f, 1.0 / 3, 1.0 / 3).x < 6 ? 0u : 1u};
  s.graph = labeling::face_graph(s.mesh);
  // Halfway to a corner, by area.
  const auto brightened = [&](bool overlap) {
    s.candidates = {};
    s.candidates.first.push_back(0);
    for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
      for (std::uint32_t v = 0; v < 2 && overlap; ++v) {
        s.candidates.views.push_back(v);
        s.candidates.costs.push_back(0);
      }
      s.candidates.first.push_back(s.candidates.views.size());
    }
    io::PhotoCache photos(s.scene, std::size_t{1} << 28);
    const auto exposure = fit_exposure({s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage});
    return std::exp(0.5 * exposure[0].k1 + 0.25 * exposure[0].k2);
  };
  EXPECT_LT(brightened(false), 1.05);
  EXPECT_NEAR(brightened(true), 1 / 0.85, 0.02);
}

// As in a mesh of a format that shares none.
TEST(SeamLeveling, FacesThatShareNoVertexGetThePhotosGains) {
  AtlasScene s;
  s.add_plane(12, 12, 0.5);
  Mesh soup;
  for (const Triangle& face : s.mesh.faces) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t v : face) soup.positions.push_back(s.mesh.positions[v]);
    soup.faces.push_back({first, first + 1, first + 2});
  }
  s.mesh = std::move(soup);
  for (std::uint32_t v = 0; v < 2; ++v) {
    s.add_view(2.5 + v, 3, 10, 500, 500, 500);
    s.photograph(v, weak_waves, [&](int, int, Color c) { return (v == 0 ? 1.0f : 1.25f) * c; });
  }
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    s.labels[f] = ViewId{point_at(s.mesh, f, 0.3, 0.3).x < 3 ? 0u : 1u};
    for (const std::uint32_t v : {0u, 1u}) {
      s.candidates.views.push_back(v);
      s.candidates.costs.push_back(0);
    }
    if (f == 0) s.candidates.first.push_back(0);
    s.candidates.first.push_back(s.candidates.views.size());
  }
  const TextureAtlas atlas = s.build(with(SeamLeveling::full));
  ASSERT_EQ(atlas.exposure.size(), 2u);
  EXPECT_NEAR(atlas.exposure[0].gain[1] / atlas.exposure[1].gain[1], 1.25, 0.03);
}

/// Photos of a flight of lines over a plane, and the ratios across the seams halfway between each photo and the next ones.
struct Flight {
  static constexpr int kLines = 8, kInLine = 8;
  Scene scene;
  std::vector<ColorRatio> ratios;
  std::vector<std::size_t> faces = std::vector<std::size_t>(std::size_t{kLines} * kInLine, 100);

  /// \param gain      of a photo's colours
  /// \param eastward  how much brighter all is, per unit of the image plane, where one looks to the east
  template <class Gain>
  Flight(const Gain& gain, double eastward) {
    for (int i = 0; i < kLines * kInLine; ++i) {
      View& view = scene.views.emplace_back();
      view.camera = {400, 300, 400, 400, 200, 150, {}};
      view.pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
      view.pose.centre = {2.0 * (i % kInLine), 2.0 * (i / kInLine), 10};
    }
    const auto seam = [&](std::uint32_t a, std::uint32_t b) {
      for (int n = 0; n < 5; ++n) {
        ColorRatio ratio{{a, b}, {}, {}, 10};
        const WorldPoint &from = scene.views[a].pose.centre, &to = scene.views[b].pose.centre;
        const WorldPoint middle{(from.x + to.x) / 2, (from.y + to.y) / 2 + 0.2 * n, 0};
        // The ground differs from place to place.
        const double ground = std::log(100 + 20 * std::sin(1.3 * middle.x) + 15 * std::cos(0.9 * middle.y));
        for (std::size_t s = 0; s < 2; ++s) {
          const PixelPoint at = pixel_from_world(scene.views[ratio.views[s]], middle).value();
          ratio.at[s] = {at.x, at.y};
          ratio.logs[s].fill(ground + std::log(gain(ratio.views[s])) + eastward * (at.x - 200) / 400);
        }
        ratios.push_back(ratio);
      }
    };
    for (std::uint32_t i = 0; i < kLines * kInLine; ++i) {
      if (i % kInLine + 1 < kInLine) seam(i, i + 1);
      if (i + kInLine < kLines * kInLine) seam(i, i + kInLine);
    }
  }

  /// The least and the most of the gains that are found, times those of the photos.
  template <class Gain>
  std::array<double, 2> left_of(const Gain& gain) const {
    std::array<double, 2> ends{1e9, 0};
    const auto exposure = fit_exposure(scene, ratios, faces);
    for (std::uint32_t v = 0; v < exposure.size(); ++v) {
      const double left = static_cast<double>(exposure[v].gain[1]) * gain(v);
      ends = {std::min(ends[0], left), std::max(ends[1], left)};
    }
    return ends;
  }
};

// As fields are with the sun behind the camera. Each seam says that the photo beyond it is brighter by 6 %, eight in a row would make
// one side of the flight half as bright again as the other.
TEST(SeamLeveling, ViewDependentBrightnessDoesNotAddUpAlongAFlight) {
  const auto same = [](std::uint32_t) { return 1.0; };
  const auto [least, most] = Flight(same, 0.3).left_of(same);
  EXPECT_GT(least, 0.9);
  EXPECT_LT(most, 1.1);
}

TEST(SeamLeveling, GainsThatWanderAlongAFlightAreFound) {
  const auto wandering = [](std::uint32_t v) { return 1 + 0.3 * std::sin(0.31 * v) * std::cos(0.05 * v); };
  const auto [least, most] = Flight(wandering, 0).left_of(wandering);
  EXPECT_LT(most / least, 1.08);
}

// What neither seams nor the photos' brightness tell: the ground gets darker along the flight, the camera exposes for it, and all photos
// are alike. Taken by their brightness, one end would be a fifth as bright again as the other. Grey levels are a root of light.
TEST(SeamLeveling, ExifDataTellATrendOfExposureFromATrendOfTheGround) {
  const auto exposed = [](std::uint32_t v) { return std::exp(0.08 * (v % Flight::kInLine)); };
  Flight flight(exposed, -0.16);
  const auto ratio = [&] {
    const auto [least, most] = flight.left_of(exposed);
    return most / least;
  };
  EXPECT_GT(ratio(), 1.2);
  for (std::uint32_t v = 0; v < flight.scene.views.size(); ++v)
    flight.scene.views[v].exposure_value = static_cast<float>(12 - 2.2 * std::log2(exposed(v)));
  EXPECT_LT(ratio(), 1.1);
  flight.scene.views[3].exposure_value.reset();  // they are of no use without those of all photos
  EXPECT_GT(ratio(), 1.2);
}

/// The step, of 20 grey levels, that offsets leave between two squares, each of a view of its own, that meet at an angle. Near edges in
/// the photos, so that samples have little weight, but there are many.
double step_left(double angle) {
  Mesh mesh;
  mesh.positions = {{0, -1, 0},
                    {0, 1, 0},
                    {-1, -1, 0},
                    {-1, 1, 0},
                    {std::cos(angle), -1, std::sin(angle)},
                    {std::cos(angle), 1, std::sin(angle)}};
  mesh.faces = {{0, 1, 2}, {2, 1, 3}, {0, 4, 1}, {1, 4, 5}};
  Scene scene;
  scene.views.resize(2);
  io::PictureSource photos(scene, std::vector<io::Picture>(2, {Image{0, 0, 3, {}}}));
  const auto graph = labeling::face_graph(mesh);
  const std::vector<ViewId> labels{ViewId{0}, ViewId{0}, ViewId{1}, ViewId{1}};
  const std::vector<labeling::FaceTag> tags(4, labeling::FaceTag::seen);
  labeling::CostTable candidates;
  candidates.first.assign(5, 0);
  const visibility::CoverageTable coverage;
  const AtlasInput input{mesh, scene, photos, graph, labels, tags, candidates, coverage};
  SeamSamples seams;
  seams.edges = {{{0, 2}, {0, 1}, 0, 100}};
  seams.colors.assign(100, {Color{100, 100, 100}, Color{120, 120, 120}});
  seams.frame.resize(100);
  seams.weight.assign(100, 0.02f);
  ColorCorrection correction;
  fit_offsets(input, seams, correction);
  const auto offset = [&](std::uint32_t face) { return correction.offsets[correction.nodes[face][0]].g; };
  return double{20 + offset(2) - offset(0)};
}

// Where two walls meet, each photo shows some of the other wall beside the edge, all along it and all around a wall: no brightness,
// and offsets would tint whole walls. On a smooth surface what photos show beside each other's edges differs this way and that.
TEST(SeamLeveling, OffsetsDoNotCloseStepsOfCreases) {
  EXPECT_NEAR(step_left(0), 0, 0.5);
  EXPECT_GT(step_left(1.5707963), 12);
}

// As of a view that is left out, in a format that leaves the size to the photo.
TEST(SeamLeveling, AViewWithoutASizeHasAnExposureThatIsANumber) {
  Scene scene;
  scene.views.resize(2);
  scene.views[1].camera = {400, 300, 400, 400, 200, 150, {}};
  const std::vector<std::size_t> faces(2, 0);
  for (const ViewExposure& exposure : fit_exposure(scene, {}, faces)) EXPECT_TRUE(is_sound(exposure));
}

/// Nine photos of a plane, gains from 0.7 to 1.4 and a fall-off towards the corners: seams disappear and colours stay
/// where they are.
TEST(SeamLeveling, ExposureAndVignettingOfManyPhotosAreRemoved) {
  AtlasScene s;
  s.add_plane(36, 36, 0.5);
  for (int v = 0; v < 9; ++v) s.add_view(3 + 6 * (v % 3), 3 + 6 * (v / 3), 10, 400, 400, 300);
  // Their geometric mean is one: brightness as a whole cannot be known from the photos.
  constexpr double kGains[] = {0.7, 1.4, 1.0, 1.19, 0.85, 1.3, 0.77, 0.92, 1.075};
  for (std::size_t v = 0; v < 9; ++v) {
    s.photograph(v, weak_waves, [&](int x, int y, Color c) {
      const double dx = x + 0.5 - 200, dy = y + 0.5 - 200, r2 = (dx * dx + dy * dy) / (2 * 200 * 200);
      return static_cast<float>(kGains[v] * (1 - 0.3 * r2)) * c;
    });
  }
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    const double x = p.x + 0.7 * std::sin(1.9 * p.y), y = p.y + 0.6 * std::sin(2.3 * p.x);
    const auto third = [](double t) { return static_cast<std::uint32_t>(std::clamp(t / 6, 0.0, 2.0)); };
    s.labels[f] = ViewId{third(x) + 3 * third(y)};
  }
  const TextureAtlas atlas = s.build(with(SeamLeveling::full));
  const Colors c = measure(atlas, s, weak_waves);
  EXPECT_GT(measure(s.build(with(SeamLeveling::none)), s).step, 15);
  EXPECT_LT(c.step, 2);
  EXPECT_LT(atlas.statistics.seam_step_after, 2);
  Color truth;
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    truth = truth + (1.0f / static_cast<float>(s.mesh.faces.size())) * weak_waves(p.x, p.y);
  }
  EXPECT_NEAR(c.mean.r, truth.r, 3);
  EXPECT_NEAR(c.mean.g, truth.g, 3);
  EXPECT_NEAR(c.mean.b, truth.b, 3);
}

// Where slivers meet, as around the middle of a fan, thousands of seams cross a texel.
TEST(Strips, CrowdedSamplesCountAsTheirMeans) {
  Chart chart;
  chart.width = chart.height = 40;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(4, 12);
  std::vector<SeamStep> crowded;
  for (int i = 0; i < 50000; ++i) {
    const float x = place(random), y = place(random);
    crowded.push_back({x, y, 1, {x, -y, 3}});  // steps that vary over the cell
  }
  const ChartStrip strip = make_strip(chart, crowded);
  EXPECT_LE(strip.cells.items.size(), 64u);
  // The nearest sample may seem half a texel farther, which fades a strip that ends after 20.
  ChartStrip plain;
  plain.columns = strip.columns;
  plain.rows = strip.rows;
  plain.cells = group_items<StripSample>(9, [&](const auto& add) {
    for (const SeamStep& s : crowded) add(std::size_t{0}, StripSample{s.x, s.y, s.weight + 0.05f, s.weight * s.step});
  });
  for (const auto& [x, y] : {std::pair{8.5, 8.5}, std::pair{14.0, 7.0}, std::pair{20.0, 20.0}}) {
    const Color thinned = strip_offset(&strip, x, y), all = strip_offset(&plain, x, y);
    EXPECT_NEAR(thinned.r, all.r, 0.7);
    EXPECT_NEAR(thinned.g, all.g, 0.7);
    EXPECT_NEAR(thinned.b, all.b, 0.25);
  }
}

}  // namespace
}  // namespace gpvc::atlas
