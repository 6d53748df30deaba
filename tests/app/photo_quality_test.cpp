// Photos of known sharpness, brightness and noise.
#include "app/evaluate/photo_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "tests/support/temporary_folder.h"

namespace gpvc::evaluate {
namespace {

using test::contains;

/// Bars of random widths and greys, 24 to 48 pixels wide, along x or along y, blurred by a Gaussian.
Image bars(double sigma, bool along_x, double gain = 1, double noise = 0) {
  constexpr int kSize = 400;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> width(24, 48), grey(20, 120);
  std::normal_distribution<double> grain(0, 1);
  std::vector<double> profile(kSize, grey(random));
  for (int at = width(random); at < kSize; at += width(random)) {
    // The integral of a Gaussian about the edge; the pixel's own box takes the place of none at all.
    const double step = grey(random) - profile.back();
    for (int x = 0; x < kSize; ++x)
      profile[static_cast<std::size_t>(x)] +=
          step * (sigma == 0 ? (x >= at) : 0.5 * (1 + std::erf((x + 0.5 - at) / (sigma * std::numbers::sqrt2))));
  }
  Image image{kSize, kSize, 3, std::vector<std::uint8_t>(std::size_t{3} * kSize * kSize)};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double level = gain * profile[static_cast<std::size_t>(along_x ? x : y)] + noise * grain(random);
      std::fill_n(image.at(x, y), 3, static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L)));
    }
  return image;
}

double blur(double sigma, bool along_x = true, double gain = 1, double noise = 0) {
  return photo_quality(bars(sigma, along_x, gain, noise)).blur;
}

TEST(PhotoQuality, BlurIsThatOfTheEdges) {
  EXPECT_LT(blur(0), 0.6);  // a step between two pixels lies half a pixel from the next one
  for (const double sigma : {1.0, 1.5, 2.0, 4.0}) EXPECT_NEAR(blur(sigma), sigma, 0.1 * sigma + 0.1) << sigma;
}

TEST(PhotoQuality, AShakeAlongOneAxisCounts) { EXPECT_NEAR(blur(3, false), blur(3, true), 1e-3); }

TEST(PhotoQuality, ExposureAndNoiseMakeLittleDifference) {
  for (const double sigma : {1.0, 2.0, 3.0}) {
    EXPECT_NEAR(blur(sigma, true, 2), blur(sigma), 0.05 * sigma) << sigma;
    EXPECT_NEAR(blur(sigma, true, 1, 3), blur(sigma), 0.2 * sigma) << sigma;
  }
}

TEST(PhotoQuality, BrightnessIsLinear) {
  Image grey{8, 8, 3, std::vector<std::uint8_t>(std::size_t{3} * 64, 188)};
  EXPECT_NEAR(photo_quality(grey).brightness, 0.5029, 1e-3);  // sRGB's 188 is half of the light
  EXPECT_EQ(photo_quality(grey).blur, 0);
  EXPECT_EQ(photo_quality(grey).clipped, 0);
  for (int y = 0; y < 8; ++y)
    for (int x = 4; x < 8; ++x) grey.at(x, y)[2] = 255;
  EXPECT_DOUBLE_EQ(photo_quality(grey).clipped, 0.5);
}

TEST(PhotoQuality, WarnsOfWhatStandsOut) {
  const PhotoQuality good{1.2, 0.2, 0};
  const std::vector<std::string> names{"a.jpg", "b.jpg", "c.jpg", "d.jpg", "e.jpg"};
  EXPECT_TRUE(quality_warnings({good, good, {1.8, 0.3, 0.04}, {2.3, 0.11, 0}, good}, names).empty());
  const auto lines = quality_warnings({good, {2.5, 0.2, 0}, {1, 0.41, 0.2}, {1, 0.09, 0}, good}, names);
  ASSERT_EQ(lines.size(), 2);
  EXPECT_TRUE(contains(lines[0], "1 photos are blurred more than twice")) << lines[0];
  EXPECT_TRUE(contains(lines[0], ": b.jpg")) << lines[0];
  EXPECT_TRUE(contains(lines[1], "2 photos are brighter or darker")) << lines[1];
  EXPECT_TRUE(contains(lines[1], "c.jpg, d.jpg")) << lines[1];
  EXPECT_TRUE(quality_warnings({}, {}).empty());
}

}  // namespace
}  // namespace gpvc::evaluate
