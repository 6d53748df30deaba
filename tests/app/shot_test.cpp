// Lens, shake and haze of synthetic photos: the width of an edge is what the formulas say.
#include "app/synth/shot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "app/synth/synth_builder.h"

namespace gpvc {
namespace {

constexpr double kHeight_m = 10;

// A white and a black half of the plane z = 0, seen from straight above; their edge is the middle column's left border.
struct Edge {
  Camera camera;
  Pose pose;
  synth::SynthScene scene;
  std::unique_ptr<synth::SynthRenderer> renderer;

  Edge() {
    camera.width = 100;
    camera.height = 20;
    camera.fx = camera.fy = 400;
    camera.cx = 50;
    camera.cy = 10;
    pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    pose.centre = {0, 0, kHeight_m};
    synth::SynthBuilder builder(10, 1024, 1);
    for (const double x : {-8.0, 0.0}) {
      synth::Surface& half = builder.surface(builder.quad(synth::Material::paint, {x, -8, 0}, {8, 0, 0}, {0, 16, 0}));
      half.scale = 1e9;  // one colour
      half.tint = x < 0 ? synth::Color{1, 1, 1} : synth::Color{0.1, 0.1, 0.1};
    }
    scene = builder.take();
    renderer = std::make_unique<synth::SynthRenderer>(scene);
  }
  Image photo(const synth::Shot& shot) const { return renderer->photo(camera, pose, shot).image; }
  // Red of each column, mean over the rows.
  std::vector<double> profile(const synth::Shot& shot) const {
    const Image image = photo(shot);
    std::vector<double> mean(static_cast<std::size_t>(camera.width), 0);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        mean[static_cast<std::size_t>(x)] += image.at(x, y)[0] / static_cast<double>(camera.height);
    return mean;
  }
};

// Of the steps from column to column: where they lie, their standard deviation, and the reach of those above a 50th.
struct Spread {
  double middle = 0, deviation = 0, reach = 0;
};

Spread spread_of(const std::vector<double>& profile) {
  const double whole = profile.front() - profile.back();
  double sum = 0, squares = 0, reach = 0;
  for (std::size_t x = 1; x < profile.size(); ++x) {
    const double share = (profile[x - 1] - profile[x]) / whole, at = static_cast<double>(x);
    sum += share * at;
    squares += share * at * at;
    if (share > 0.02 / 4) reach = std::max(reach, std::abs(at - 50));
  }
  return {sum, std::sqrt(std::max(0.0, squares - sum * sum)), reach};
}

TEST(Shot, PlaneInFocusIsAsSharpAsThroughAPinhole) {
  const Edge edge;
  synth::Shot shot;
  shot.lens = {1.0, kHeight_m};
  const Image pinhole = edge.photo({}), focused = edge.photo(shot);
  for (std::size_t i = 0; i < pinhole.pixels.size(); ++i) ASSERT_NEAR(focused.pixels[i], pinhole.pixels[i], 1) << i;
  EXPECT_LT(spread_of(edge.profile(shot)).deviation, 0.1);
}

// The projection of an even disc of diameter c onto an axis has the standard deviation c / 4. Two positions a pixel, half a
// pixel apart, and steps from pixel to pixel add the variances 1 / 16 and 1 / 12.
TEST(Shot, EdgesOutOfFocusAreAsWideAsTheCircleOfConfusion) {
  const Edge edge;
  for (const auto& [focus_m, disc_px] : {std::pair{5.0, 20.0}, {20.0, 10.0}, {8.0, 5.0}}) {
    synth::Shot shot;
    shot.lens = {0.5, focus_m};
    EXPECT_NEAR(shot.lens.blur_px(edge.camera, kHeight_m), disc_px, 1e-9);
    const Spread spread = spread_of(edge.profile(shot));
    EXPECT_NEAR(spread.middle, 50, 0.15) << focus_m;
    const double expected = std::sqrt(disc_px * disc_px / 16 + 1.0 / 16 + 1.0 / 12);
    EXPECT_NEAR(spread.deviation, expected, 0.03 * expected) << focus_m;
    EXPECT_NEAR(spread.reach, disc_px / 2, 1) << focus_m;
  }
}

// An even smear of s pixels has the standard deviation s / sqrt(12).
TEST(Shot, ShakeSmearsByItsPixels) {
  const Edge edge;
  synth::Shot across, along, travel;
  across.shake.turn_rad = {0, 12 / edge.camera.fx, 0};
  along.shake.turn_rad = {12 / edge.camera.fy, 0, 0};
  travel.shake.travel_m = {12 * kHeight_m / edge.camera.fx, 0, 0};
  for (const synth::Shot& shot : {across, travel}) {
    const Spread spread = spread_of(edge.profile(shot));
    EXPECT_NEAR(spread.middle, 50, 0.15);
    EXPECT_NEAR(spread.deviation, 12 / std::sqrt(12.0), 0.12);
    EXPECT_NEAR(spread.reach, 6, 1);
  }
  EXPECT_LT(spread_of(edge.profile(along)).deviation, 0.1);
}

TEST(Shot, TurnsTheWholeCameraLeftOfWhatItSees) {
  // Halfway through the exposure from 0 to 1/2 a turn of w about y has turned by w / 4.
  synth::Shot shot;
  shot.shake.turn_rad = {0, 0.4, 0};
  const synth::CameraRay ray = synth::shot_ray(shot, 0, 0, {0, 0, 0.25});
  EXPECT_NEAR(ray.direction.x, std::sin(2 * std::atan(0.05)), 1e-12);
  EXPECT_NEAR(ray.direction.z, std::cos(2 * std::atan(0.05)), 1e-12);
  EXPECT_EQ(ray.direction.y, 0);
}

TEST(Shot, SixtyFourRaysDoBetterThanIndependentOnes) {
  const Edge edge;
  synth::Shot shot;
  shot.lens = {0.5, 5};
  shot.shake.turn_rad = {0.01, 0.02, 0};
  const Image few = edge.photo(shot);
  shot.rays = 4096;
  const Image many = edge.photo(shot);
  double squares = 0;
  std::size_t count = 0;
  for (int y = 0; y < edge.camera.height; ++y)
    for (int x = 40; x < 60; ++x, ++count)
      squares += std::pow(static_cast<double>(few.at(x, y)[0]) - many.at(x, y)[0], 2);
  const double contrast = edge.profile({}).front() - edge.profile({}).back();
  ASSERT_GT(contrast, 150);
  // Of independent rays each would be off by sqrt(p (1 - p)) of the contrast, p being its share of white: 0.39 in the mean
  // across the edge, and 64 of them by a 20th of the contrast.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), contrast / 32);
}

TEST(Shot, NoApertureAndNoShakeIsThePinholePhotoToTheByte) {
  const Edge edge;
  synth::Shot shot;
  shot.lens.focus_m = 3;
  shot.rays = 256;
  EXPECT_EQ(edge.photo(shot).pixels, edge.photo({}).pixels);
}

TEST(Shot, BlurredPhotosAreTheSameEveryTime) {
  const Edge edge;
  synth::Shot shot;
  shot.lens = {0.5, 5};
  EXPECT_EQ(edge.photo(shot).pixels, edge.photo(shot).pixels);
}

TEST(Shot, PixelsWithinTheDiscOfAnEdgeShowSeveralSurfaces) {
  const Edge edge;
  synth::Shot shot;
  shot.lens = {0.5, 20};  // 10 px
  const synth::SynthPhoto photo = edge.renderer->photo(edge.camera, edge.pose, shot);
  const auto at = [&](int x) { return photo.surfaces[pixel_index(x, 10, edge.camera.width)]; };
  EXPECT_EQ(at(43), 0u);
  EXPECT_EQ(at(47), synth::kMixedSurfaces);
  EXPECT_EQ(at(52), synth::kMixedSurfaces);
  EXPECT_EQ(at(56), 1u);
}

TEST(Shot, LensSamplesFillTheDiscAndTheExposureEvenly) {
  int rings[2] = {0, 0}, early = 0;
  double x = 0, y = 0, x2 = 0, xy = 0;
  constexpr int kCount = 4096;
  for (std::uint32_t n = 0; n < kCount; ++n) {
    const synth::LensSample s = synth::lens_sample(3, 5, n);
    const double r2 = s.x * s.x + s.y * s.y;
    ASSERT_LE(r2, 1 + 1e-6);
    ASSERT_GE(s.time, -0.5);
    ASSERT_LT(s.time, 0.5);
    ++rings[r2 < 0.5 ? 0 : 1];
    early += s.time < 0;
    x += s.x / kCount;
    y += s.y / kCount;
    x2 += s.x * s.x / kCount;
    xy += s.x * s.y / kCount;
  }
  EXPECT_NEAR(rings[0], kCount / 2, 40);
  EXPECT_NEAR(early, kCount / 2, 40);
  EXPECT_NEAR(x, 0, 0.01);
  EXPECT_NEAR(y, 0, 0.01);
  EXPECT_NEAR(x2, 0.25, 0.01);
  EXPECT_NEAR(xy, 0, 0.01);
}

// Light of the sky is 0.55 of level ground's, that of the sun 0.55 times the cosine.
TEST(Shot, ALowSunLightsLevelGroundLess) {
  const Edge edge;
  synth::Shot high, low;
  high.towards_sun = {0, 0, 1};
  low.towards_sun = {0.8, 0, 0.6};
  EXPECT_NEAR(edge.profile(low).front() / edge.profile(high).front(), (0.55 + 0.55 * 0.6) / 1.1, 0.01);
}

TEST(Shot, HazeTakesContrastByKoschmiedersLaw) {
  for (const double distance : {0.0, 10.0, 500.0, 1000.0, 2500.0})
    EXPECT_NEAR(synth::haze_transmission(distance, 1000), std::pow(0.02, distance / 1000), 1e-6) << distance;
  EXPECT_EQ(synth::haze_transmission(1e9, 0), 1);
  const Edge edge;
  synth::Shot hazy;
  hazy.visibility_m = 2 * kHeight_m;
  const std::vector<double> clear = edge.profile({}), dull = edge.profile(hazy);
  EXPECT_NEAR(dull.front() - dull.back(), std::sqrt(0.02) * (clear.front() - clear.back()), 1.1);
  EXPECT_NEAR(dull.back(), std::sqrt(0.02) * clear.back() + (1 - std::sqrt(0.02)) * 206, 1.1);
}

}  // namespace
}  // namespace gpvc
