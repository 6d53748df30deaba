// Scenes of photos with more than RGB of 8 bits: what their bands are, where they lie, and what the photo cache makes of them.
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "io/bands/band_files.h"
#include "io/bands/band_registration.h"
#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/io/colmap_folder.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiff_photo.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TiffLayout;

constexpr int kWidth = test::kFrameWidth, kHeight = test::kFrameHeight;

/// A scene of some photos, which the test writes.
class BandScene {
 public:
  explicit BandScene(std::vector<std::string> names) : names_(std::move(names)) {
    std::vector<test::TestImage> images;
    for (const std::string& name : names_)
      images.push_back({static_cast<std::uint32_t>(images.size() + 1), {1, 0, 0, 0}, {1, 2, 3}, 7, name});
    colmap_.model(false, test::kCameras, images);
  }
  std::filesystem::path place(const std::string& name) const { return colmap_.folder.path() / "images" / name; }
  void write(const std::string& name, const Samples& samples, const TiffLayout& layout = {}) const {
    test::write_tiff(place(name), samples, layout);
  }
  void write_all(const Samples& samples, const TiffLayout& layout = {}) const {
    for (const std::string& name : names_) write(name, samples, layout);
  }
  Scene read(const SceneOptions& options = {}) const { return read_scene(colmap_.folder.path(), options); }
  std::filesystem::path folder() const { return colmap_.folder.path(); }

 private:
  std::vector<std::string> names_;
  test::ColmapFolder colmap_{{}};
};

/// Band b of pixel (x, y) is value(b, x, y).
template <typename Value>
Samples picture(std::size_t bands, SampleType type, const Value& value, int width = kWidth, int height = kHeight) {
  Samples samples{width, height, bands, type, {}};
  samples.bytes.resize(pixel_index(0, height, width) * samples.pixel_bytes());
  std::byte* to = samples.bytes.data();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (std::size_t b = 0; b < bands; ++b, to += bytes_of(type))
        store_sample(to, type, static_cast<float>(value(b, x, y)));
  return samples;
}

/// Spread over `low` to `high`.
Samples spread(std::size_t bands, SampleType type, double low, double high) {
  return picture(bands, type, [&](std::size_t b, int x, int y) {
    const double part = ((x * 7 + y * 13 + static_cast<int>(b) * 5) % 64) / 63.0;
    return low + (high - low) * part;
  });
}

bool has_warning(const Scene& scene, const std::string& part) {
  for (const std::string& warning : scene.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

std::string names_of(const Scene& scene) {
  std::string names;
  for (const Band& band : scene.bands->bands) names += (names.empty() ? "" : ",") + band.name;
  return names;
}

TEST(Bands, AreNoneOfColoursOfEightBits) {
  const BandScene scene({"a.tif", "b.tif"});
  for (const std::size_t bands : {1u, 3u}) {
    scene.write_all(spread(bands, SampleType::u8, 0, 255),
                    {.photometric = static_cast<std::uint16_t>(bands == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK)});
    EXPECT_FALSE(scene.read().bands);
  }
  SceneOptions options;
  options.composite = {"1"};
  EXPECT_TRUE(contains(input_error([&] { scene.read(options); }), "need no composite"));
}

// 32 bits a pixel, uncompressed: the fourth byte is reserved.
TEST(Bands, AreNotTheReservedBytesOfABmp) {
  const BandScene scene({"a.bmp"});
  std::string bmp = "BM" + test::bytes_of<std::uint32_t>(54 + 4 * kWidth * kHeight) + std::string(4, '\0') +
                    test::bytes_of<std::uint32_t>(54) + test::bytes_of<std::uint32_t>(40) +
                    test::bytes_of<std::int32_t>(kWidth) + test::bytes_of<std::int32_t>(kHeight) +
                    test::bytes_of<std::uint16_t>(1) + test::bytes_of<std::uint16_t>(32) + std::string(24, '\0');
  for (int i = 0; i < kWidth * kHeight; ++i) bmp += std::string("\x60\x70\x80\0", 4);
  std::filesystem::create_directories(scene.place("a.bmp").parent_path());
  std::ofstream(scene.place("a.bmp"), std::ios::binary) << bmp;
  const Scene read = scene.read();
  EXPECT_FALSE(read.bands);
  EXPECT_FALSE(read.views[0].uses_alpha);
  EXPECT_EQ(read_image(read.views[0].photo).at(3, 5)[0], 0x80);
}

// What a 16-bit photo looks like has not changed: all levels, as they are.
TEST(Bands, OfSixteenBitsKeepTheirWholeRangeWhereTheyUseIt) {
  const BandScene scene({"a.tif", "b.tif"});
  const Samples samples = spread(3, SampleType::u16, 0, 65535);
  scene.write_all(samples, {.photometric = PHOTOMETRIC_RGB});
  const Scene read = scene.read();
  ASSERT_TRUE(read.bands);
  EXPECT_EQ(names_of(read), "Red,Green,Blue");
  EXPECT_EQ(read.bands->type, SampleType::u16);
  EXPECT_EQ(read.bands->black, 0);
  EXPECT_EQ(read.bands->white, 65535);
  EXPECT_EQ(read.bands->composite, (std::array<std::size_t, 3>{0, 1, 2}));
  EXPECT_FALSE(read.bands->radiometric);
  PhotoCache cache(read, 0);
  const auto stored = cache.samples(ViewId{0});
  EXPECT_EQ(stored->bytes, samples.bytes);
  EXPECT_EQ(cache.photo(ViewId{0})->pixels, read_image(read.views[0].photo).pixels);
}

TEST(Bands, OfTwelveBitsAndCountsAreLookedAtOverTheirOwnRange) {
  const BandScene scene({"a.tif", "b.tif"});
  scene.write_all(spread(3, SampleType::u16, 0, 4095), {.photometric = PHOTOMETRIC_RGB});
  Scene read = scene.read();
  EXPECT_EQ(read.bands->black, 0);
  EXPECT_NEAR(read.bands->white, 4095 * 1.05, 2);
  scene.write_all(spread(1, SampleType::u16, 29000, 31000));
  read = scene.read();
  EXPECT_NEAR(read.bands->black, 28900, 2);
  EXPECT_NEAR(read.bands->white, 31100, 2);
  EXPECT_TRUE(read.bands->radiometric);
  EXPECT_FALSE(has_warning(read, "levels"));
  PhotoCache cache(read, 0);
  const auto photo = cache.photo(ViewId{1});
  const auto [least, most] = std::ranges::minmax(photo->pixels);
  EXPECT_NEAR(least, 12, 1);
  EXPECT_NEAR(most, 243, 1);
}

TEST(Bands, ReflectancesKeepTheirNumbersAndLoseWhatIsNone) {
  const BandScene scene({"a.tif", "b.tif"});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Samples samples = picture(5, SampleType::f32, [&](std::size_t b, int x, int y) {
    return x >= 10 && x < 14 && y >= 20 && y < 23 && b == 2 ? nan
                                                            : static_cast<float>(x) / 50 + static_cast<float>(b) / 100;
  });
  scene.write_all(samples);
  const Scene read = scene.read();
  EXPECT_EQ(names_of(read), "B1,B2,B3,B4,B5");
  EXPECT_EQ(read.bands->composite, (std::array<std::size_t, 3>{0, 1, 2}));
  EXPECT_TRUE(read.bands->radiometric);
  PhotoCache cache(read, 0);
  const auto stored = cache.samples(ViewId{0});
  const auto excluded = cache.exclusion(ViewId{0});
  ASSERT_TRUE(excluded);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool hole = x >= 10 && x < 14 && y >= 20 && y < 23;
      EXPECT_EQ(excluded->excludes(x, y), hole);
      for (std::size_t b = 0; b < 5; ++b) {
        const float value = load_sample(stored->at(x, y) + 4 * b, SampleType::f32);
        if (!hole) {
          EXPECT_EQ(value, load_sample(samples.at(x, y) + 4 * b, SampleType::f32));
        } else {
          EXPECT_NEAR(value, 0.23 + static_cast<double>(b) / 100, 0.08);  // of its surroundings
        }
      }
    }
}

TEST(Bands, ArePictureAndSamplesOfOneDecoding) {
  const BandScene scene({"a.tif", "b.tif"});
  scene.write_all(spread(5, SampleType::u16, 0, 4000));
  const Scene read = scene.read();
  PhotoCache cache(read, 1'000'000);
  const auto samples = cache.samples(ViewId{0});
  const auto photo = cache.photo(ViewId{0});
  EXPECT_EQ(cache.decodes().times, 1u);
  // A photo alone keeps no samples, and is decoded again for them.
  cache.photo(ViewId{1});
  cache.samples(ViewId{1});
  EXPECT_EQ(cache.decodes().times, 3u);
  EXPECT_EQ(cache.decodes().photos, 2u);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double level = load_sample(samples->at(x, y), SampleType::u16) / read.bands->white * 255;
      EXPECT_NEAR(photo->at(x, y)[0], level, 0.51);
    }
}

TEST(Bands, SamplesCountTowardsTheLimit) {
  const BandScene scene({"a.tif", "b.tif"});
  scene.write_all(spread(5, SampleType::u16, 0, 4000));
  const Scene read = scene.read();
  const std::size_t pixels = kWidth * kHeight;
  for (const std::size_t limit : {13 * pixels - 1, 13 * pixels}) {
    PhotoCache cache(read, limit);
    const std::weak_ptr<const Samples> held = cache.samples(ViewId{0});
    EXPECT_EQ(held.expired(), limit < 13 * pixels);
  }
}

TEST(Bands, AreReducedWithTheirPhotos) {
  const BandScene scene({"a.tif", "b.tif"});
  const Samples whole = spread(4, SampleType::u16, 0, 60000);
  scene.write_all(whole);
  SceneOptions options;
  options.downscale = 3;
  const Scene read = scene.read(options);
  PhotoCache cache(read, 0);
  const auto samples = cache.samples(ViewId{0});
  EXPECT_EQ(samples->width, kWidth / 3);
  EXPECT_EQ(samples->height, kHeight / 3);
  double sum = 0;
  for (int y = 6; y < 9; ++y)
    for (int x = 3; x < 6; ++x) sum += static_cast<double>(load_sample(whole.at(x, y) + 6, SampleType::u16));
  EXPECT_EQ(load_sample(samples->at(1, 2) + 6, SampleType::u16), std::floor(static_cast<float>(sum / 9) + 0.5f));
}

TEST(Bands, AFourthOneIsNoAlphaUnlessItLooksLikeOne) {
  const BandScene scene({"a.tif", "b.tif"});
  const Samples bands = spread(4, SampleType::u16, 1000, 50000);
  const std::vector<std::uint16_t> alpha{EXTRASAMPLE_UNASSALPHA};
  const TiffLayout layouts[] = {{.photometric = PHOTOMETRIC_RGB},
                                {.photometric = PHOTOMETRIC_RGB, .extra = alpha},
                                {.photometric = PHOTOMETRIC_RGB, .states_extra = false}};
  for (std::size_t i = 0; i < std::size(layouts); ++i) {
    scene.write_all(bands, layouts[i]);
    const Scene read = scene.read();
    EXPECT_EQ(names_of(read), "Red,Green,Blue,B4");
    EXPECT_EQ(has_warning(read, "it is taken for a band"), i > 0);
    EXPECT_FALSE(read.views[0].uses_alpha);
    PhotoCache cache(read, 0);
    EXPECT_EQ(cache.samples(ViewId{0})->bytes, bands.bytes);
  }
  const Samples rgba = picture(4, SampleType::u16, [](std::size_t b, int x, int y) {
    return b == 3 ? (x < 5 ? 0 : x == 5 ? 30000 : 65535) : 1000 * x + y;
  });
  scene.write_all(rgba, layouts[1]);
  const Scene read = scene.read();
  EXPECT_EQ(names_of(read), "Red,Green,Blue");
  EXPECT_TRUE(read.views[0].uses_alpha);
  PhotoCache cache(read, 0);
  const auto samples = cache.samples(ViewId{0});
  const auto excluded = cache.exclusion(ViewId{0});
  for (int x = 0; x < kWidth; ++x) EXPECT_EQ(excluded->excludes(x, 7), x < 5);
  EXPECT_EQ(load_sample(samples->at(20, 7) + 2, SampleType::u16), 20007);
  // RGB and infrared of 8 bits.
  scene.write_all(spread(4, SampleType::u8, 3, 250), layouts[1]);
  EXPECT_EQ(scene.read().bands->bands.size(), 4u);
}

// Water is 0 in infrared and roofs are overexposed: a tag that calls it an alpha is wrong all the same.
TEST(Bands, ATaggedAlphaWithValuesLikeAPicturesIsABand) {
  const BandScene scene({"a.tif", "b.tif"});
  const TiffLayout layout{.photometric = PHOTOMETRIC_RGB, .extra = {EXTRASAMPLE_UNASSALPHA}};
  const auto write = [&](double full, SampleType type, const std::function<double(int, int)>& fourth) {
    scene.write_all(
        picture(4, type, [&](std::size_t b, int x, int y) { return b == 3 ? full * fourth(x, y) : 20.0 + x + y; }),
        layout);
  };
  const auto infrared = [](int x, int y) { return x < 6 ? 0.0 : x > 54 ? 1.0 : ((x * 7 + y * 13) % 64) / 63.0; };
  write(255, SampleType::u8, infrared);
  ASSERT_TRUE(scene.read().bands);
  EXPECT_EQ(scene.read().bands->bands.size(), 4u);
  EXPECT_TRUE(has_warning(scene.read(), "it is taken for a band"));
  write(4095, SampleType::u16, infrared);
  EXPECT_EQ(scene.read().bands->bands.size(), 4u);
  // Alphas: a soft rim, none transparent, most transparent, one of 8 bits in 16.
  const auto rim = [](int x, int) { return std::clamp((x - 5) / 12.0, 0.0, 1.0); };
  const auto little = [](int x, int y) { return x > 50 && y > 40 ? 1.0 : 0.0; };
  for (const auto& alpha : {std::function<double(int, int)>(rim), std::function<double(int, int)>(little),
                            std::function<double(int, int)>([](int, int) { return 1.0; })}) {
    write(65535, SampleType::u16, alpha);
    EXPECT_EQ(scene.read().bands->bands.size(), 3u);
    write(255, SampleType::u16, alpha);
    EXPECT_EQ(scene.read().bands->bands.size(), 3u);
    write(255, SampleType::u8, alpha);
    EXPECT_FALSE(scene.read().bands);
  }
}

// What the file calls the fourth channel goes before how its values are spread.
TEST(Bands, AnAlphaThatIsNamedAsABandIsOne) {
  const BandScene scene({"a.tif", "b.tif"});
  const Samples binary = picture(4, SampleType::u16,
                                 [](std::size_t b, int x, int y) { return b == 3 ? (x < 9 ? 0 : 65535) : 50 * x + y; });
  const auto bands = [&](const std::string& name, const std::string& more = "") {
    scene.write_all(binary, {.photometric = PHOTOMETRIC_RGB,
                             .extra = {EXTRASAMPLE_UNASSALPHA},
                             .metadata = "<GDALMetadata><Item name=\"DESCRIPTION\" sample=\"3\" role=\"description\">" +
                                         name + "</Item>" + more + "</GDALMetadata>"});
    return scene.read().bands->bands.size();
  };
  EXPECT_EQ(bands("NIR"), 4u);
  EXPECT_EQ(scene.read().bands->bands[3].name, "NIR");
  EXPECT_FALSE(scene.read().views[0].uses_alpha);
  EXPECT_EQ(bands("Alpha band"), 3u);
  EXPECT_EQ(bands("Band 4"), 3u);
  EXPECT_EQ(bands("4"), 3u);
  EXPECT_EQ(bands("Band 4", "<Item name=\"WAVELENGTH\" sample=\"3\">842</Item>"), 4u);
}

// GDAL's own masks: in strips and tiles, of 1 and of 8 bits, behind a smaller picture with a mask of its own.
TEST(Bands, AMaskInsideTheFileExcludesWhatItDoesNotShow) {
  const BandScene scene({"a.tif", "b.tif"});
  const auto shows = [](int x, int y) { return x >= 5 && !(x == 20 && y == 9); };
  for (const SampleType type : {SampleType::u8, SampleType::u16, SampleType::f32})
    for (const auto& [bits, tile] : {std::pair{1, 0u}, std::pair{8, 0u}, std::pair{1, 16u}, std::pair{8, 32u}}) {
      const Samples samples = spread(3, type, 1, type == SampleType::f32 ? 1.5 : 250);
      scene.write_all(samples, {.photometric = PHOTOMETRIC_RGB});
      test::append_mask(scene.place("a.tif"), kWidth, kHeight, shows, bits, tile);
      EXPECT_TRUE(hides_pixels(scene.place("a.tif")));
      EXPECT_FALSE(has_alpha(scene.place("a.tif")));
      const Scene read = scene.read();
      EXPECT_EQ(read.bands.has_value(), type != SampleType::u8);
      EXPECT_TRUE(read.views[0].uses_alpha);
      EXPECT_FALSE(read.views[1].uses_alpha);
      PhotoCache cache(read, 0);
      const auto excluded = cache.exclusion(ViewId{0});
      ASSERT_TRUE(excluded);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) EXPECT_EQ(excluded->excludes(x, y), !shows(x, y)) << x << ' ' << y;
      EXPECT_FALSE(cache.exclusion(ViewId{1}));
      if (type == SampleType::u8) {
        EXPECT_EQ(cache.photo(ViewId{0})->at(7, 3)[0], load_sample(samples.at(7, 3), type));
      } else {
        EXPECT_EQ(load_sample(cache.samples(ViewId{0})->at(7, 3), type), load_sample(samples.at(7, 3), type));
      }
      SceneOptions all;
      all.masks = false;
      const Scene unmasked = scene.read(all);
      PhotoCache whole(unmasked, 0);
      EXPECT_FALSE(whole.exclusion(ViewId{0}));
    }
}

// An alpha and a mask in one file: each excludes what it does.
TEST(Bands, AMaskInsideTheFileIsAddedToItsAlpha) {
  const BandScene scene({"a.tif"});
  for (const SampleType type : {SampleType::u8, SampleType::u16}) {
    const double full = type == SampleType::u8 ? 255 : 65535;
    scene.write_all(picture(4, type, [&](std::size_t b, int x, int) { return b < 3   ? 9 + x
                                                                             : x < 4 ? 0
                                                                                     : full; }),
                    {.photometric = PHOTOMETRIC_RGB, .extra = {EXTRASAMPLE_UNASSALPHA}});
    test::append_mask(scene.place("a.tif"), kWidth, kHeight, [](int, int y) { return y > 1; });
    const Scene read = scene.read();
    PhotoCache cache(read, 0);
    const auto excluded = cache.exclusion(ViewId{0});
    ASSERT_TRUE(excluded);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) EXPECT_EQ(excluded->excludes(x, y), x < 4 || y < 2) << x << ' ' << y;
  }
}

TEST(Bands, AMaskThatIsDamagedIsAnError) {
  const BandScene scene({"a.tif"});
  scene.write_all(spread(2, SampleType::u16, 1, 60000));
  test::append_mask(scene.place("a.tif"), kWidth, kHeight, [](int x, int) { return x > 2; });
  const std::string whole = test::read_file(scene.place("a.tif"));
  const Scene read = scene.read();
  std::size_t errors = 0;
  for (std::size_t length = whole.size() - 1; length > whole.size() - 300; --length) {
    std::ofstream(scene.place("a.tif"), std::ios::binary) << whole.substr(0, length);
    PhotoCache cache(read, 0);
    try {
      cache.samples(ViewId{0});
    } catch (const InputError&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 290u);  // all but those that lack a byte that nothing needs
}

// GDAL's mask in a file beside the photo.
TEST(Bands, AMaskFileOfGdalExcludesWhatItDoesNotShow) {
  const BandScene scene({"a.tif"});
  scene.write_all(spread(2, SampleType::u16, 1, 60000));
  test::write_tiff(scene.place("a.tif.msk"),
                   picture(1, SampleType::u8, [](std::size_t, int x, int) { return x < 3 ? 0 : 255; }));
  const Scene read = scene.read();
  EXPECT_EQ(read.views[0].mask, scene.place("a.tif.msk"));
  PhotoCache cache(read, 0);
  const auto excluded = cache.exclusion(ViewId{0});
  ASSERT_TRUE(excluded);
  for (int x = 0; x < kWidth; ++x) EXPECT_EQ(excluded->excludes(x, 4), x < 3);
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

TEST(Bands, AreNamedByGdalAndXmp) {
  const BandScene scene({"a.tif", "b.tif"});
  scene.write_all(
      spread(2, SampleType::u16, 0, 50000),
      {.metadata = "<GDALMetadata><Item name=\"DESCRIPTION\" sample=\"0\" role=\"description\">NIR</Item>"
                   "<Item name=\"UNITTYPE\" sample=\"1\" role=\"unittype\">K</Item>"
                   "<Item name=\"DESCRIPTION\" sample=\"1\" role=\"description\">LWIR</Item>"
                   "<Item name=\"CENTRAL_WAVELENGTH_UM\" sample=\"0\" domain=\"IMAGERY\">0.842</Item></GDALMetadata>"});
  const Scene read = scene.read();
  EXPECT_EQ(read.bands->bands, (std::vector<Band>{{"NIR", 842, ""}, {"LWIR", std::nullopt, "K"}}));
  scene.write_all(
      spread(3, SampleType::u16, 0, 50000),
      {.xmp = "<?xpacket begin=''?><x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF xmlns:rdf='r'><rdf:Description "
              "xmlns:Camera='c'><Camera:BandName><rdf:Seq><rdf:li>Red</rdf:li><rdf:li>Green</rdf:li><rdf:li>NIR"
              "</rdf:li></rdf:Seq></Camera:BandName><Camera:CentralWavelength><rdf:Seq><rdf:li>668</rdf:li>"
              "<rdf:li>560</rdf:li><rdf:li>840</rdf:li></rdf:Seq></Camera:CentralWavelength>"
              "</rdf:Description></rdf:RDF></x:xmpmeta>"});
  const Scene xmp = scene.read();
  EXPECT_EQ(xmp.bands->bands, (std::vector<Band>{{"Red", 668, ""}, {"Green", 560, ""}, {"NIR", 840, ""}}));
  EXPECT_EQ(xmp.bands->composite, (std::array<std::size_t, 3>{2, 0, 1}));
  EXPECT_TRUE(xmp.bands->radiometric);
  SceneOptions options;
  options.composite = {"green", "2", "NIR"};
  EXPECT_EQ(scene.read(options).bands->composite, (std::array<std::size_t, 3>{1, 1, 2}));
  options.composite = {"blue"};
  EXPECT_TRUE(contains(input_error([&] { scene.read(options); }), "has no band 'blue'; its bands are Red, Green, NIR"));
}

TEST(Bands, ThatDifferBetweenPhotosAreRefusedUnlessTheyAreColours) {
  const BandScene scene({"a.tif", "b.tif"});
  scene.write("a.tif", spread(5, SampleType::u16, 0, 60000));
  scene.write("b.tif", spread(4, SampleType::u16, 0, 60000));
  EXPECT_TRUE(contains(input_error([&] { scene.read(); }), "b.tif: holds 4 bands of u16, "));
  scene.write("b.tif", spread(5, SampleType::f32, 0, 1));
  EXPECT_TRUE(contains(input_error([&] { scene.read(); }), "b.tif: holds 5 bands of f32, "));
  scene.write("a.tif", spread(3, SampleType::u16, 0, 60000), {.photometric = PHOTOMETRIC_RGB});
  scene.write("b.tif", spread(3, SampleType::u8, 0, 255), {.photometric = PHOTOMETRIC_RGB});
  const Scene read = scene.read();
  EXPECT_FALSE(read.bands);
  EXPECT_TRUE(has_warning(read, "worked on with 8 bits"));
  scene.write("b.tif", spread(1, SampleType::u32, 0, 1));
  EXPECT_TRUE(contains(input_error([&] { scene.read(); }), "holds samples of type"));
}

TEST(Bands, OfComplexNumbersAreRefused) {
  const BandScene scene({"a.tif"});
  scene.write("a.tif", spread(1, SampleType::f32, 0, 1));
  const auto file = scene.read().views[0].photo;
  std::string bytes = test::read_file(file);
  // The tag of the sample format, of one number of 16 bits: floats become complex ones.
  const std::size_t tag = bytes.find(std::string("\x53\x01\x03\x00\x01\x00\x00\x00\x03", 9));
  ASSERT_NE(tag, std::string::npos);
  for (const char format : {'\x05', '\x06'}) {
    bytes[tag + 8] = format;
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_TRUE(contains(input_error([&] { scene.read(); }), "a.tif (holds samples of type complex numbers; expected"));
  }
}

TEST(Bands, OfPicturesInMemoryAreLookedAtAsThoseInFiles) {
  std::vector<float> some;
  for (int i = 0; i < 10000; ++i) some.push_back(static_cast<float>(29000 + i / 5));
  const BandSet thermal = band_set_of({{"Thermal"}}, SampleType::u16, {}, some);
  EXPECT_TRUE(thermal.radiometric);
  EXPECT_NEAR(thermal.black, 28900, 5);
  EXPECT_NEAR(thermal.white, 31100, 5);
  const BandSet five =
      band_set_of({{"Blue"}, {"Green"}, {"Red"}, {"Red"}, {"NIR"}}, SampleType::f32, {"NIR", "red", "2"}, {0.1f, 0.4f});
  EXPECT_EQ(five.composite, (std::array<std::size_t, 3>{4, 2, 1}));
  EXPECT_NE(five.bands[2].name, five.bands[3].name);
  EXPECT_TRUE(contains(input_error([] { band_set_of({{"Red"}}, SampleType::u8, {"NIR"}, {}); }), "has no band 'NIR'"));
}

TEST(Bands, OfPicturesInMemoryAreCheckedAndPaintedOver) {
  Scene scene;
  View& view = scene.views.emplace_back();
  view.name = "a";
  view.camera.width = kWidth;
  view.camera.height = kHeight;
  scene.bands.emplace();
  scene.bands->bands = {{"Red", 668, ""}, {"NIR", 842, ""}};
  const auto picture_with = [&](std::optional<Samples> samples) {
    PhotoExclusion exclusion{kWidth, kHeight, 1, std::vector<std::uint64_t>(kHeight)};
    exclusion.words[5] = 0b1000;
    return Picture{
        {kWidth, kHeight, 3, std::vector<std::uint8_t>(3 * kWidth * kHeight, 9)}, exclusion, std::move(samples)};
  };
  Samples samples = picture(2, SampleType::u16, [](std::size_t b, int, int) { return 1000 * (b + 1); });
  store_sample(samples.at(3, 5), SampleType::u16, 7);
  PictureSource memory(scene, {picture_with(samples)});
  CallbackSource made(scene, [&](ViewId) { return picture_with(samples); });
  for (PhotoSource* source : {static_cast<PhotoSource*>(&memory), static_cast<PhotoSource*>(&made)}) {
    const auto given = source->samples(ViewId{0});
    EXPECT_EQ(load_sample(given->at(3, 5), SampleType::u16), 1000) << "painted over";
    EXPECT_EQ(load_sample(given->at(4, 5) + 2, SampleType::u16), 2000);
  }
  EXPECT_THROW(PictureSource(scene, {picture_with(std::nullopt)}), std::invalid_argument);
  samples.bands = 1;
  EXPECT_THROW(PictureSource(scene, {picture_with(samples)}), std::invalid_argument);
  EXPECT_THROW(PictureSource(scene, {picture_with(spread(2, SampleType::u8, 0, 255))}), std::invalid_argument);
}

// --- bands in files of their own

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

}  // namespace
}  // namespace gpvc::io
