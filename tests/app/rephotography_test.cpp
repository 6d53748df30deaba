#include "app/evaluate/rephotography.h"

#include <gtest/gtest.h>

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
  // Where colours differ by more than a gain, it does not hide that.
  for (std::size_t i = 0; i < photo.photo.pixels.size(); i += 6) photo.photo.pixels[i] = 250;
  EXPECT_GT(compare_with_photo(photo, render, 1).score.gained_color_error, 5);
}

}  // namespace
}  // namespace gpvc::evaluate
