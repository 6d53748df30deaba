#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "io/scene.h"

namespace gpvc::io {
namespace {

struct NamedLens {
  const char* name;
  Distortion lens;
};

const std::vector<NamedLens> kLenses{
    {"brown", {.k1 = -0.28, .k2 = 0.09, .p1 = 4e-4, .p2 = -7e-4, .k3 = -0.01}},
    {"rational",
     {.k1 = 0.3,
      .k2 = -0.05,
      .p1 = 1e-3,
      .p2 = 2e-3,
      .k3 = 0.01,
      .model = LensModel::perspective,
      .d1 = 0.4,
      .d2 = 0.02,
      .d3 = 0.003}},
    {"frame",
     {.k1 = -0.09,
      .k2 = -0.07,
      .p1 = 3e-3,
      .p2 = -1e-3,
      .k3 = 0.11,
      .model = LensModel::perspective,
      .k4 = -0.02,
      .p3 = 0.2,
      .p4 = -0.1,
      .skew = 0.002}},
    {"fisheye", {.k1 = 0.02, .k2 = -0.01, .k3 = 0.004, .model = LensModel::equidistant, .k4 = -0.0007}},
    {"thin prism",
     {.k1 = 0.02,
      .k2 = -0.01,
      .p1 = 1e-3,
      .p2 = -2e-3,
      .k3 = 0.004,
      .model = LensModel::equidistant,
      .k4 = -0.0007,
      .s1 = 0.003,
      .s2 = -0.002}},
    {"equisolid", {.k1 = 0.01, .p1 = 1e-3, .model = LensModel::equisolid, .skew = -0.001}},
    {"fov", {.model = LensModel::fov, .omega = 0.92}},
    {"inverse, barrel", {.k1 = 0.15, .model = LensModel::inverse_radial}},
    {"inverse, pincushion", {.k1 = -0.05, .model = LensModel::inverse_radial}},
    {"division, barrel", {.k1 = -0.3, .model = LensModel::division}},
    {"division, pincushion", {.k1 = 0.1, .model = LensModel::division}},
    {"unified", {.model = LensModel::unified, .alpha = 0.6, .beta = 1.1}},
    {"fisheye 624",
     {.k1 = 0.02,
      .k2 = -0.01,
      .p1 = 1e-3,
      .p2 = -2e-3,
      .k3 = 0.004,
      .model = LensModel::fisheye_624,
      .k4 = -0.0007,
      .s1 = 0.003,
      .s2 = -0.002,
      .k5 = 2e-4,
      .k6 = -1e-5,
      .s3 = -0.001,
      .s4 = 5e-4}},
    {"polynomial", {.model = LensModel::fisheye_polynomial, .skew = 0.002, .a1 = 0.01, .a2 = -0.0653, .a3 = 0.004}},
    {"polynomial, folding", {.model = LensModel::fisheye_polynomial, .a1 = 0.2, .a2 = -0.4}},
};

Camera camera_with(const Distortion& lens) {
  Camera camera{4000, 3000, 2300, 2310, 2041.5, 1480.25, lens};
  limit_distortion(camera);
  return camera;
}

PixelPoint pixel(const Camera& c, double x, double y) { return {c.fx * x + c.cx, c.fy * y + c.cy}; }

void expect_at(const Distortion& lens, double x, double y, double expected_x, double expected_y) {
  const Camera c = camera_with(lens);
  const auto photo = photo_from_pixel(c, pixel(c, x, y));
  ASSERT_TRUE(photo);
  EXPECT_NEAR(photo->x, c.fx * expected_x + c.cx, 1e-9);
  EXPECT_NEAR(photo->y, c.fy * expected_y + c.cy, 1e-9);
}

// Every expectation is the model's published formula written out for one point.

TEST(Lens, DividesTheRationalModelAsOpenCvDoes) {
  const double x = 0.5, y = -0.25, s = 0.3125;
  const double radial =
      (1 + 0.3 * s - 0.05 * s * s + 0.01 * s * s * s) / (1 + 0.4 * s + 0.02 * s * s + 0.003 * s * s * s);
  expect_at(kLenses[1].lens, x, y, x * radial + 2 * 1e-3 * x * y + 2e-3 * (s + 2 * x * x),
            y * radial + 1e-3 * (s + 2 * y * y) + 2 * 2e-3 * x * y);
}

TEST(Lens, AppliesEveryTermOfAMetashapeFrame) {
  const double x = 0.4, y = 0.3, s = 0.25;
  const double radial = 1 - 0.09 * s - 0.07 * s * s + 0.11 * s * s * s - 0.02 * s * s * s * s;
  const double more = 1 + 0.2 * s - 0.1 * s * s;
  const double dx = x * radial + (-1e-3 * (s + 2 * x * x) + 2 * 3e-3 * x * y) * more;
  const double dy = y * radial + (3e-3 * (s + 2 * y * y) + 2 * -1e-3 * x * y) * more;
  expect_at(kLenses[2].lens, x, y, dx + 0.002 * dy, dy);
}

TEST(Lens, BendsAFisheyeByTheAngle) {
  const double x = 0.9, y = 1.2, r = 1.5, theta = std::atan(r), t = theta * theta;
  const double scaled = theta * (1 + 0.02 * t - 0.01 * t * t + 0.004 * t * t * t - 0.0007 * t * t * t * t) / r;
  expect_at(kLenses[3].lens, x, y, x * scaled, y * scaled);
  expect_at(kLenses[3].lens, 0, 0, 0, 0);
}

TEST(Lens, AddsTheThinPrismOnTheAngularPlane) {
  const double u = 0.6 * std::atan(0.5), v = -0.8 * std::atan(0.5),
               s = u * u + v * v;  // (0.3, -0.4): r = 0.5
  const double radial = 1 + 0.02 * s - 0.01 * s * s + 0.004 * s * s * s - 0.0007 * s * s * s * s;
  expect_at(kLenses[4].lens, 0.3, -0.4, u * radial + 2 * 1e-3 * u * v - 2e-3 * (s + 2 * u * u) + 0.003 * s,
            v * radial + 1e-3 * (s + 2 * v * v) + 2 * -2e-3 * u * v - 0.002 * s);
}

TEST(Lens, BendsTheFovModelByItsOmega) {
  const double r = 0.5, bent = std::atan(2 * r * std::tan(0.46)) / 0.92 / r;
  expect_at(kLenses[6].lens, 0.3, -0.4, 0.3 * bent, -0.4 * bent);
}

TEST(Lens, InvertsTheRadialTermOfVisualSfm) {
  // The distorted radius 0.6 comes from 0.6 (1 + 0.15 * 0.36).
  const double from = 1 + 0.15 * 0.36;
  expect_at(kLenses[7].lens, 0.36 * from, -0.48 * from, 0.36, -0.48);
}

TEST(Lens, DividesByTheDistortedRadius) {
  // The distorted radius 0.6 comes from 0.6 / (1 - 0.3 * 0.36), that of 0.5 from 0.5 / (1 + 0.1 * 0.25).
  const double barrel = 1 / (1 - 0.3 * 0.36), pincushion = 1 / (1 + 0.1 * 0.25);
  expect_at(kLenses[9].lens, 0.36 * barrel, -0.48 * barrel, 0.36, -0.48);
  expect_at(kLenses[10].lens, 0.3 * pincushion, 0.4 * pincushion, 0.3, 0.4);
}

TEST(Lens, ProjectsByTheUnifiedModel) {
  const double scale = 1 / (0.6 * std::sqrt(1.1 * 0.25 + 1) + 0.4);
  expect_at(kLenses[11].lens, 0.3, -0.4, 0.3 * scale, -0.4 * scale);
}

TEST(Lens, BendsAndTiltsBehindTheRadialTermsOfFisheye624) {
  const double a = std::atan(0.5), s = a * a;  // (0.3, -0.4): r = 0.5
  const double radial = 1 + 0.02 * s - 0.01 * s * s + 0.004 * std::pow(s, 3) - 0.0007 * std::pow(s, 4) +
                        2e-4 * std::pow(s, 5) - 1e-5 * std::pow(s, 6);
  const double x = 0.6 * a * radial, y = -0.8 * a * radial, r2 = x * x + y * y;
  expect_at(kLenses[12].lens, 0.3, -0.4, x + 2 * 1e-3 * x * y - 2e-3 * (r2 + 2 * x * x) + 0.003 * r2 - 0.001 * r2 * r2,
            y + 1e-3 * (r2 + 2 * y * y) + 2 * -2e-3 * x * y - 0.002 * r2 + 5e-4 * r2 * r2);
}

TEST(Lens, BendsAFisheyeByAnyPowerOfTheAngle) {
  const double t = std::atan(0.5), q = t + 0.01 * t * t - 0.0653 * t * t * t + 0.004 * t * t * t * t;
  expect_at(kLenses[13].lens, 0.3, -0.4, 0.6 * q - 0.002 * 0.8 * q, -0.8 * q);
  expect_at(kLenses[13].lens, 0, 0, 0, 0);
}

TEST(Lens, InverseReturnsToTheSamePixel) {
  for (const auto& [name, lens] : kLenses) {
    const Camera c = camera_with(lens);
    int answered = 0;
    for (int y = -1200; y <= c.height + 1200; y += 100)
      for (int x = -1200; x <= c.width + 1200; x += 100) {
        const PixelPoint p{x + 0.5, y + 0.5};
        const auto photo = photo_from_pixel(c, p);
        if (!photo) continue;
        ++answered;
        const auto back = pixel_from_photo(c, *photo);
        ASSERT_TRUE(back) << name << ' ' << x << ' ' << y;
        EXPECT_NEAR(back->x, p.x, 1e-7) << name;
        EXPECT_NEAR(back->y, p.y, 1e-7) << name;
      }
    EXPECT_GT(answered, 1000) << name;
  }
}

TEST(Lens, FindsFoldsAndPoles) {
  const auto limit = [](const Distortion& lens) { return camera_with(lens).distortion.max_r2; };
  // theta (1 - theta^2): slope 1 - 3 theta^2.
  EXPECT_NEAR(limit({.k1 = -1, .model = LensModel::equidistant}), std::pow(std::tan(std::sqrt(1.0 / 3)), 2), 1e-12);
  // The fold lies behind 90 degrees: no limit in front of the camera.
  EXPECT_EQ(limit({.k1 = -0.05, .model = LensModel::equidistant}), Distortion{}.max_r2);
  EXPECT_EQ(limit({.model = LensModel::equisolid}), Distortion{}.max_r2);
  EXPECT_EQ(limit({.model = LensModel::fov, .omega = 1}), Distortion{}.max_r2);
  // r / (1 - s): the slope never falls, the divisor vanishes at s = 1.
  EXPECT_NEAR(limit({.model = LensModel::perspective, .d1 = -1}), 1, 1e-12);
  // r / (1 + s): slope (1 - s) / (1 + s)^2.
  EXPECT_NEAR(limit({.model = LensModel::perspective, .d1 = 1}), 1, 1e-12);
  // r (1 + k4 s^4): slope 1 + 9 k4 s^4.
  EXPECT_NEAR(limit({.model = LensModel::perspective, .k4 = -1.0 / 9}), 1, 1e-12);
  // r = q - q^3 / 3 grows up to q = 1, where r = 2/3.
  EXPECT_NEAR(limit({.k1 = -1.0 / 3, .model = LensModel::inverse_radial}), 4.0 / 9, 1e-12);
  // r = q / (1 + q^2 / 10) grows up to q^2 = 10; with the other sign there is no end.
  EXPECT_NEAR(limit({.k1 = 0.1, .model = LensModel::division}), 2.5, 1e-12);
  EXPECT_EQ(limit({.k1 = -0.1, .model = LensModel::division}), Distortion{}.max_r2);
  EXPECT_EQ(limit({.model = LensModel::unified, .alpha = 0.6, .beta = 1.1}), Distortion{}.max_r2);
  EXPECT_NEAR(limit({.model = LensModel::fisheye_624, .k6 = -1.0 / 13}), std::pow(std::tan(1), 2), 1e-11);
  // theta (1 - theta^2), the same fold as above; and one that lies behind 90 degrees.
  EXPECT_NEAR(limit({.model = LensModel::fisheye_polynomial, .a2 = -1}), std::pow(std::tan(std::sqrt(1.0 / 3)), 2),
              1e-12);
  EXPECT_EQ(limit({.model = LensModel::fisheye_polynomial, .a2 = -0.05}), Distortion{}.max_r2);
  // Between the last turn and infinity: (1 - s / 100)^2 ... and a lone far zero.
  EXPECT_NEAR(limit({.k1 = -1.0 / 3e6}), 1e6, 1e-3);
}

TEST(Lens, PhotoRadiusGrowsUpToTheLimit) {
  for (const auto& [name, lens] : kLenses) {
    const Camera c = camera_with(lens);
    const double end = std::min(std::sqrt(c.distortion.max_r2), 4.0);
    double before = -1;
    for (int i = 0; i < 400; ++i) {
      const auto p = photo_from_pixel(c, pixel(c, end * i / 400, 0));
      ASSERT_TRUE(p) << name;
      // Along one axis the tangential terms can bend it back before the radial ones do: allow their size.
      EXPECT_GT(p->x, before - 5) << name;
      before = p->x;
    }
  }
}

TEST(Lens, NothingStretchesMoreThanTheBound) {
  for (const auto& [name, lens] : kLenses) {
    const Camera c = camera_with(lens);
    for (double r2 : {0.01, 0.2, 0.6}) {
      if (r2 > c.distortion.max_r2) continue;
      const double bound = largest_stretch(c, r2);
      double largest = 0;
      for (int i = 0; i < 64; ++i)
        for (const double part : {0.0, 0.3, 0.7, 0.999}) {
          const double angle = i * 2 * std::numbers::pi / 64, r = part * std::sqrt(r2), step = 1e-4;
          const PixelPoint p = pixel(c, r * std::cos(angle), r * std::sin(angle));
          for (int j = 0; j < 16; ++j) {
            const double turn = j * std::numbers::pi / 16;
            const auto a = photo_from_pixel(c, p);
            const auto b = photo_from_pixel(c, {p.x + step * std::cos(turn), p.y + step * std::sin(turn)});
            if (a && b) largest = std::max(largest, std::hypot(b->x - a->x, b->y - a->y) / step);
          }
        }
      // 1e-6: positions of 1e4 px carry 2e-12 px of round-off, divided by the step of 1e-4 px twice over.
      EXPECT_LE(largest, bound + 1e-6) << name << ' ' << r2;
      EXPECT_LE(bound, 4 * largest) << name << ' ' << r2;  // and it says something
    }
  }
}

TEST(Lens, ForgetsAModelItDoesNotNeed) {
  EXPECT_EQ(camera_with({.k1 = 0.1, .model = LensModel::perspective}).distortion.model, LensModel::brown);
  EXPECT_TRUE(camera_with({.model = LensModel::perspective}).distortion.is_identity());
  EXPECT_FALSE(camera_with({.model = LensModel::equidistant}).distortion.is_identity());
  EXPECT_EQ(camera_with({.model = LensModel::perspective, .skew = 1e-9}).distortion.model, LensModel::perspective);
}

}  // namespace
}  // namespace gpvc::io
