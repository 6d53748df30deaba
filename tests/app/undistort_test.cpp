// The frames of undistorted photos, against the lens itself.
#include "app/pipeline/undistort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/scene_files.h"

namespace gpvc {
namespace {

std::vector<Camera> distorted_cameras() {
  std::vector<Camera> cameras;
  const auto add = [&](const Distortion& distortion) {
    cameras.push_back({400, 300, 350, 355, 210, 144, distortion});
    limit_distortion(cameras.back());
  };
  add({.k1 = -0.2, .k2 = 0.05, .model = LensModel::brown});
  add({.k1 = 0.15, .model = LensModel::brown});
  add({.k1 = -0.1, .p1 = 0.01, .p2 = -0.02, .model = LensModel::brown});
  add({.k1 = -0.9, .model = LensModel::brown});  // folds within the photo
  add({.k1 = -0.1, .model = LensModel::perspective, .d1 = 0.05, .skew = 0.01});
  add({.k1 = 0.02, .model = LensModel::equidistant});
  add({.model = LensModel::fov, .omega = 0.9});
  return cameras;
}

TEST(FrameWindow, InsideShowsThePhotoEverywhereAndNoMoreFits) {
  for (const Camera& camera : distorted_cameras()) {
    const pipeline::FrameWindow w = pipeline::frame_window(camera, pipeline::FrameRule::inside);
    ASSERT_GT(w.width, camera.width / 2);
    ASSERT_GT(w.height, camera.height / 2);
    for (int y = w.y; y < w.y + w.height; ++y)
      for (int x = w.x; x < w.x + w.width; ++x) ASSERT_TRUE(in_photo(camera, {x + 0.5, y + 0.5})) << x << ", " << y;
  }
  const Camera barrel = distorted_cameras()[0], pincushion = distorted_cameras()[1];
  const pipeline::FrameWindow wide = pipeline::frame_window(barrel, pipeline::FrameRule::inside),
                              narrow = pipeline::frame_window(pincushion, pipeline::FrameRule::inside);
  EXPECT_GT(wide.width, barrel.width);
  EXPECT_LT(narrow.width, pincushion.width);
  // One more column to the left is blank somewhere, though not at the corners alone.
  bool blank = false;
  for (int y = 0; y < barrel.height; ++y) blank = blank || !in_photo(barrel, {wide.x - 0.5, y + 0.5});
  EXPECT_TRUE(blank);
}

TEST(FrameWindow, AllKeepsEveryPixelOfThePhotoWithinBounds) {
  for (const Camera& camera : distorted_cameras()) {
    const pipeline::FrameWindow w = pipeline::frame_window(camera, pipeline::FrameRule::all);
    EXPECT_LE(w.width, 2 * camera.width);
    EXPECT_LE(w.height, 2 * camera.height);
    std::size_t beyond = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const auto p = pixel_from_photo(camera, {x + 0.5, y + 0.5});
        beyond += !p || p->x < w.x || p->y < w.y || p->x > w.x + w.width || p->y > w.y + w.height;
      }
    // Only what the model shows nowhere, behind its fold, is left out.
    if (camera.distortion.k1 > -0.5) {
      EXPECT_EQ(beyond, 0u);
    }
  }
}

TEST(FrameWindow, CentredOnesKeepTheirRulesAndDirections) {
  std::vector<Camera> cameras = distorted_cameras();
  cameras.push_back({400, 300, 350, 355, 210, 144, {}});
  cameras.push_back({400, 300, 360, 340, 190, 150, {}});
  for (const Camera& camera : cameras)
    for (const pipeline::FrameRule rule :
         {pipeline::FrameRule::inside, pipeline::FrameRule::keep, pipeline::FrameRule::all}) {
      const pipeline::FrameWindow w = pipeline::frame_window(camera, rule, true);
      const Camera square = pipeline::camera_of_window(camera, w);
      EXPECT_EQ(io::lost_term(io::SceneTarget::nvm, square), std::nullopt);
      ASSERT_GT(w.width, camera.width / 2);
      ASSERT_LE(w.width, 2 * camera.width);
      ASSERT_LE(w.height, 2 * camera.height);
      for (int y = 0; y < w.height; ++y)
        for (int x = 0; x < w.width; ++x) {
          const PixelPoint p = pipeline::frame_position(camera, w, x, y);
          ASSERT_NEAR((p.x - camera.cx) / camera.fx, (x + 0.5 - square.cx) / square.fx, 1e-12);
          ASSERT_NEAR((p.y - camera.cy) / camera.fy, (y + 0.5 - square.cy) / square.fy, 1e-12);
          if (rule == pipeline::FrameRule::inside) {
            ASSERT_TRUE(in_photo(camera, p)) << x << ", " << y;
          }
        }
      if (rule != pipeline::FrameRule::all || camera.distortion.k1 < -0.5) continue;
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
          const auto p = pixel_from_photo(camera, {x + 0.5, y + 0.5});
          ASSERT_TRUE(p);
          ASSERT_LE(std::abs((p->x - camera.cx) / camera.fx * square.fx), w.width / 2.0);
          ASSERT_LE(std::abs((p->y - camera.cy) / camera.fy * square.fy), w.height / 2.0);
        }
    }
}

TEST(FrameWindow, IsThePhotosOwnOtherwise) {
  const Camera pinhole{96, 72, 80.25, 81.5, 47.125, 36.75, {}};
  const Camera camera = distorted_cameras()[0];
  const pipeline::FrameWindow own{0, 0, camera.width, camera.height};
  EXPECT_EQ(pipeline::frame_window(camera, pipeline::FrameRule::keep), own);
  for (const pipeline::FrameRule rule :
       {pipeline::FrameRule::inside, pipeline::FrameRule::keep, pipeline::FrameRule::all}) {
    const pipeline::FrameWindow window = pipeline::frame_window(pinhole, rule);
    EXPECT_EQ(window, (pipeline::FrameWindow{0, 0, 96, 72}));
    EXPECT_EQ(pipeline::camera_of_window(pinhole, window), pinhole);
  }
}

}  // namespace
}  // namespace gpvc
