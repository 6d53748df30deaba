// Bands that a scene has cameras of their own for, against where a plane is shown by each.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "io/images.h"
#include "io/photo_pixel.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiff_photo.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kDepth = 10;  // of the plane, in front of cameras that look along z

/// Smooth noise with detail of a few pixels.
double texture(double x, double y) {
  double sum = 0;
  for (const double cell : {5.0, 9.0, 17.0, 40.0}) {
    const double u = x / cell, v = y / cell, i = std::floor(u), j = std::floor(v);
    const auto node = [&](double a, double b) {
      const double s = std::sin((i + a) * 127.1 + (j + b) * 311.7 + cell) * 43758.5453;
      return s - std::floor(s);
    };
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double s = smooth(u - i), t = smooth(v - j);
    sum += (1 - t) * ((1 - s) * node(0, 0) + s * node(1, 0)) + t * ((1 - s) * node(0, 1) + s * node(1, 1));
  }
  return sum / 4;
}

/// One lens of the rig: a turn about an axis, in degrees, and where it is beside the first.
struct Lens {
  double fx, fy, cx, cy, k1;
  double turn_x, turn_y, turn_z;
  WorldPoint centre;
};

const Lens kFirst{300, 300, 160, 120, -0.05, 0, 0, 0, {0, 0, 0}};
const Lens kLenses[] = {kFirst,
                        {312, 312, 163, 118, -0.11, 0.5, -0.3, 0, {0.4, 0, 0}},
                        {294, 294, 158, 123, 0.02, -0.2, 0.1, 0.5, {0, 0.4, 0.02}}};

/// Half the turn as a quaternion, for small turns: w, x, y, z.
std::array<double, 4> quaternion(const Lens& lens) {
  const double half = 3.14159265358979323846 / 360;
  const double x = lens.turn_x * half, y = lens.turn_y * half, z = lens.turn_z * half;
  return {std::sqrt(1 - x * x - y * y - z * z), x, y, z};
}

View view_of(const Lens& lens, const WorldPoint& rig) {
  View view;
  view.camera = {kWidth, kHeight, lens.fx, lens.fy, lens.cx, lens.cy, {}};
  view.camera.distortion.k1 = lens.k1;
  limit_distortion(view.camera);
  const auto [w, x, y, z] = quaternion(lens);
  view.pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  view.pose.centre = {rig.x + lens.centre.x, rig.y + lens.centre.y, rig.z + lens.centre.z};
  return view;
}

/// What the photo shows at a place of it: a point of the plane.
WorldPoint on_plane(const View& view, const PhotoPoint& p) {
  const PixelPoint q = *pixel_from_photo(view.camera, p);
  const auto& r = view.pose.rotation;
  const double x = (q.x - view.camera.cx) / view.camera.fx, y = (q.y - view.camera.cy) / view.camera.fy;
  const WorldPoint ray{r[0] * x + r[3] * y + r[6], r[1] * x + r[4] * y + r[7], r[2] * x + r[5] * y + r[8]};
  const double far = (kDepth - view.pose.centre.z) / ray.z;
  return {view.pose.centre.x + far * ray.x, view.pose.centre.y + far * ray.y, kDepth};
}

Samples photo_of(const View& view, std::size_t band) {
  Samples samples{kWidth, kHeight, 1, SampleType::u16, {}};
  samples.bytes.resize(2 * pixel_index(0, kHeight, kWidth));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const WorldPoint p = on_plane(view, {x + 0.5, y + 0.5});
      const double value = texture(30 * p.x, 30 * p.y);
      store_sample(samples.at(x, y), SampleType::u16,
                   static_cast<float>(band % 2 == 0 ? 10000 + 40000 * value : 60000 - 30000 * value));
    }
  return samples;
}

/// A flight of a rig in COLMAP's format, with photos IMG_0001_1.tif and so on.
class RigScene {
 public:
  explicit RigScene(double spacing = 5, std::size_t photos = 3) {
    for (std::size_t n = 0; n < photos; ++n)
      for (std::size_t b = 0; b < std::size(kLenses); ++b) {
        rig_.push_back({static_cast<double>(n) * spacing, 0, 0});
        views_.push_back(view_of(kLenses[b], rig_.back()));
        views_.back().name = "IMG_000" + std::to_string(n + 1) + "_" + std::to_string(b + 1) + ".tif";
        test::write_tiff(place(views_.back().name), photo_of(views_.back(), b));
      }
    write_model([](const std::string&) { return true; });
  }
  /// \param copies all bands have the camera and the pose of the first
  void write_model(const std::function<bool(const std::string&)>& lists, bool copies = false) const {
    std::string cameras, images;
    for (std::size_t b = 0; b < std::size(kLenses); ++b) {
      const Lens& lens = kLenses[b];
      cameras += std::to_string(b + 1) + " OPENCV 320 240 " + std::to_string(lens.fx) + " " + std::to_string(lens.fy) +
                 " " + std::to_string(lens.cx) + " " + std::to_string(lens.cy) + " " + std::to_string(lens.k1) +
                 " 0 0 0\n";
    }
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!lists(views_[i].name)) continue;
      const std::size_t lens = copies ? 0 : i % std::size(kLenses);
      const View as = view_of(kLenses[lens], rig_[i]);
      const CameraPoint t = camera_from_world(as.pose, {0, 0, 0});
      images += std::to_string(i + 1);
      const auto add = [&](double value) {
        std::array<char, 40> text;
        std::snprintf(text.data(), text.size(), " %.17g", value);
        images += text.data();
      };
      for (const double q : quaternion(kLenses[lens])) add(q);
      for (const double v : {t.x, t.y, t.z}) add(v);
      images += " " + std::to_string(lens + 1) + " " + views_[i].name + "\n\n";
    }
    folder_.write("sparse/0/cameras.txt", cameras);
    folder_.write("sparse/0/images.txt", images);
  }
  Scene read(const SceneOptions& options = {}) const { return read_scene(folder_.path(), options); }
  std::filesystem::path place(const std::string& name) const { return folder_.path() / "images" / name; }
  const View& view(std::size_t photo, std::size_t band) const { return views_[photo * std::size(kLenses) + band]; }

 private:
  test::TemporaryFolder folder_;
  std::vector<WorldPoint> rig_;
  std::vector<View> views_;
};

bool has_warning(const Scene& scene, const std::string& part) {
  for (const std::string& warning : scene.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

/// The farthest that a band of a view lies from where its own camera shows what the photo shows.
double farthest(const RigScene& rig, const View& view, std::size_t photo, std::size_t band, double nearness) {
  double most = 0;
  for (double x = 15; x < kWidth; x += 29)
    for (double y = 15; y < kHeight; y += 29) {
      const auto truth = photo_from_world(rig.view(photo, band), on_plane(rig.view(photo, 0), {x, y}));
      const auto found = place_in_file(view.band_cameras[band], nearness, {x, y});
      most = std::max(most, std::hypot(found->x - truth->x, found->y - truth->y));
    }
  return most;
}

TEST(BandViews, LieWhereTheirCamerasShowThem) {
  const RigScene rig;
  const Scene scene = rig.read();
  ASSERT_EQ(scene.views.size(), 3u);
  ASSERT_TRUE(scene.bands);
  ASSERT_EQ(scene.bands->bands.size(), 3u);
  ASSERT_EQ(scene.band_places.size(), 3u);
  PhotoCache cache(scene, 0);
  for (std::size_t photo = 0; photo < 3; ++photo) {
    const View& view = scene.views[photo];
    EXPECT_EQ(view.name, rig.view(photo, 0).name);
    ASSERT_EQ(view.band_files.size(), 3u);
    EXPECT_EQ(view.band_files[2], rig.place(rig.view(photo, 2).name));
    ASSERT_EQ(view.band_cameras.size(), 3u);
    const auto samples = cache.samples(ViewId{static_cast<std::uint32_t>(photo)});
    const auto excluded = cache.exclusion(ViewId{static_cast<std::uint32_t>(photo)});
    for (const std::size_t band : {1u, 2u}) {
      EXPECT_LT(farthest(rig, view, photo, band, 1 / kDepth), 1e-3);
      EXPECT_LT(farthest(rig, view, photo, band, scene.band_places[band].nearness), 0.2);
      ASSERT_TRUE(scene.band_places[band].error_px);
      EXPECT_LT(*scene.band_places[band].error_px, 0.2);
      // Samples of the band against the same point's in the first.
      double sum = 0, count = 0;
      for (int y = 5; y < kHeight - 5; ++y)
        for (int x = 5; x < kWidth - 5; ++x) {
          if (excluded && excluded->excludes(x, y)) continue;
          const double first = double{load_sample(samples->at(x, y), SampleType::u16)},
                       other = double{load_sample(samples->at(x, y) + 2 * band, SampleType::u16)};
          const double expected = band == 1 ? 60000 - 30000 * (first - 10000) / 40000 : first;
          sum += std::abs(other - expected);
          ++count;
        }
      EXPECT_GT(count, 0.7 * kWidth * kHeight);
      EXPECT_LT(sum / count, 0.01 * 40000) << band;
    }
    for (int y = 0; y < kHeight; ++y) EXPECT_TRUE(excluded->excludes(0, y));  // the second shows nothing there
  }
  EXPECT_NEAR(scene.band_places[1].nearness, 1 / kDepth, 0.004);
}

TEST(BandViews, StayPhotosWhereTheSceneIsWrittenOrNamesCountForNothing) {
  const RigScene rig;
  for (const bool listed : {true, false}) {
    SceneOptions options;
    options.bands_as_listed = listed;
    options.bands_by_name = listed;
    const Scene scene = rig.read(options);
    EXPECT_EQ(scene.views.size(), 9u);
    for (const View& view : scene.views) EXPECT_TRUE(view.band_files.empty());
  }
}

TEST(BandViews, ThatLieAsFarApartAsPhotosStayPhotos) {
  const RigScene rig(1);
  const Scene scene = rig.read();
  EXPECT_EQ(scene.views.size(), 9u);
  EXPECT_TRUE(has_warning(scene, "cameras that lie as far apart as those of different photos"));
}

// As OpenDroneMap lists the bands of a rig: the first one's camera and pose again, wherever the others look.
TEST(BandViews, ThatAreCopiesAreRegisteredByTheirPictures) {
  const RigScene rig;
  rig.write_model([](const std::string&) { return true; }, true);
  const Scene scene = rig.read();
  ASSERT_EQ(scene.views.size(), 3u);
  EXPECT_EQ(scene.views[0].band_files.size(), 3u);
  EXPECT_TRUE(scene.views[0].band_cameras.empty());
  EXPECT_TRUE(scene.band_places[1].moves());
  EXPECT_LT(*scene.band_places[1].error_px, 1);
}

TEST(BandViews, WithoutACameraTakeThatOfTheRig) {
  const RigScene rig;
  rig.write_model([](const std::string& name) { return name != "IMG_0002_3.tif"; });
  const Scene scene = rig.read();
  ASSERT_EQ(scene.views.size(), 3u);
  ASSERT_EQ(scene.views[1].band_files.size(), 3u);
  EXPECT_EQ(scene.views[1].band_files[2], rig.place("IMG_0002_3.tif"));
  EXPECT_LT(farthest(rig, scene.views[1], 1, 2, 1 / kDepth), 1e-3);
  std::filesystem::remove(rig.place("IMG_0002_3.tif"));
  EXPECT_TRUE(contains(input_error([&] { rig.read(); }), "there is no file of its band '3' in "));
  SceneOptions skip;
  skip.skip_bad_photos = true;
  EXPECT_TRUE(rig.read(skip).views[1].photo.empty());
}

// A photo of which only other bands have a camera cannot be placed by the first.
TEST(BandViews, WithoutTheFirstBandsCameraAreLeftOut) {
  const RigScene rig;
  rig.write_model([](const std::string& name) { return name != "IMG_0002_1.tif" && name != "IMG_0001_2.tif"; });
  const Scene scene = rig.read();
  // The third band has most views, and takes the place of the first.
  ASSERT_EQ(scene.views.size(), 3u);
  EXPECT_EQ(scene.views[1].name, "IMG_0002_3.tif");
  rig.write_model([](const std::string& name) {
    return name != "IMG_0002_1.tif" && name != "IMG_0001_2.tif" && name != "IMG_0001_3.tif";
  });
  const Scene two = rig.read();
  EXPECT_EQ(two.views.size(), 2u);
  EXPECT_TRUE(has_warning(two, "1 photos are left out of which the scene has no camera of the band '1'"));
}

// Whoever asks for some of the photos by the first band's names gets the same bands.
TEST(BandViews, OfPhotosThatAreNotNeededAreTakenTogetherAsWell) {
  const RigScene rig;
  SceneOptions options;
  options.needed = [](std::span<const View> views) {
    std::vector<bool> needed;
    for (const View& view : views) needed.push_back(view.name == "IMG_0002_1.tif");
    return needed;
  };
  const Scene scene = rig.read(options);
  EXPECT_EQ(scene.views.size(), 3u);
  EXPECT_EQ(scene.bands->bands.size(), 3u);
  options.needed = [](std::span<const View> views) {
    std::vector<bool> needed;
    for (const View& view : views) needed.push_back(view.name.ends_with("_3.tif"));
    return needed;
  };
  const Scene third = rig.read(options);
  EXPECT_EQ(third.views.size(), 9u);
  EXPECT_EQ(third.bands->bands.size(), 1u);
}

}  // namespace
}  // namespace gpvc::io
