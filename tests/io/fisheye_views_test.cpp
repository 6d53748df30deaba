// Wide fisheyes as several views.
#include "io/scenes/fisheye_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "io/vector.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A circle of 200 degrees that touches the edges of a square, 10 degrees an eighth of its radius.
View circular(LensModel model = LensModel::equidistant) {
  View view;
  view.name = "flight/fish.JPG";
  const double f = 300 / (100 * kDegree);
  view.camera = {600, 600, f, f, 300, 300, {}};
  view.camera.distortion.model = model;
  const double c = std::cos(0.7), s = std::sin(0.7);
  view.pose.rotation = {c, s, 0, 0, 0, -1, -s, c, 0};
  view.pose.centre = {10, 20, 30};
  return view;
}

View limited(View view) {
  limit_distortion(view.camera);
  return view;
}

/// The photo's radius over the focal length at an angle from the axis, from the models' definitions.
double radius(const Distortion& d, double theta) {
  const double t2 = theta * theta;
  switch (d.model) {
    case LensModel::equisolid:
      return 2 * std::sin(theta / 2);
    case LensModel::fisheye_polynomial:
      return theta * (1 + d.a1 * theta + d.a2 * t2 + d.a3 * t2 * theta);
    default:
      return theta * (1 + d.k1 * t2 + d.k2 * t2 * t2);
  }
}

/// Checks that each direction that the lens shows within `reach` is shown by a view, and by each at the place where the lens
/// has it; and that no view shows any beyond `reach`.
void expect_shown(const View& whole, double reach) {
  const std::vector<View> views = fisheye_views(whole);
  ASSERT_EQ(views.size(), 5);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int aside = 0, behind = 0;
  for (int n = 0; n < 20000; ++n) {
    const WorldPoint point{10 + normal(random), 20 + normal(random), 30 + normal(random)};
    const CameraPoint c = camera_from_world(whole.pose, point);
    const double across = std::hypot(c.x, c.y), theta = std::atan2(across, c.z),
                 r = radius(whole.camera.distortion, theta);
    const PhotoPoint expected{whole.camera.cx + whole.camera.fx * r * c.x / across,
                              whole.camera.cy + whole.camera.fy * r * c.y / across};
    const bool inside = expected.x >= 0 && expected.x <= whole.camera.width && expected.y >= 0 &&
                        expected.y <= whole.camera.height && theta <= reach;
    int count = 0;
    for (const View& view : views) {
      const CameraPoint p = camera_from_world(view.pose, point);
      if (!(p.z > 0)) continue;
      const PixelPoint pixel = pixel_from_camera(view.camera, p);
      if (pixel.x < 0 || pixel.y < 0 || pixel.x > view.camera.width || pixel.y > view.camera.height ||
          !in_photo(view.camera, pixel))
        continue;
      const PhotoPoint photo = *photo_from_pixel(view.camera, pixel);
      EXPECT_NEAR(photo.x, expected.x, 1e-9) << view.name;
      EXPECT_NEAR(photo.y, expected.y, 1e-9) << view.name;
      const auto back = pixel_from_photo(view.camera, photo);
      ASSERT_TRUE(back) << view.name << ' ' << theta;
      EXPECT_NEAR(back->x, pixel.x, 1e-6) << view.name;
      EXPECT_NEAR(back->y, pixel.y, 1e-6) << view.name;
      ++count;
      aside += view.camera.distortion.looks_aside() ? 1 : 0;
      behind += theta > std::numbers::pi / 2 ? 1 : 0;
    }
    EXPECT_EQ(count > 0, inside) << theta / kDegree << " degrees";
  }
  EXPECT_GT(aside, 1000);
  EXPECT_GT(behind, reach > 95 * kDegree ? 300 : -1);
}

TEST(FisheyeViews, ShowEveryDirectionWhereTheLensShowsIt) {
  expect_shown(limited(circular()), 100 * kDegree);
  View bent = circular();
  bent.camera.distortion.k1 = -0.02;
  bent.camera.distortion.k2 = 0.001;
  double edge = 100 * kDegree;  // where the bent radius is that of the edge
  for (int n = 0; n < 100; ++n) edge *= 100 * kDegree / radius(bent.camera.distortion, edge);
  expect_shown(limited(bent), edge);
  View solid = circular(LensModel::equisolid);
  solid.camera.fx = solid.camera.fy = 300 / (2 * std::sin(50 * kDegree));
  expect_shown(limited(solid), 100 * kDegree);
  View polynomial = circular(LensModel::fisheye_polynomial);
  polynomial.camera.distortion.a1 = 0.02;
  polynomial.camera.distortion.a2 = -0.03;
  edge = 100 * kDegree;
  for (int n = 0; n < 200; ++n) edge *= std::sqrt(100 * kDegree / radius(polynomial.camera.distortion, edge));
  expect_shown(limited(polynomial), edge);
}

// 180 degrees from corner to corner: the corners are shown, though they are farther than the edges.
TEST(FisheyeViews, ShowTheCornersOfAFullFrame) {
  View full = circular();
  const double f = std::hypot(300, 200) / (90 * kDegree);
  full.camera = {600, 400, f, f, 300, 200, full.camera.distortion};
  expect_shown(limited(full), 91 * kDegree);
}

TEST(FisheyeViews, KeepTheirPhotosName) {
  const std::vector<View> views = fisheye_views(limited(circular()));
  const char* names[] = {"flight/fish.JPG", "flight/fish/right.JPG", "flight/fish/left.JPG", "flight/fish/down.JPG",
                         "flight/fish/up.JPG"};
  const CameraPoint axes[] = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (std::size_t v = 0; v < 5; ++v) {
    EXPECT_EQ(views[v].name, names[v]);
    EXPECT_EQ(photo_name(views[v]), "flight/fish.JPG");
    // Each sees what lies straight to its side.
    const auto& r = circular().pose.rotation;
    const CameraPoint a = axes[v];
    const WorldPoint p{10 + r[0] * a.x + r[3] * a.y + r[6] * a.z, 20 + r[1] * a.x + r[4] * a.y + r[7] * a.z,
                       30 + r[2] * a.x + r[5] * a.y + r[8] * a.z};
    const CameraPoint seen = camera_from_world(views[v].pose, p);
    ASSERT_GT(seen.z, 0) << names[v];
    EXPECT_TRUE(in_photo(views[v].camera, pixel_from_camera(views[v].camera, seen))) << names[v];
  }
}

TEST(FisheyeViews, AreOneWhereTheFrameShowsMostOfThePhoto) {
  View narrow = circular();
  narrow.camera.fx = narrow.camera.fy = 300 / (40 * kDegree);
  EXPECT_EQ(fisheye_views(limited(narrow)).size(), 1);
  View wide = circular();
  wide.camera.distortion.model = LensModel::brown;
  EXPECT_EQ(fisheye_views(limited(wide)).size(), 1);
  View unknown = circular();
  unknown.camera.width = unknown.camera.height = 0;
  EXPECT_EQ(fisheye_views(unknown).size(), 1);
}

// A lens whose radius shrinks again from 100 degrees on, short of the photo's edges, means nothing farther away.
TEST(FisheyeViews, EndWhereTheLensFoldsBack) {
  View folded = circular();
  folded.camera.distortion.k1 = -1 / (3 * 100 * kDegree * 100 * kDegree);
  folded.camera.fx = folded.camera.fy = 300 / (70 * kDegree);
  const std::vector<View> views = fisheye_views(limited(folded));
  ASSERT_EQ(views.size(), 5);
  EXPECT_NEAR(views[1].camera.distortion.max_angle, 100 * kDegree, 1e-6);
}

TEST(FisheyeViews, MoveWithTheirCamera) {
  View moving = circular();
  moving.camera.distortion.motion = {.across = 0, .down = 1, .turn = {0.02, -0.03, 0.01}, .step = {0.1, 0.2, -0.05}};
  const std::vector<View> views = fisheye_views(limited(moving));
  ASSERT_EQ(views.size(), 5);
  int both = 0;
  for (double x = 20; x < 600; x += 40)
    for (double y = 20; y < 600; y += 40) {
      const auto front = pixel_from_photo(views[0].camera, {x, y});
      if (!front) continue;
      const WorldPoint ray = ray_of(views[0], *front);
      const WorldPoint point{10 + ray.x, 20 + ray.y, 30 + ray.z};
      for (std::size_t v = 1; v < 5; ++v) {
        const CameraPoint p = camera_from_world(views[v].pose, point);
        if (!(p.z > 0.2)) continue;
        const auto photo = photo_from_pixel(views[v].camera, pixel_from_camera(views[v].camera, p));
        ASSERT_TRUE(photo);
        EXPECT_NEAR(photo->x, x, 1e-6) << views[v].name;
        EXPECT_NEAR(photo->y, y, 1e-6) << views[v].name;
        ++both;
      }
    }
  EXPECT_GT(both, 100);
}

class FisheyeFolder {
 public:
  FisheyeFolder() {
    folder.write("cameras.txt", "1 OPENCV_FISHEYE 120 120 34.4 34.4 60 60 0 0 0 0\n");
    folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n\n");
    test::write_photo(folder.path() / "images/a.jpg", 120, 120);
  }
  test::TemporaryFolder folder;
};

// Photos are lit up to 55 of 60 pixels from their middle; one of them is of a dark room.
TEST(FisheyeViews, EndWhereThePhotosGetDark) {
  const FisheyeFolder files;
  files.folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 0 0 1 b.png\n\n");
  for (const char* name : {"a.png", "b.png"}) {
    Image photo{120, 120, 3, std::vector<std::uint8_t>(std::size_t{3} * 120 * 120, 9)};
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x)
        if (name[0] == 'b' && std::hypot(x - 59.5, y - 59.5) < 55) photo.at(x, y)[1] = 90;
    write_image(files.folder.path() / "images" / name, photo, ImageFormat::png, 0);
  }
  const Scene scene = read_scene(files.folder.path(), {});
  ASSERT_EQ(scene.views.size(), 10);
  for (const View& view : scene.views)
    EXPECT_NEAR(view.camera.distortion.max_angle, 55 / 34.4 * 0.99, 0.5 / 34.4) << view.name;
  EXPECT_FALSE(pixel_from_photo(scene.views[2].camera, {60 - 56, 60}));  // a/left.png
  EXPECT_TRUE(pixel_from_photo(scene.views[2].camera, {60 - 53, 60}));
}

// The same in 12 bits, of which the brightest are 1440 of 65535.
TEST(FisheyeViews, EndWherePhotosOfMoreBitsGetDark) {
  const FisheyeFolder files;
  files.folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.tif\n\n2 1 0 0 0 1 0 0 1 b.tif\n\n");
  BandSet set;
  set.bands = {{"NIR"}};
  for (const char* name : {"a.tif", "b.tif"}) {
    Samples photo{120, 120, 1, SampleType::u16, std::vector<std::byte>(std::size_t{2} * 120 * 120)};
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x) {
        const bool lit = name[0] == 'b' && std::hypot(x - 59.5, y - 59.5) < 55;
        store_sample(photo.at(x, y), SampleType::u16, static_cast<float>((lit ? 1440 : 60) + (x + y) % 7));
      }
    write_samples(files.folder.path() / "images" / name, photo, set);
  }
  const Scene scene = read_scene(files.folder.path(), {});
  for (const View& view : scene.views)
    EXPECT_NEAR(view.camera.distortion.max_angle, 55 / 34.4 * 0.99, 0.5 / 34.4) << view.name;
}

TEST(FisheyeViews, OfASmallImageCircleEndThereAheadToo) {
  View small = circular();
  small.camera.fx = small.camera.fy = 300;
  View whole = limited(small);
  whole.camera.distortion.max_angle = 70 * kDegree;
  const std::vector<View> views = fisheye_views(whole);
  ASSERT_EQ(views.size(), 5);
  EXPECT_TRUE(photo_from_pixel(views[0].camera, {300 + 300 * std::tan(69 * kDegree), 300}));
  EXPECT_FALSE(photo_from_pixel(views[0].camera, {300 + 300 * std::tan(71 * kDegree), 300}));
}

// A circle of 60 degrees on a sensor that would show 95: no view looks aside, and what is dark is still no photo.
TEST(FisheyeViews, OfACircleThatTheFrameShowsEndThere) {
  View small = circular();
  ASSERT_EQ(fisheye_views(limited(small)).size(), 5);
  View whole = limited(small);
  whole.camera.distortion.max_angle = 30 * kDegree;
  const std::vector<View> views = fisheye_views(whole);
  ASSERT_EQ(views.size(), 1);
  const double f = small.camera.fx, c = small.camera.cx;
  EXPECT_TRUE(photo_from_pixel(views[0].camera, {c + f * std::tan(29 * kDegree), c}));
  EXPECT_FALSE(photo_from_pixel(views[0].camera, {c + f * std::tan(31 * kDegree), c}));
}

TEST(FisheyeViews, NeedNoDamagedPhotoThatIsLeftOut) {
  const FisheyeFolder files;
  files.folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 0 0 1 b.png\n\n");
  const Image photo{120, 120, 3, std::vector<std::uint8_t>(std::size_t{3} * 120 * 120, 99)};
  for (const char* name : {"a.png", "b.png"})
    write_image(files.folder.path() / "images" / name, photo, ImageFormat::png, 0);
  std::string bytes = test::read_file(files.folder.path() / "images/a.png");
  for (std::size_t at = bytes.find("IDAT") + 8; at < bytes.size() - 20; ++at) bytes[at] = '\x55';
  files.folder.write("images/a.png", bytes);
  SceneOptions options;
  EXPECT_TRUE(test::contains(test::input_error([&] { read_scene(files.folder.path(), options); }), "a.png"));
  options.needed = [](std::span<const View> views) {
    std::vector<bool> needed;
    for (const View& view : views) needed.push_back(view.name.starts_with("b"));
    return needed;
  };
  EXPECT_EQ(read_scene(files.folder.path(), options).views.size(), 10);
}

TEST(FisheyeViews, ShareTheirPhoto) {
  const FisheyeFolder files;
  const Scene scene = read_scene(files.folder.path(), {});
  ASSERT_EQ(scene.views.size(), 5);
  PhotoCache photos(scene, std::size_t{1} << 24);
  EXPECT_EQ(photos.photo(ViewId{0}), photos.photo(ViewId{4}));
  EXPECT_EQ(photos.photo(ViewId{0})->width, 120);
}

// A cache hashes a photo when it first reads it, which is after the scene was read.
TEST(FisheyeViews, RefuseAPhotoThatChangesAfterItsCircleWasFound) {
  const FisheyeFolder files;
  const Scene scene = read_scene(files.folder.path(), {});
  EXPECT_EQ(PhotoCache(scene).photo(ViewId{4})->width, 120);
  const Image other{120, 120, 3, std::vector<std::uint8_t>(std::size_t{3} * 120 * 120, 99)};
  write_image(files.folder.path() / "images/a.jpg", other, ImageFormat::png, 0);
  PhotoCache photos(scene);
  const std::string sentence = "a.jpg: has changed since the image circle of its lens was found in it";
  EXPECT_TRUE(test::contains(test::input_error([&] { photos.photo(ViewId{4}); }), sentence));
  EXPECT_TRUE(test::contains(test::input_error([&] { photos.key(ViewId{0}); }), sentence));
}

TEST(FisheyeViews, AreOneForWriting) {
  const FisheyeFolder files;
  const Scene scene = read_scene(files.folder.path(), {.whole_fisheyes = true});
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_FALSE(lost_term(SceneTarget::colmap, scene.views[0].camera));
  const Scene parts = read_scene(files.folder.path(), {});
  EXPECT_TRUE(lost_term(SceneTarget::colmap, parts.views[1].camera));
}

}  // namespace
}  // namespace gpvc::io
