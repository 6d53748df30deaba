#include "visibility/raster/photo_mask.h"

#include <gtest/gtest.h>

namespace gpvc::visibility {
namespace {

// Every pixel against the lens itself, where whole blocks are decided by the bound on its stretch.
TEST(PhotoMask, AgreesWithEveryLensAtEveryPixel) {
  const std::vector<Distortion> lenses{
      {.k1 = 0.3},
      {.k1 = -0.3},
      {.k1 = 0.3, .k2 = -0.05, .model = LensModel::perspective, .d1 = 0.4, .d2 = 0.02},
      {.p1 = 0.02, .p2 = -0.01, .k3 = 0.1, .model = LensModel::perspective, .k4 = 0.1, .p3 = 0.2, .skew = 0.01},
      {.k1 = 0.4, .model = LensModel::equidistant},
      {.k1 = 0.4, .model = LensModel::equidistant, .s1 = 0.05, .s2 = -0.02},
      {.k1 = 0.5, .model = LensModel::equisolid},
      {.model = LensModel::fisheye_polynomial, .skew = 0.01, .a1 = 0.1, .a2 = -0.4},
      {.model = LensModel::fov, .omega = 1.2},
      {.k1 = 0.3, .model = LensModel::inverse_radial},
      {.k1 = -0.1, .model = LensModel::inverse_radial},
      {.k1 = -0.5, .model = LensModel::division},
      {.k1 = 0.1, .model = LensModel::division},
      {.model = LensModel::unified, .alpha = 0.7, .beta = 1.2},
      {.k1 = 0.4, .model = LensModel::fisheye_624, .s1 = 0.05, .k6 = 0.02, .s4 = -0.03}};
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    Camera camera{401, 297, 300, 310, 195, 152, lenses[i]};
    limit_distortion(camera);
    const PhotoMask mask(camera);
    std::size_t outside = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const bool in = in_photo(camera, {x + 0.5, y + 0.5});
        outside += in ? 0 : 1;
        ASSERT_EQ(mask.contains(x, y), in) << "lens " << i << " at " << x << ' ' << y;
      }
    EXPECT_EQ(mask.whole(), outside == 0) << "lens " << i;
  }
}

// A lens may push the frame's outermost half pixels out of the photo and no pixel's centre.
TEST(PhotoMask, PositionsAreAskedEvenWhereAllCentresAreInside) {
  Camera camera{200, 150, 150, 150, 100, 75, {.k1 = 0.0005}};
  limit_distortion(camera);
  const PhotoMask mask(camera);
  EXPECT_TRUE(mask.whole());
  EXPECT_FALSE(mask.everywhere());
  for (const PixelPoint p : {PixelPoint{199.999, 149.999}, {199.5, 149.5}, {0.001, 75}, {100, 75}, {0.001, 0.001}})
    EXPECT_EQ(mask.contains(p), in_photo(camera, p)) << p.x << ' ' << p.y;
  EXPECT_FALSE(mask.contains(PixelPoint{199.999, 149.999}));
  camera.distortion = {};
  EXPECT_TRUE(PhotoMask(camera).everywhere());
}

}  // namespace
}  // namespace gpvc::visibility
