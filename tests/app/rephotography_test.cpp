#include "app/evaluate/rephotography.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "app/evaluate/score_picture.h"

namespace gpvc::evaluate {
namespace {

/// A model has one exposure, and the photos that judge it have theirs.
TEST(Rephotography, AGainOfThePhotoIsNoErrorOfColor) {
  constexpr int kEdge = 32;
  const std::vector<std::uint8_t> everywhere(kEdge * kEdge, 255);
  const Image black{kEdge, kEdge, 3, std::vector<std::uint8_t>(kEdge * kEdge * 3, 0)};
  ComparedPhoto photo{black, everywhere, everywhere};
  pipeline::RenderResult render{black, everywhere};
  for (std::size_t i = 0; i < render.image.pixels.size(); ++i) {
    render.image.pixels[i] = static_cast<std::uint8_t>(40 + 2 * (i * 7 % 31));
    photo.photo.pixels[i] = static_cast<std::uint8_t>(render.image.pixels[i] * 3 / 2);  // without rounding
  }
  const RephotographyScore score = compare_with_photo(photo, render, 1).score;
  EXPECT_GT(score.color_error, 5);
  EXPECT_LT(score.gained_color_error, 1e-3);
  EXPECT_GT(score.psnr, 90);
  EXPECT_LT(score.raw_psnr, 25);
  // Pictures show the model as it is, not the render as it was multiplied.
  const Rephotography shown = compare_with_photo(photo, render, 1);
  EXPECT_EQ(shown.render.pixels, render.image.pixels);
  EXPECT_NEAR(shown.gain[1], 1.5, 1e-9);
  // Where colours differ by more than a gain, it does not hide that.
  for (std::size_t i = 0; i < photo.photo.pixels.size(); i += 6) photo.photo.pixels[i] = 250;
  EXPECT_GT(compare_with_photo(photo, render, 1).score.gained_color_error, 5);
}

TEST(Rephotography, SharpnessIsThatOfThePhotoWhateverTheGain) {
  constexpr int kEdge = 64;
  const std::vector<std::uint8_t> everywhere(kEdge * kEdge, 255);
  const Image black{kEdge, kEdge, 3, std::vector<std::uint8_t>(kEdge * kEdge * 3, 0)};
  ComparedPhoto photo{black, everywhere, everywhere};
  pipeline::RenderResult same{black, everywhere}, blurred{black, everywhere};
  const auto stripes = [](int x, int y) { return 60 + 30 * ((x / 3 + y / 5) % 2); };
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        photo.photo.at(x, y)[c] = static_cast<std::uint8_t>(2 * stripes(x, y));
        same.image.at(x, y)[c] = static_cast<std::uint8_t>(stripes(x, y));
        int sum = 0;
        for (int dx = -1; dx <= 1; ++dx) sum += stripes(x + dx + 3, y);
        blurred.image.at(x, y)[c] = static_cast<std::uint8_t>(sum / 3);
      }
  EXPECT_NEAR(compare_with_photo(photo, same, 1).score.sharpness, 1, 0.01);
  EXPECT_LT(compare_with_photo(photo, blurred, 1).score.sharpness, 0.8);
}

/// A block of 4 x 4 pixels does not fit into it.
TEST(Rephotography, APhotoSmallerThanTheReductionHasNoScore) {
  const std::vector<std::uint8_t> everywhere(3 * 40, 255);
  const Image grey{3, 40, 3, std::vector<std::uint8_t>(3 * 40 * 3, 99)};
  const RephotographyScore score = compare_with_photo({grey, everywhere, everywhere}, {grey, everywhere}, 4).score;
  EXPECT_EQ(score.windows, 0u);
  EXPECT_EQ(score.completeness, 1);
}

/// Three panels under a band with what they are; small ones enlarged until the words fit.
TEST(ScorePicture, SaysWhatItsPanelsAre) {
  Rephotography compared;
  const auto flat = [](std::uint8_t grey) { return Image{60, 40, 3, std::vector<std::uint8_t>(60 * 40 * 3, grey)}; };
  compared.photo = flat(250);
  compared.render = flat(120);
  compared.error = flat(10);
  const Image picture = score_picture("a.jpg", compared, 4);
  const int factor = (picture.width - 16) / 180, band = picture.height - 40 * factor;
  EXPECT_EQ(picture.width, 3 * 60 * factor + 16);
  EXPECT_GE(60 * factor, 360) << "the words do not fit";
  for (const auto& [panel, grey] : {std::pair{0, 250}, {1, 120}, {2, 10}}) {
    const int x = panel * (60 * factor + 8);
    for (const int y : {band, picture.height - 1})
      for (const int right : {0, 60 * factor - 1}) EXPECT_EQ(*picture.at(x + right, y), grey) << panel;
    std::size_t bright = 0;  // letters
    for (int y = 0; y < band; ++y)
      for (int u = 0; u < 60 * factor; ++u) bright += *picture.at(x + u, y) > 128;
    EXPECT_GT(bright, 300u) << panel;
    EXPECT_LT(bright, static_cast<std::size_t>(band * 60 * factor / 4)) << panel;
  }
}

}  // namespace
}  // namespace gpvc::evaluate
