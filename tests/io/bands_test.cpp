// Scenes of photos with more than RGB of 8 bits: what their bands are, what is none, and what the photo cache makes of them.
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

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
using test::TiffLayout;

constexpr int kWidth = test::kFrameWidth, kHeight = test::kFrameHeight;

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

}  // namespace
}  // namespace gpvc::io
