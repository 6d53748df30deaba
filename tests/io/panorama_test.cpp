// Equirectangular photos as six views.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "io/bilinear.h"
#include "io/images.h"
#include "io/images/mask_file.h"
#include "io/lens/spherical.h"
#include "io/photo_pixel.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "io/scenes/panorama_views.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;

constexpr int kAround = 160, kDown = 80;
constexpr double kHalfTurn = std::numbers::pi;

View panorama() {
  View view;
  view.name = "flight/pano.JPG";
  view.camera = test::panorama_of(kAround, kDown, kDown / kHalfTurn);
  const double c = std::cos(0.7), s = std::sin(0.7);
  view.pose.rotation = {c, s, 0, 0, 0, -1, -s, c, 0};  // looks horizontally in a world with z up
  view.pose.centre = {10, 20, 30};
  return view;
}

/// Where COLMAP's EQUIRECTANGULAR model shows a point of the camera, x right, y down, z forward.
PhotoPoint shown_at(const CameraPoint& p) {
  const double theta = std::atan2(p.x, p.z), phi = std::atan2(-p.y, std::hypot(p.x, p.z));
  return {(theta / (2 * kHalfTurn) + 0.5) * kAround, (0.5 - phi / kHalfTurn) * kDown};
}

TEST(PanoramaViews, ShowEveryDirectionWhereThePanoramaShowsIt) {
  const View whole = panorama();
  const std::vector<View> views = views_of(whole);
  ASSERT_EQ(views.size(), 6);
  EXPECT_EQ(views[0].name, "flight/pano/front.JPG");
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::array<int, 6> seen{};
  int several = 0;
  constexpr int kDirections = 20000;
  for (int n = 0; n < kDirections; ++n) {
    const WorldPoint point{10 + normal(random), 20 + normal(random), 30 + normal(random)};
    const PhotoPoint expected = shown_at(camera_from_world(whole.pose, point));
    int count = 0;
    for (std::size_t v = 0; v < 6; ++v) {
      const CameraPoint c = camera_from_world(views[v].pose, point);
      if (!(c.z > 0)) continue;
      const PixelPoint pixel = pixel_from_camera(views[v].camera, c);
      if (!in_photo(views[v].camera, pixel)) continue;
      const PhotoPoint photo = *photo_from_pixel(views[v].camera, pixel);
      // Columns of the picture that the view takes begin before those of the panorama, and go on behind.
      const double turns = (photo.x - columns_before(kAround) - expected.x) / kAround;
      EXPECT_NEAR(turns, std::round(turns), 1e-11) << views[v].name;
      const double taken = taken_pixel(views[v], photo).x;
      EXPECT_TRUE(taken >= 0 && taken <= kAround) << taken;
      EXPECT_NEAR(std::remainder(taken - expected.x, kAround), 0, 1e-9) << views[v].name;
      EXPECT_NEAR(photo.y, expected.y, 1e-9) << views[v].name;
      const auto back = pixel_from_photo(views[v].camera, photo);
      ASSERT_TRUE(back) << views[v].name;
      EXPECT_NEAR(back->x, pixel.x, 1e-8) << views[v].name;
      EXPECT_NEAR(back->y, pixel.y, 1e-8) << views[v].name;
      // Frames of 90 degrees lie in it, on the side of the cube that is meant.
      ++seen[v];
      ++count;
    }
    EXPECT_GE(count, 1);
    several += count > 1 ? 1 : 0;
  }
  // A cap of 56.3 degrees is (1 - cos) / 2 = 0.2227 of the sphere; the frame cuts some of the back view's.
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(seen[v] / double{kDirections}, v == 2 ? 0.215 : 0.2227, 0.01) << v;
  EXPECT_GT(several, kDirections / 4);
}

TEST(PanoramaViews, LookTheWayTheyAreCalled) {
  View view = panorama();
  view.pose = {};
  const std::vector<View> views = views_of(view);
  const WorldPoint axes[] = {{0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {-1, 0, 0}, {0, -1, 0}, {0, 1, 0}};
  const char* names[] = {"front", "right", "back", "left", "up", "down"};
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_EQ(views[v].name, "flight/pano/" + std::string(names[v]) + ".JPG");
    EXPECT_EQ(camera_from_world(views[v].pose, axes[v]).z, 1) << names[v];
    EXPECT_EQ(photo_name(views[v]), "flight/pano.JPG");
  }
}

// Neighbours in a frame are neighbours in the picture, except about the poles.
TEST(PanoramaViews, ContinueAcrossTheSidesOfThePanorama) {
  for (const View& view : views_of(panorama())) {
    double longest = 0;
    for (int y = 0; y < view.camera.height; ++y)
      for (int x = 0; x + 1 < view.camera.width; ++x) {
        const auto a = photo_from_pixel(view.camera, {x + 0.5, y + 0.5}),
                   b = photo_from_pixel(view.camera, {x + 1.5, y + 0.5});
        if (a && b) longest = std::max(longest, std::hypot(a->x - b->x, a->y - b->y));
      }
    if (shows_pole(view.camera.distortion.model))
      EXPECT_GT(longest, kAround / 4) << view.name;
    else
      EXPECT_LE(longest, largest_stretch(view.camera, 1)) << view.name;
  }
}

TEST(PanoramaViews, RepeatColumns) {
  Image image{32, 2, 3, std::vector<std::uint8_t>(3 * 32 * 2)};
  PhotoExclusion excluded = {32, 2, 1, {1u << 31, 1u}};
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 32; ++x) image.at(x, y)[1] = static_cast<std::uint8_t>(100 * y + x);
  const Image around = continue_around(image);
  const PhotoExclusion mask = continue_around(excluded);
  ASSERT_EQ(around.width, 2 + 32 + 6);
  ASSERT_EQ(mask.width, around.width);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < around.width; ++x) {
      EXPECT_EQ(around.at(x, y)[1], 100 * y + (x + 30) % 32);
      EXPECT_EQ(mask.excludes(x, y), (x + 30) % 32 == (y == 0 ? 31 : 0));
    }
}

// Colours are interpolated between the last and the first column: 4 levels a pixel there.
TEST(PanoramaViews, InterpolateAcrossTheSidesOfThePanorama) {
  const auto level = [](double column) { return 127 + 100 * std::sin(2 * kHalfTurn * column / kAround); };
  Image image{kAround, kDown, 3, std::vector<std::uint8_t>(3 * kAround * kDown)};
  for (int y = 0; y < kDown; ++y)
    for (int x = 0; x < kAround; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(level(x + 0.5)));
  const Image photo = continue_around(image);
  for (const View& view : views_of(panorama()))
    for (double y = 0.5; y < view.camera.height; y += 3)
      for (double x = 0.25; x < view.camera.width; x += 0.75) {
        const auto q = photo_from_pixel(view.camera, {x, y});
        if (!q || !in_photo(view.camera, {x, y})) continue;
        const double expected = level(q->x - columns_before(kAround));
        // Half a level of rounding, and that of the interpolation: (4 levels)^2 / 8 / 100.
        ASSERT_NEAR(bilinear(photo, q->x, q->y)[0], expected, 0.5 + 0.02) << view.name << " " << q->x;
      }
}

/// A COLMAP model of one panorama, whose pixels count up.
struct PanoramaFolder {
  PanoramaFolder() {
    folder.write("cameras.txt", "1 EQUIRECTANGULAR 160 80 160 80\n2 PINHOLE 40 30 50 50 20 15\n");
    folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 2 3 2 a.jpg\n\n");
    image = {kAround, kDown, 3, {}};
    for (int i = 0; i < 3 * kAround * kDown; ++i) image.pixels.push_back(static_cast<std::uint8_t>(i * 7 / 3));
    test::write_photo(folder.path() / "images/a.jpg", 40, 30);
    write_image(folder.path() / "images/a.png", image, ImageFormat::png, 0);
  }
  TemporaryFolder folder;
  Image image;
};

TEST(PanoramaViews, AreReadOfOnePhoto) {
  const PanoramaFolder files;
  Image mask{kAround, kDown, 3, std::vector<std::uint8_t>(files.image.pixels.size(), 255)};
  for (int c = 0; c < 3; ++c) mask.at(3, 40)[c] = 0;
  write_image(files.folder.path() / "images/a.png.mask.png", mask, ImageFormat::png, 0);
  const Scene scene = read_scene(files.folder.path(), {});
  ASSERT_EQ(scene.views.size(), 7);
  EXPECT_EQ(scene.views[0].name, "a.jpg");
  EXPECT_EQ(scene.views[1].name, "a/back.png");
  EXPECT_EQ(scene.views[6].name, "a/up.png");
  PhotoCache cache(scene, std::size_t{1} << 20);
  const auto photo = cache.photo(ViewId{1});
  EXPECT_EQ(photo->width, scene.views[1].camera.width);
  EXPECT_EQ(photo->height, kDown);
  for (std::uint32_t v = 2; v < 7; ++v) EXPECT_EQ(cache.photo(ViewId{v}), photo);
  EXPECT_EQ(photo->at(columns_before(kAround) + 100, 20)[0], files.image.at(100, 20)[0]);
  EXPECT_EQ(photo->at(columns_before(kAround) + kAround + 5, 20)[0], files.image.at(5, 20)[0]);
  const auto exclusion = cache.exclusion(ViewId{1});
  ASSERT_TRUE(exclusion);
  EXPECT_EQ(exclusion->width, photo->width);
  EXPECT_TRUE(exclusion->excludes(columns_before(kAround) + 3, 40));
  EXPECT_TRUE(exclusion->excludes(columns_before(kAround) + kAround + 3, 40));
  EXPECT_FALSE(exclusion->excludes(columns_before(kAround) + 4, 40));
}

TEST(PanoramaViews, AreReducedWithTheirPhoto) {
  const PanoramaFolder files;
  const Scene scene = read_scene(files.folder.path(), {.downscale = 2});
  const View& view = scene.views[1];
  EXPECT_EQ(view.camera.width, kAround / 2 + columns_before(kAround / 2) + columns_behind(kAround / 2));
  EXPECT_EQ(file_width(view.camera), kAround / 2);
  EXPECT_EQ(PhotoCache(scene).photo(ViewId{1})->width, view.camera.width);
  EXPECT_TRUE(contains(input_error([&] { read_scene(files.folder.path(), {.downscale = 3}); }),
                       "a.png: is a panorama 160 pixels wide, which cannot be reduced by 3"));
}

TEST(PanoramaViews, NeedTheirPhotoTogether) {
  const PanoramaFolder files;
  std::filesystem::remove(files.folder.path() / "images/a.png");
  const auto read_needing = [&](const std::string& name) {
    SceneOptions options;
    options.needed = [&](std::span<const View> views) {
      EXPECT_EQ(views.size(), 7);
      std::vector<bool> needed;
      for (const View& view : views) needed.push_back(view.name == name);
      return needed;
    };
    return read_scene(files.folder.path(), options);
  };
  EXPECT_EQ(read_needing("a.jpg").views.size(), 7);
  EXPECT_TRUE(contains(input_error([&] { read_needing("a/left.png"); }), "photos are not in"));
  files.folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 2 3 2 a/up.png\n\n");
  test::write_photo(files.folder.path() / "images/a/up.png", 40, 30);
  write_image(files.folder.path() / "images/a.png", files.image, ImageFormat::png, 0);
  EXPECT_TRUE(contains(input_error([&] { read_scene(files.folder.path(), {}); }),
                       "lists two images of which 'a/up.png' would be a view"));
}

}  // namespace
}  // namespace gpvc::io
