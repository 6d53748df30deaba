// Cameras that move while their photos are read out.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "io/scene_files.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {
namespace {

/// The plane that tests photograph: 1 / Z = 0.1 + 0.02 X / Z - 0.03 Y / Z, so 0.1 Z + 0.02 X - 0.03 Y = 1.
constexpr std::array<double, 3> kNearness{0.02, -0.03, 0.1};

Camera moving_camera() {
  Camera camera{400, 300, 350, 340, 210, 145, {}};
  camera.distortion.k1 = -0.05;
  camera.distortion.p1 = 0.001;
  camera.distortion.motion = {
      .across = 0.1, .down = 1.5, .turn = {0.01, -0.02, 0.015}, .step = {0.2, -0.1, 0.15}, .nearness = kNearness};
  limit_distortion(camera);
  return camera;
}

/// exp(v) of the matrix of the cross product with v, by its series.
std::array<double, 3> turned(const std::array<double, 3>& v, std::array<double, 3> p) {
  std::array<double, 3> sum = p;
  for (int n = 1; n < 20; ++n) {
    p = {(v[1] * p[2] - v[2] * p[1]) / n, (v[2] * p[0] - v[0] * p[2]) / n, (v[0] * p[1] - v[1] * p[0]) / n};
    for (std::size_t i = 0; i < 3; ++i) sum[i] += p[i];
  }
  return sum;
}

/// Where the camera that stands still as it is at a time shows the point.
PhotoPoint place_at(const Camera& camera, double time, const CameraPoint& p) {
  const Motion& m = camera.distortion.motion;
  const auto q = turned({time * m.turn[0], time * m.turn[1], time * m.turn[2]},
                        {p.x - time * m.step[0], p.y - time * m.step[1], p.z - time * m.step[2]});
  Camera still = camera;
  still.distortion.motion = {};
  return *photo_from_pixel(still, pixel_from_camera(still, {q[0], q[1], q[2]}));
}

/// The place that the point has at the time at which that place is read out, by bisection of the time.
PhotoPoint place_of(const Camera& camera, const CameraPoint& p) {
  const Motion& m = camera.distortion.motion;
  double low = -2, high = 2;
  for (int i = 0; i < 60; ++i) {
    const double time = (low + high) / 2;
    const PhotoPoint at = place_at(camera, time, p);
    const double read = m.across * (at.x / camera.width - 0.5) + m.down * (at.y / camera.height - 0.5);
    (read > time ? low : high) = time;
  }
  return place_at(camera, low, p);
}

CameraPoint on_plane(double x, double y, const std::array<double, 3>& nearness = kNearness) {
  const double z = 1 / (nearness[0] * x + nearness[1] * y + nearness[2]);
  return {x * z, y * z, z};
}

TEST(Motion, ShowsPointsOfThePlaneWhereTheyAreWhenTheirRowIsRead) {
  const Camera camera = moving_camera();
  for (double x = -0.5; x <= 0.5; x += 0.25)
    for (double y = -0.4; y <= 0.4; y += 0.2) {
      const CameraPoint p = on_plane(x, y);
      const auto photo = photo_from_pixel(camera, pixel_from_camera(camera, p));
      const PhotoPoint expected = place_of(camera, p);
      ASSERT_TRUE(photo);
      EXPECT_NEAR(photo->x, expected.x, 1e-8);
      EXPECT_NEAR(photo->y, expected.y, 1e-8);
    }
}

// At another distance it is off by the step's effect, 350 px * |step| * (difference of 1 / Z) over half the photo.
TEST(Motion, IsOffElsewhereByTheDifferenceInNearness) {
  const Camera camera = moving_camera();
  const CameraPoint p = on_plane(0.1, 0.4, {0.02, -0.03, 0.11});
  const PhotoPoint photo = *photo_from_pixel(camera, pixel_from_camera(camera, p)), exact = place_of(camera, p);
  const double off = std::hypot(photo.x - exact.x, photo.y - exact.y);
  EXPECT_GT(off, 0.1);
  EXPECT_LT(off, 350 * 0.27 * 0.01 * 0.85);
}

TEST(Motion, HasAnInverse) {
  const Camera camera = moving_camera();
  for (double x = 0.5; x < 400; x += 66.5)
    for (double y = 0.5; y < 300; y += 59.8) {
      const auto pixel = pixel_from_photo(camera, {x, y});
      ASSERT_TRUE(pixel);
      const auto photo = photo_from_pixel(camera, *pixel);
      ASSERT_TRUE(photo);
      EXPECT_NEAR(photo->x, x, 1e-8);
      EXPECT_NEAR(photo->y, y, 1e-8);
    }
}

TEST(Motion, MovesPhotosWithoutDistortionToo) {
  Camera camera = moving_camera();
  const Motion motion = camera.distortion.motion;
  camera.distortion = {};
  EXPECT_TRUE(camera.distortion.is_identity());
  camera.distortion.motion = motion;
  EXPECT_FALSE(camera.distortion.is_identity());
  EXPECT_GT(std::abs(photo_from_pixel(camera, {10, 290})->x - 10), 1);
  // In the middle it is where it is at time 0.
  camera.distortion.motion.across = 0;
  EXPECT_NEAR(photo_from_pixel(camera, {20, 150})->x, 20, 1e-9);
  EXPECT_NEAR(pixel_from_photo(camera, {20, 150})->y, 150, 1e-9);
}

TEST(Motion, EndsWhereItHasNoPlaceOrSeveral) {
  Camera camera = moving_camera();
  camera.distortion.motion.turn = {300, 0, 0};
  EXPECT_EQ(photo_from_pixel(camera, {10, 290}), std::nullopt);
  EXPECT_EQ(largest_stretch(camera, 0.1), std::numeric_limits<double>::infinity());
  camera.distortion.motion.turn = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
  EXPECT_EQ(photo_from_pixel(camera, {10, 290}), std::nullopt);
}

TEST(Motion, StretchesNothingMoreThanTheBound) {
  for (const double scale : {0.3, 1.0, 3.0}) {
    Camera camera = moving_camera();
    for (double& v : camera.distortion.motion.turn) v *= scale;
    for (double& v : camera.distortion.motion.step) v *= scale;
    const double bound = largest_stretch(camera, 0.35);
    double largest = 0;
    for (double x = 0; x <= 400; x += 20)
      for (double y = 0; y <= 300; y += 20)
        for (int j = 0; j < 16; ++j) {
          constexpr double kStep = 1e-3;
          const double angle = j * 3.14159 / 16;
          const auto a = photo_from_pixel(camera, {x, y});
          const auto b = photo_from_pixel(camera, {x + kStep * std::cos(angle), y + kStep * std::sin(angle)});
          largest = std::max(largest, std::hypot(b->x - a->x, b->y - a->y) / kStep);
        }
    EXPECT_LE(largest, bound) << scale;
    if (scale <= 1) {
      EXPECT_LE(bound, 2 * largest) << scale;  // and it says something about photos as they are
    }
  }
}

TEST(Motion, CannotBeStatedByOtherFormats) {
  for (const SceneTarget target : {SceneTarget::colmap, SceneTarget::transforms, SceneTarget::opensfm, SceneTarget::mvs,
                                   SceneTarget::cam, SceneTarget::nvm})
    EXPECT_EQ(lost_term(target, moving_camera()), "a movement while the photo was read out (rolling shutter)");
}

TEST(Motion, TurnsAreFoundInRotations) {
  for (const std::array<double, 3>& v :
       {std::array<double, 3>{0, 0, 0}, {1e-12, 0, 0}, {0.01, -0.02, 0.015}, {2, 1, -1.5}, {0, -3.1, 0}}) {
    const auto found = angle_axis_from_rotation(*rotation_from_angle_axis({v[0], v[1], v[2]}));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], v[i], 1e-12);
  }
}

}  // namespace
}  // namespace gpvc::io
