#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "atlas/alignment/alignment.h"
#include "atlas/alignment/patch.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

using Brightness = std::function<double(double x, double y)>;

/// What `shown` has at coarse pixels, with the place in the middle, moved by (x, y) pixels of the frame.
Patch patch_of(const Brightness& shown, double x = 0, double y = 0) {
  Patch patch;
  for (std::size_t row = 0; row < kPatchEdge; ++row)
    for (std::size_t column = 0; column < kPatchEdge; ++column)
      patch.luma[row * kPatchEdge + column] =
          static_cast<std::uint8_t>(std::lround(shown(static_cast<double>(column) - (kPatchEdge - 1) / 2.0 - x / 2,
                                                      static_cast<double>(row) - (kPatchEdge - 1) / 2.0 - y / 2)));
  return patch;
}

double bumps(double x, double y) {
  return 120 + 50 * std::sin(0.9 * x + 0.3 * y) * std::cos(0.7 * y - 0.2 * x + 0.4) + 20 * std::sin(0.31 * x * y);
}
double edge(double x, double y) { return 120 + 60 * std::tanh((x + 2 * y) / std::sqrt(5.0)); }

TEST(Patch, ShiftsAreFoundBetweenPixels) {
  const Patch reference = patch_of(bumps);
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.6, -0.4}, {-2.3, 1.7}, {4.4, 5.1}}) {
    const auto shift = shift_between(reference, patch_of(bumps, x, y));
    ASSERT_TRUE(shift) << x;
    EXPECT_NEAR(shift->x, x, 0.1);
    EXPECT_NEAR(shift->y, y, 0.1);
    EXPECT_NEAR(misfit(shift->x, shift->y, shift->information), std::hypot(x, y), 0.15);
    EXPECT_GT(shift->correlation, 0.95);
  }
}

TEST(Patch, ExposureChangesNoShift) {
  const auto darker = [](double x, double y) { return 20 + 0.5 * bumps(x, y); };
  const auto shift = shift_between(patch_of(bumps), patch_of(darker, 1.3, -0.8));
  ASSERT_TRUE(shift);
  EXPECT_NEAR(shift->x, 1.3, 0.15);
  EXPECT_NEAR(shift->y, -0.8, 0.15);
}

// What is along the edge cannot be told, and counts for nothing.
TEST(Patch, AnEdgeTellsWhatIsAcrossIt) {
  const auto shift = shift_between(patch_of(edge), patch_of(edge, 2, 1));
  ASSERT_TRUE(shift);
  EXPECT_NEAR(misfit(shift->x, shift->y, shift->information), 4 / std::sqrt(5.0),
              0.15);  // (2, 1) times the unit vector across, (1, 2) / sqrt 5
}

TEST(Patch, OtherContentsRepetitionAndFlatColorsHaveNoShift) {
  const auto other = [](double x, double y) { return 120 + 50 * std::cos(1.1 * x * y * 0.3 + 2) + 10 * std::sin(x); };
  EXPECT_FALSE(shift_between(patch_of(bumps), patch_of(other)));
  const auto tiles = [](double x, double y) { return 120 + 50 * std::sin(x * 1.57) * std::sin(y * 1.57); };  // every 4
  EXPECT_FALSE(shift_between(patch_of(tiles), patch_of(tiles, 1, 1)));
  const auto grey = [](double, double) { return 90.0; };
  EXPECT_FALSE(shift_between(patch_of(grey), patch_of(bumps)));
  EXPECT_FALSE(shift_between(patch_of(bumps), patch_of(grey)));
  EXPECT_FALSE(has_texture(patch_of(grey)));
  EXPECT_TRUE(has_texture(patch_of(bumps)));
  EXPECT_FALSE(shift_between(patch_of(bumps), patch_of(bumps, 9, 0)));  // beyond the reach
}

/// Views of one size whose frames differ by a shift alone.
Scene three_views() {
  Scene scene;
  for (int v = 0; v < 3; ++v) {
    View view;
    view.camera = {1200, 900, 1000, 1000, 600, 450, {}};
    scene.views.push_back(view);
  }
  return scene;
}

using Field = std::function<std::array<double, 2>(std::size_t view, double x, double y)>;

/// What a comparison finds at places all over the frames, with an error of a tenth of a pixel, and nonsense at every tenth place.
std::vector<PhotoMatch> matches_of(const Field& field) {
  std::mt19937 random(7);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  std::vector<PhotoMatch> matches;
  for (std::uint32_t i = 0; i < 6000; ++i) {
    const std::uint32_t first = i % 3, second = (first + 1 + i / 3 % 2) % 3;
    const double x = between(0, 1200), y = between(0, 900);
    const auto a = field(first, x, y), b = field(second, x, y);
    PhotoMatch match;
    match.views = {first, second};
    match.at = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(x), static_cast<float>(y)};
    for (std::size_t k = 0; k < 2; ++k)
      match.shift[k] = static_cast<float>(i % 10 == 0 ? between(-6, 6) : b[k] - a[k] + between(-0.1, 0.1));
    match.information = {100, 0, 100};
    match.second_from_first = {1, 0, 0, 1};
    matches.push_back(match);
  }
  return matches;
}

TEST(Alignment, FieldsOfAMeanOfZeroAreFound) {
  const Field truth = [](std::size_t view, double x, double y) {
    const double sign = view == 0 ? -2 : 1;  // of all views zero
    return std::array{sign * (0.8 + 0.6 * std::sin(x / 200)), sign * 0.7 * std::cos(y / 150)};
  };
  const Scene scene = three_views();
  const AlignmentFit fit = fit_alignment(scene, matches_of(truth));
  ASSERT_EQ(fit.fields.size(), 3u);
  EXPECT_GT(fit.statistics.before_px, 1.5);
  // Shifts are pulled to zero.
  EXPECT_LT(fit.statistics.after_px, 0.35 * fit.statistics.before_px);
  double squares = 0;
  int count = 0;
  for (std::size_t view = 0; view < 3; ++view) {
    ASSERT_TRUE(is_sound(fit.fields[view]));
    for (double x = 50; x < 1200; x += 100) {
      for (double y = 50; y < 900; y += 100, ++count) {
        const auto [u, v] = fit.fields[view].shift_at({x, y});
        const auto [true_u, true_v] = truth(view, x, y);
        squares += (u - true_u) * (u - true_u) + (v - true_v) * (v - true_v);
      }
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 0.45) << "of 1.6 px";
}

TEST(Alignment, WhatOneAffineMapAPhotoExplainsIsToldFromTheRest) {
  const auto share = [](double affine, double rest) {
    const auto fit = fit_alignment(three_views(), matches_of([&](std::size_t view, double x, double) {
                                     const double sign = view == 0 ? -2 : 1;
                                     return std::array{sign * (affine + rest * std::sin(x / 100)), 0.0};
                                   }));
    return fit.statistics.affine_share;
  };
  EXPECT_GT(share(2, 0), 0.95);
  EXPECT_LT(share(0, 2), 0.55);
}

// One a view, so that photos of a layer take them over as well.
bool are_none(const std::vector<ShiftField>& fields, std::size_t views) {
  return fields.size() == views && std::ranges::all_of(fields, [](const ShiftField& f) { return f.nodes.empty(); });
}

TEST(Alignment, NoiseHasNoField) {
  const Field none = [](std::size_t, double, double) { return std::array{0.0, 0.0}; };
  const AlignmentFit fit = fit_alignment(three_views(), matches_of(none));
  EXPECT_TRUE(are_none(fit.fields, 3));
  EXPECT_EQ(fit.statistics.matches, 6000u);
  EXPECT_TRUE(are_none(fit_alignment(three_views(), {}).fields, 3));
}

TEST(Alignment, ReducedPhotosHaveReducedFields) {
  ShiftField field{2, 2, 100, {{1, 2}, {3, 4}, {1, 2}, {3, 4}}};
  const auto half = reduced({field}, 2);
  const auto [x, y] = half[0].shift_at({25, 10});
  const auto [whole_x, whole_y] = field.shift_at({50, 20});
  EXPECT_NEAR(2 * x, whole_x, 1e-6);
  EXPECT_NEAR(2 * y, whole_y, 1e-6);
}

/// A plane seen by three cameras above it, whose faces take the first, second and third of them from left to right.
class PlaneOfThreePhotos {
 public:
  PlaneOfThreePhotos() {
    scene_.add_plane(60, 40, 0.1);
    for (int v = 0; v < 3; ++v) scene_.add_view(2 + 1.0 * v, 2, 5, 640, 480, 500);
    const Albedo ground = [](double x, double y) {
      const auto level = [&](double phase) {
        return static_cast<float>(125 + 50 * std::sin(31 * x + 9 * y + phase) * std::cos(27 * y - 5 * x) +
                                  30 * std::sin(11 * x * y + phase) + 15 * std::sin(17 * x - 3 * y * y));
      };
      return Color{level(0), level(0.4f), level(0.8f)};
    };
    for (std::size_t v = 0; v < 3; ++v) scene_.photograph(v, ground);
    scene_.candidates.first.assign(1, 0);
    for (std::size_t f = 0; f < scene_.mesh.faces.size(); ++f) {
      const double x = scene_.mesh.positions[scene_.mesh.faces[f][0]].x;
      scene_.labels[f] = ViewId{x < 2 ? 0u : x < 4 ? 1u : 2u};
      for (std::uint32_t v = 0; v < 3; ++v) {
        scene_.candidates.views.push_back(v);
        scene_.candidates.costs.push_back(0.02f * static_cast<float>(v + 1));
      }
      scene_.candidates.first.push_back(scene_.candidates.views.size());
    }
  }

  /// Says that a camera looks elsewhere than it does: what it shows is off by so many pixels.
  void turn(std::size_t view, double x, double y) {
    scene_.scene.views[view].camera.cx += x;
    scene_.scene.views[view].camera.cy += y;
  }

  std::vector<PhotoMatch> matches(std::size_t bytes) {
    scene_.graph = labeling::face_graph(scene_.mesh);
    io::PhotoCache photos(scene_.scene, std::size_t{1} << 30);
    const AtlasInput input{scene_.mesh, scene_.scene,      photos,         scene_.graph, scene_.labels,
                           scene_.tags, scene_.candidates, scene_.coverage};
    const FaceNeighbours neighbours = group_neighbours(scene_.mesh.faces.size(), scene_.graph.edges);
    return match_photos(input, neighbours, cut_places(input, neighbours), bytes);
  }
  TextureAtlas build(PhotoAlignment align) {
    AtlasOptions options;
    options.align = align;
    return scene_.build(options);
  }

 private:
  AtlasScene scene_;
};

TEST(Alignment, PhotosOfWrongPosesAreBroughtIntoLine) {
  PlaneOfThreePhotos plane;
  plane.turn(0, 1.6, -1.2);
  plane.turn(2, -1, 0.8);
  const AtlasStatistics before = plane.build(PhotoAlignment::none).statistics;
  const TextureAtlas aligned = plane.build(PhotoAlignment::local);
  EXPECT_GT(before.cuts.places, 10u);
  EXPECT_GT(before.cuts.median_px, 1);
  EXPECT_EQ(before.alignment.matches, 0u);
  EXPECT_EQ(aligned.alignment.size(), 3u);
  EXPECT_GT(aligned.statistics.alignment.affine_share, 0.8);
  EXPECT_LT(aligned.statistics.cuts.median_px, 0.25);
  EXPECT_NEAR(aligned.statistics.cuts.unaligned_median_px, before.cuts.median_px, 0.2);
}

TEST(Alignment, MemoryChangesNoMatch) {
  PlaneOfThreePhotos plane;
  plane.turn(0, 1, 1);
  const std::vector<PhotoMatch> all = plane.matches(kMatchBytes);
  EXPECT_GT(all.size(), 50u);
  EXPECT_EQ(plane.matches(1), all);
}

// A damaged file of an earlier run must not move a texel.
TEST(Alignment, FieldsAndMatchesThatNoFitLeavesAreToldFromOthers) {
  const ShiftField good{2, 2, 100, {{1, 2}, {3, 4}, {1, 2}, {3, 4}}};
  EXPECT_TRUE(is_sound(good));
  EXPECT_TRUE(is_sound(ShiftField{}));
  for (const auto& spoil : std::vector<std::function<void(ShiftField&)>>{
           [](ShiftField& f) { f.columns = 1; }, [](ShiftField& f) { f.rows = 3; },
           [](ShiftField& f) { f.spacing = 0; }, [](ShiftField& f) { f.spacing = NAN; },
           [](ShiftField& f) { f.nodes[2][1] = NAN; }, [](ShiftField& f) { f.nodes[0][0] = 17; },
           [](ShiftField& f) { f.nodes.pop_back(); }}) {
    ShiftField bad = good;
    spoil(bad);
    EXPECT_FALSE(is_sound(bad));
  }
  const Scene scene = three_views();
  PhotoMatch match;
  EXPECT_TRUE(is_sound(match, scene));
  match.views = {0, 3};
  EXPECT_FALSE(is_sound(match, scene));
  match.views = {0, 2};
  match.shift[1] = INFINITY;
  EXPECT_FALSE(is_sound(match, scene));
  match.shift[1] = 0;
  match.information = {1, 3, 1};  // of no covariance
  EXPECT_FALSE(is_sound(match, scene));
  match.information = {1, 1, 1};
  EXPECT_TRUE(is_sound(match, scene));
  match.second_from_first[0] = 1e30f;
  EXPECT_FALSE(is_sound(match, scene));
}

TEST(Alignment, PhotosThatFitStayAsTheyAre) {
  PlaneOfThreePhotos plane;
  const TextureAtlas none = plane.build(PhotoAlignment::none), local = plane.build(PhotoAlignment::local);
  EXPECT_GT(local.statistics.alignment.matches, 50u);
  EXPECT_TRUE(are_none(local.alignment, 3));
  EXPECT_LT(local.statistics.cuts.px_90, 0.4);
  ASSERT_EQ(local.pages.size(), none.pages.size());
  EXPECT_EQ(local.pages[0].pixels, none.pages[0].pixels);
}

}  // namespace
}  // namespace gpvc::atlas
