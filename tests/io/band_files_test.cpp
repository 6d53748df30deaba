// Bands in files of their own: which files belong to a photo, and where they lie over it.
#include <cmath>
#include <random>

#include "io/bands/band_files.h"
#include "io/bands/band_registration.h"
#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/io/band_scene.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiff_photo.h"

namespace gpvc::io {
namespace {

using test::BandScene;
using test::contains;
using test::has_warning;
using test::input_error;
using test::names_of;
using test::picture;
using test::spread;

constexpr int kWidth = test::kFrameWidth, kHeight = test::kFrameHeight;

TEST(BandFiles, AreTakenByTheirNames) {
  const auto name = [](const std::filesystem::path& file) {
    const auto found = band_file_name(file);
    return found ? found->group + "|" + std::to_string(found->order) + "|" + found->band : std::string();
  };
  EXPECT_EQ(name("x/IMG_0012_1.tif"), "img_0012|1|");
  EXPECT_EQ(name("IMG_0012_10.TIFF"), "img_0012|10|");
  EXPECT_EQ(name("IMG_0012_11.tif"), "");
  EXPECT_EQ(name("IMG_0012.tif"), "");
  EXPECT_EQ(name("IMG_12_1.tif"), "");
  EXPECT_EQ(name("IMG_0012_1.jpg"), "");
  EXPECT_EQ(name("IMG_170607_0001_GRE.TIF"), "img_170607_0001|2|Green");
  EXPECT_EQ(name("IMG_170607_0001_REG.TIF"), "img_170607_0001|4|Red edge");
  EXPECT_EQ(name("DJI_20230101_0001_MS_NIR.TIF"), "dji_20230101_0001|5|NIR");
  EXPECT_EQ(name("DJI_20230101_0001_MS_RE.TIF"), "dji_20230101_0001|4|Red edge");
  EXPECT_EQ(name("DJI_0011.TIF"), "dji_001|1|Blue");
  EXPECT_EQ(name("DJI_0025.TIF"), "dji_002|5|NIR");
  EXPECT_EQ(name("DJI_0026.TIF"), "");
  EXPECT_EQ(name("DJI_0020.JPG"), "") << "in colour";
  EXPECT_EQ(name("data/Red Edge/IMG_1.tif"), "img_1|4|Red edge");
  EXPECT_EQ(name("data/RGB/IMG_1.tif"), "");
}

/// Something to register by: smooth noise of several sizes, 0 to 1.
double texture(double x, double y) {
  double sum = 0;
  for (const double size : {5.0, 11.0, 29.0, 67.0}) {
    const double u = x / size + 50, v = y / size + 50, i = std::floor(u), j = std::floor(v);
    const auto node = [&](double right, double down) {
      std::minstd_rand random(static_cast<unsigned>(size + 977 * (i + right) + 31 * (j + down) * (i + right + 7)));
      random.discard(3);
      return static_cast<double>(random() % 1000) / 1000;
    };
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double s = smooth(u - i), t = smooth(v - j);
    sum += (1 - t) * ((1 - s) * node(0, 0) + s * node(1, 0)) + t * ((1 - s) * node(0, 1) + s * node(1, 1));
  }
  return sum / 4;
}

/// Band `number` shows at (x, y) what the first one shows at (x - right, y - down).
Samples moved_band(std::size_t number, double right, double down, int width, int height) {
  return picture(
      1, SampleType::u16,
      [&](std::size_t, int x, int y) {
        const double value = texture(x + 0.5 - right, y + 0.5 - down);
        return number % 2 == 0 ? 10000 + 40000 * value : 60000 - 30000 * value;
      },
      width, height);
}

TEST(BandFiles, AreRegisteredToThePhoto) {
  const Samples first = moved_band(0, 0, 0, 320, 240);
  struct Case {
    double right, down;
    bool whole;
  };
  for (const Case& c : {Case{2, -1, true}, Case{-7, 11, true}, Case{1.5, 0.3, false}, Case{0, 0, true}}) {
    const Samples other = moved_band(1, c.right, c.down, 320, 240);
    const Samples both = picture(
        2, SampleType::u16,
        [&](std::size_t b, int x, int y) { return load_sample((b == 0 ? first : other).at(x, y), SampleType::u16); },
        320, 240);
    const BandPlace place = place_of_matches(match_bands(both, 0, 1), 320, 240);
    ASSERT_TRUE(place.error_px);
    EXPECT_LT(*place.error_px, 0.15);
    const auto& m = place.file_from_photo;
    for (const double x : {20.0, 300.0})
      for (const double y : {20.0, 220.0}) {
        EXPECT_NEAR(m[0] * x + m[1] * y + m[2], x + c.right, c.whole ? 1e-12 : 0.2);
        EXPECT_NEAR(m[3] * x + m[4] * y + m[5], y + c.down, c.whole ? 1e-12 : 0.2);
      }
  }
}

TEST(BandFiles, ATurnAndAScaleOfABandAreFound) {
  const double angle = 0.01, scale = 1.01;
  const Samples both = picture(
      2, SampleType::u16,
      [&](std::size_t b, int x, int y) {
        double px = x + 0.5, py = y + 0.5;
        if (b == 1) {  // from the band's pixel to the photo's
          const double dx = px - 163, dy = py - 118;
          px = 160 + (std::cos(angle) * dx + std::sin(angle) * dy) / scale;
          py = 120 + (-std::sin(angle) * dx + std::cos(angle) * dy) / scale;
        }
        return 10000 + 40000 * texture(px, py);
      },
      320, 240);
  const BandPlace place = place_of_matches(match_bands(both, 0, 1), 320, 240);
  const auto& m = place.file_from_photo;
  for (const double x : {10.0, 310.0})
    for (const double y : {10.0, 230.0}) {
      const double dx = x - 160, dy = y - 120;
      EXPECT_NEAR(m[0] * x + m[1] * y + m[2], 163 + scale * (std::cos(angle) * dx - std::sin(angle) * dy), 0.3);
      EXPECT_NEAR(m[3] * x + m[4] * y + m[5], 118 + scale * (std::sin(angle) * dx + std::cos(angle) * dy), 0.3);
    }
}

TEST(BandFiles, AShiftByWholePixelsKeepsSamplesAndExcludesWhatABandLacks) {
  const BandScene scene({"IMG_0001_1.tif", "IMG_0002_1.tif"});
  for (const std::string photo : {"IMG_0001", "IMG_0002"})
    for (std::size_t b = 0; b < 3; ++b)
      scene.write(photo + "_" + std::to_string(b + 1) + ".tif",
                  moved_band(b, b == 2 ? 2 : 0, b == 2 ? -1 : 0, kWidth, kHeight));
  const Scene read = scene.read();
  ASSERT_TRUE(read.bands);
  EXPECT_EQ(names_of(read), "B1,B2,B3");
  EXPECT_EQ(read.views[0].band_files.size(), 3u);
  EXPECT_FALSE(read.band_places[1].moves());
  EXPECT_EQ(read.band_places[2].file_from_photo, (std::array<double, 6>{1, 0, 2, 0, 1, -1}));
  PhotoCache cache(read, 0);
  const auto samples = cache.samples(ViewId{0});
  const auto excluded = cache.exclusion(ViewId{0});
  const Samples own = read_samples(scene.place("IMG_0001_3.tif"));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool shown = x + 2 < kWidth && y >= 1;
      EXPECT_EQ(excluded->excludes(x, y), !shown) << x << ' ' << y;
      if (shown) {
        EXPECT_EQ(load_sample(samples->at(x, y) + 4, SampleType::u16),
                  load_sample(own.at(x + 2, y - 1), SampleType::u16));
      }
    }
}

TEST(BandFiles, AreInterpolatedWithinTheirNeighbours) {
  const BandScene scene({"IMG_0001_1.tif"});
  scene.write("IMG_0001_1.tif", moved_band(0, 0, 0, kWidth, kHeight));
  scene.write("IMG_0001_2.tif", moved_band(2, 1.5, 0, kWidth, kHeight));
  const Scene read = scene.read();
  ASSERT_EQ(read.band_places.size(), 2u);
  EXPECT_NEAR(read.band_places[1].file_from_photo[2], 1.5, 0.25);
  PhotoCache cache(read, 0);
  const auto samples = cache.samples(ViewId{0});
  double sum = 0;
  for (int y = 5; y < kHeight - 5; ++y)
    for (int x = 5; x < kWidth - 5; ++x)
      sum += std::abs(static_cast<double>(load_sample(samples->at(x, y), SampleType::u16)) -
                      static_cast<double>(load_sample(samples->at(x, y) + 2, SampleType::u16)));
  EXPECT_LT(sum / ((kWidth - 10) * (kHeight - 10)), 0.02 * 40000);
}

TEST(BandFiles, InFoldersAreAddedToThePhotos) {
  const BandScene scene({"a.tif", "b.tif"});
  const Samples rgb = spread(3, SampleType::u16, 0, 60000), infrared = spread(1, SampleType::u16, 0, 50000);
  scene.write_all(rgb, {.photometric = PHOTOMETRIC_RGB});
  for (const std::string name : {"a.tif", "b.tif"}) test::write_tiff(scene.folder() / "nir" / name, infrared);
  SceneOptions options;
  options.bands = {{"NIR", scene.folder() / "nir"}};
  const Scene read = scene.read(options);
  EXPECT_EQ(names_of(read), "Red,Green,Blue,NIR");
  PhotoCache cache(read, 0);
  EXPECT_EQ(cache.samples(ViewId{1})->bands, 4u);
  const auto before = cache.key(ViewId{1});
  test::write_tiff(scene.folder() / "nir" / "b.tif", spread(1, SampleType::u16, 0, 49000));
  EXPECT_TRUE(contains(input_error([&] { cache.samples(ViewId{1}); }), "b.tif: has changed"));
  PhotoCache again(read, 0);
  EXPECT_NE(again.key(ViewId{1}), before);
  std::filesystem::remove(scene.folder() / "nir" / "b.tif");
  EXPECT_TRUE(contains(input_error([&] { scene.read(options); }), "there is no file of its band 'NIR' in "));
  test::write_tiff(scene.folder() / "nir" / "b.tif", spread(1, SampleType::u8, 0, 255));
  EXPECT_TRUE(contains(input_error([&] { scene.read(options); }), "b.tif: holds samples of u8, "));
  test::write_tiff(scene.folder() / "nir" / "b.tif",
                   picture(
                       1, SampleType::u16, [](std::size_t, int x, int) { return x; }, 20, 10));
  EXPECT_TRUE(contains(input_error([&] { scene.read(options); }), "b.tif: is 20 x 10 pixels, "));
  options.bands = {{"NIR", scene.folder() / "nir"}, {"nir", scene.folder() / "images"}};
  EXPECT_TRUE(contains(input_error([&] { scene.read(options); }), "given for the band 'nir', which another folder"));
}

TEST(BandFiles, ThatALinkLeadsToOnceMoreAreOne) {
  const BandScene scene({"IMG_0001_1.tif"});
  scene.write_all(spread(1, SampleType::u16, 0, 60000));
  test::write_tiff(scene.folder() / "nir" / "day 1" / "IMG_0001_2.tif", spread(1, SampleType::u16, 0, 50000));
  std::filesystem::create_directory_symlink("day 1", scene.folder() / "nir" / "latest");
  SceneOptions options;
  options.bands = {{"NIR", scene.folder() / "nir"}};
  EXPECT_EQ(PhotoCache(scene.read(options), 0).samples(ViewId{0})->bands, 2u);
}

// More of them in band_views_test.cpp.
TEST(BandFiles, ThatAreViewsWithTheSameCameraAreBands) {
  const BandScene scene({"IMG_0001_1.tif", "IMG_0001_2.tif"});
  scene.write_all(spread(1, SampleType::u16, 0, 60000));
  const Scene read = scene.read();
  ASSERT_EQ(read.views.size(), 1u);
  EXPECT_EQ(read.views[0].band_files.size(), 2u);
  EXPECT_EQ(read.bands->bands.size(), 2u);
}

TEST(BandFiles, OfPhotosOfDifferentBandsAreNotTakenTogether) {
  const BandScene scene({"IMG_0001_1.tif", "IMG_0002_2.tif"});
  for (const std::string name : {"IMG_0001_1.tif", "IMG_0001_2.tif", "IMG_0002_1.tif", "IMG_0002_2.tif"})
    scene.write(name, spread(1, SampleType::u16, 0, 60000));
  EXPECT_TRUE(scene.read().views[0].band_files.empty());
}

TEST(BandFiles, OfAnotherSizeAreLeftOutAndSaidSo) {
  const BandScene scene({"IMG_0001_1.tif"});
  scene.write("IMG_0001_1.tif", spread(1, SampleType::u16, 0, 60000));
  scene.write("IMG_0001_2.tif", spread(1, SampleType::u16, 0, 50000));
  scene.write("IMG_0001_6.tif", picture(
                                    1, SampleType::u16, [](std::size_t, int x, int) { return x; }, 16, 12));
  const Scene read = scene.read();
  EXPECT_EQ(read.views[0].band_files.size(), 2u);
  EXPECT_TRUE(has_warning(read, "the band '6' is left out"));
  SceneOptions options;
  options.bands_by_name = false;
  EXPECT_TRUE(scene.read(options).views[0].band_files.empty());
}

// A mask of a further band's file hides what that band does not show, moved with the band.
TEST(BandFiles, MasksInsideThemExcludeToo) {
  const BandScene scene({"IMG_0001_1.tif"});
  for (std::size_t b = 0; b < 2; ++b)
    scene.write("IMG_0001_" + std::to_string(b + 1) + ".tif",
                picture(1, SampleType::u16, [](std::size_t, int x, int y) { return 100 + x + y; }));
  test::append_mask(scene.place("IMG_0001_2.tif"), kWidth, kHeight, [](int x, int y) { return x > 3 || y > 5; });
  const Scene read = scene.read();
  ASSERT_EQ(read.views[0].band_files.size(), 2u);
  PhotoCache cache(read, 0);
  const auto excluded = cache.exclusion(ViewId{0});
  ASSERT_TRUE(excluded);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(excluded->excludes(x, y), x <= 3 && y <= 5) << x << ' ' << y;
}

}  // namespace
}  // namespace gpvc::io
