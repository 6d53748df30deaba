#include "io/scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include "io/number_text.h"

namespace gpvc::io {
namespace {

Camera wide_camera(const Distortion& distortion) {
  Camera camera{4000, 3000, 2300, 2310, 2041.5, 1480.25, distortion};
  limit_distortion(camera);
  return camera;
}

TEST(Camera, LeavesPixelsAloneWithoutDistortion) {
  const Camera camera = wide_camera({});
  const PixelPoint p{12.3, 4567.8};
  EXPECT_EQ(photo_from_pixel(camera, p)->x, p.x);
  EXPECT_EQ(photo_from_pixel(camera, p)->y, p.y);
  EXPECT_EQ(pixel_from_photo(camera, {p.x, p.y})->y, p.y);
  EXPECT_EQ(camera.distortion.max_r2, Distortion{}.max_r2);
}

// With x = 0.5, y = -0.25: r2 = 0.3125; every term by hand.
TEST(Camera, DistortsByTheBrownConradyFormula) {
  const Distortion d{.k1 = 0.1, .k2 = -0.02, .p1 = 0.001, .p2 = -0.002, .k3 = 0.003};
  const Camera camera = wide_camera(d);
  const double x = 0.5, y = -0.25, r2 = 0.3125;
  const double radial = 1 + 0.1 * r2 - 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
  const double dx = x * radial + 2 * 0.001 * x * y - 0.002 * (r2 + 2 * x * x);
  const double dy = y * radial + 0.001 * (r2 + 2 * y * y) - 2 * 0.002 * x * y;
  const auto q = photo_from_pixel(camera, {camera.fx * x + camera.cx, camera.fy * y + camera.cy});
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->x, camera.fx * dx + camera.cx, 1e-9);
  EXPECT_NEAR(q->y, camera.fy * dy + camera.cy, 1e-9);
}

TEST(Camera, InverseReturnsToTheSamePixel) {
  for (const Distortion& d : {Distortion{.k1 = -0.28, .k2 = 0.09, .p1 = 4e-4, .p2 = -7e-4, .k3 = -0.01},
                              Distortion{.k1 = 0.35}, Distortion{.k1 = -0.1}, Distortion{.p1 = 0.004, .p2 = 0.003},
                              Distortion{.k1 = 0.0112, .k2 = 0.0164, .p1 = -0.00147, .p2 = 0.00226}}) {
    const Camera camera = wide_camera(d);
    for (int y = -200; y <= camera.height + 200; y += 100)
      for (int x = -200; x <= camera.width + 200; x += 100) {
        const PixelPoint p{x + 0.5, y + 0.5};
        const auto photo = photo_from_pixel(camera, p);
        if (!photo) continue;
        const auto back = pixel_from_photo(camera, *photo);
        ASSERT_TRUE(back) << x << ' ' << y << " k1 " << d.k1;
        EXPECT_NEAR(back->x, p.x, 1e-8) << x << ' ' << y << " k1 " << d.k1;
        EXPECT_NEAR(back->y, p.y, 1e-8) << x << ' ' << y << " k1 " << d.k1;
        const auto again = photo_from_pixel(camera, *back);
        ASSERT_TRUE(again);
        EXPECT_LE(std::hypot(again->x - photo->x, again->y - photo->y), 1e-9);
      }
  }
}

double max_r2_of(const Distortion& d) { return wide_camera(d).distortion.max_r2; }

TEST(LimitDistortion, FindsTheFirstFold) {
  // r (1 + k1 r^2): slope 1 + 3 k1 s.
  EXPECT_NEAR(max_r2_of({.k1 = -0.25}), 4.0 / 3, 1e-12);
  // 1 + 5 k2 s^2 and 1 + 7 k3 s^3.
  EXPECT_NEAR(max_r2_of({.k2 = -0.2}), 1, 1e-12);
  EXPECT_NEAR(max_r2_of({.k3 = -1.0 / 56}), 2, 1e-12);
  // (1 - s)(1 - s/2)(1 - s/3) = 1 - 11/6 s + s^2 - s^3/6: three folds, the first counts.
  EXPECT_NEAR(max_r2_of({.k1 = -11.0 / 18, .k2 = 0.2, .k3 = -1.0 / 42}), 1, 1e-12);
  // (1 - s)^2 (1 + s/4) = 1 - 7/4 s + s^2/2 + s^3/4 touches zero at 1 and grows again: within round-off either answer,
  // at the touch or never, is right; none beyond it is.
  const double touch = max_r2_of({.k1 = -7.0 / 12, .k2 = 0.1, .k3 = 1.0 / 28});
  EXPECT_TRUE(std::abs(touch - 1) < 1e-6 || touch == Distortion{}.max_r2) << touch;
}

TEST(LimitDistortion, KnowsModelsThatNeverFold) {
  for (const Distortion& d : {Distortion{.k1 = 0.3}, Distortion{.k1 = -0.25, .k2 = 0.1}, Distortion{.k3 = 1},
                              Distortion{.p1 = 0.1}, Distortion{.k1 = 0.1, .k2 = 0.1, .k3 = 0.1}})
    EXPECT_EQ(max_r2_of(d), Distortion{}.max_r2) << d.k1 << ' ' << d.k2 << ' ' << d.k3;
}

// Against a scan: the profile grows up to the limit and no longer just behind it.
TEST(LimitDistortion, AgreesWithDenseScan) {
  for (int i = -6; i <= 6; ++i)
    for (int j = -6; j <= 6; ++j)
      for (int k = -6; k <= 6; ++k) {
        const Distortion d{.k1 = 0.07 * i, .k2 = 0.05 * j, .k3 = 0.03 * k};
        const auto slope = [&](double s) { return 1 + 3 * d.k1 * s + 5 * d.k2 * s * s + 7 * d.k3 * s * s * s; };
        const double limit = max_r2_of(d);
        for (double s = 1e-3; s < std::min(limit, 50.0); s += 1e-2)
          ASSERT_GT(slope(s), 0) << i << ' ' << j << ' ' << k << " at " << s << " limit " << limit;
        if (limit < 1e300) {
          EXPECT_LE(slope(limit * (1 + 1e-9)), 1e-6) << i << ' ' << j << ' ' << k;
        }
      }
}

TEST(Camera, AnswersNothingBeyondTheFold) {
  const Camera camera = wide_camera({.k1 = -0.25});
  const double fold = std::sqrt(4.0 / 3);
  EXPECT_TRUE(photo_from_pixel(camera, {camera.cx + camera.fx * fold * 0.999, camera.cy}));
  EXPECT_FALSE(photo_from_pixel(camera, {camera.cx + camera.fx * fold * 1.001, camera.cy}));
  // Far out the model has come back into the photo: x = 2 gives 2 (1 - 1) = 0.
  EXPECT_FALSE(in_photo(camera, {camera.cx + camera.fx * 2, camera.cy}));
  // The profile's maximum is at the fold, so no pixel shows a photo point beyond it.
  const double farthest = fold * (1 - 0.25 * 4 / 3);
  EXPECT_TRUE(pixel_from_photo(camera, {camera.cx + camera.fx * farthest * 0.999, camera.cy}));
  EXPECT_FALSE(pixel_from_photo(camera, {camera.cx + camera.fx * farthest * 1.001, camera.cy}));
  EXPECT_FALSE(pixel_from_photo(camera, {std::nan(""), 0}));
}

TEST(Camera, InPhotoIncludesTheBorder) {
  const Camera camera = wide_camera({});
  EXPECT_TRUE(in_photo(camera, {0, 0}));
  EXPECT_TRUE(in_photo(camera, {4000, 3000}));
  EXPECT_FALSE(in_photo(camera, {4000.001, 10}));
  EXPECT_FALSE(in_photo(camera, {10, -0.001}));
  // Barrel distortion pulls pixels in: the frame's corner is inside the photo, and so is more beyond it.
  const Camera barrel = wide_camera({.k1 = -0.1});
  EXPECT_TRUE(in_photo(barrel, {-20, -20}));
  // Pincushion pushes the frame's corners out.
  EXPECT_FALSE(in_photo(wide_camera({.k1 = 0.1}), {1, 1}));
}

// Other programs read what convert writes: few of them mind exponents, but all read plain decimals.
TEST(GeneralText, WritesPlainDecimalsThatReadBack) {
  EXPECT_EQ(general_text(100000), "100000");
  EXPECT_EQ(general_text(0.0004), "0.0004");
  EXPECT_EQ(general_text(607.2), "607.2");
  EXPECT_EQ(general_text(-2.5e-7), "-2.5e-07");
  EXPECT_EQ(general_text(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(general_text(1.0 / 3), "0.3333333333333333");
}

}  // namespace
}  // namespace gpvc::io
