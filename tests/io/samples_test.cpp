// Samples of files as they are stored: every layout of TIFF, PNGs of 16 bits, EXR; pixels without data.
#include <OpenImageIO/imageio.h>

#include <limits>
#include <random>

#include "io/bands/band_photo.h"
#include "io/images.h"
#include "io/push_pull.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiff_photo.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;
using test::TiffLayout;

std::vector<std::uint8_t> every_other_mask(int width, int height) {
  std::vector<std::uint8_t> mask(pixel_index(0, height, width));
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 7 < 3 ? 255 : 0;
  return mask;
}

/// Samples that all differ, over the whole range of their type.
Samples noise(int width, int height, std::size_t bands, SampleType type) {
  Samples samples{width, height, bands, type, {}};
  samples.bytes.resize(pixel_index(0, height, width) * samples.pixel_bytes());
  std::mt19937 random(static_cast<unsigned>(bands));
  for (std::size_t at = 0; at < samples.bytes.size(); at += bytes_of(type)) {
    const auto number = random();
    store_sample(&samples.bytes[at], type,
                 type == SampleType::f32 ? static_cast<float>(number) / 1e7f - 100
                                         : static_cast<float>(number % 65536) / (type == SampleType::u8 ? 256 : 1));
  }
  return samples;
}

// Pages' samples: what is written comes back, with what its bands are.
TEST(Samples, AreReadAsTheyAreWritten) {
  const TemporaryFolder folder;
  for (const SampleType type : {SampleType::u8, SampleType::u16, SampleType::f32})
    for (const std::size_t bands : {1u, 3u, 4u, 5u, 32u}) {
      const Samples samples = noise(300, 270, bands, type);
      BandSet set;
      set.type = type;
      for (std::size_t b = 0; b < bands; ++b) set.bands.push_back({"Band " + std::to_string(b + 1), {}, {}});
      set.bands[0] = {"A<&>", 717.5, "reflectance"};
      set.radiometric = bands != 3;
      const std::vector<std::uint8_t> mask(every_other_mask(300, 270));
      write_samples(folder.path() / "a.tif", samples, set,
                    bands == 5 ? std::span<const std::uint8_t>(mask) : std::span<const std::uint8_t>());
      EXPECT_EQ(folder.count(), 1u);
      const Samples read = read_samples(folder.path() / "a.tif");
      EXPECT_EQ(read.bands, bands);
      EXPECT_EQ(read.type, type);
      EXPECT_EQ(read.bytes, samples.bytes);
      const BandSet found = read_band_set(folder.path() / "a.tif");
      EXPECT_EQ(found.type, type);
      EXPECT_EQ(found.bands, set.bands);
    }
}

// Two and four bands of a PNG lie where an alpha would; what the file says of them tells that they are bands.
TEST(Samples, OfPngsAreThoseOfTiffs) {
  const TemporaryFolder folder;
  for (const SampleType type : {SampleType::u8, SampleType::u16})
    for (const std::size_t bands : {1u, 2u, 3u, 4u}) {
      // More than one block of the compression, and not a whole number of them.
      const Samples samples = noise(700, 531, bands, type);
      BandSet set;
      set.type = type;
      for (std::size_t b = 0; b < bands; ++b) set.bands.push_back({"Band " + std::to_string(b + 1), {}, {}});
      set.bands[0] = {"R\xC3\xA9<&>", 717.5, "reflectance"};
      write_samples(folder.path() / "a.png", samples, set, every_other_mask(700, 531));
      write_samples(folder.path() / "a.tif", samples, set, every_other_mask(700, 531));
      const Samples png = read_samples(folder.path() / "a.png"), tif = read_samples(folder.path() / "a.tif");
      EXPECT_EQ(png.bands, bands);
      EXPECT_EQ(png.type, type);
      EXPECT_EQ(png.bytes, samples.bytes);
      EXPECT_EQ(png.bytes, tif.bytes);
      EXPECT_EQ(read_band_set(folder.path() / "a.png").bands, set.bands);
      EXPECT_FALSE(has_alpha(folder.path() / "a.png"));
      // As another library reads it: the same numbers.
      OIIO::ImageSpec as_stored;
      as_stored["oiio:UnassociatedAlpha"] = 1;
      const auto in = OIIO::ImageInput::open((folder.path() / "a.png").string(), &as_stored);
      ASSERT_TRUE(in);
      std::vector<std::byte> read(samples.bytes.size());
      const auto form = type == SampleType::u8 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16;
      EXPECT_EQ(in->spec().nchannels, static_cast<int>(bands));
      ASSERT_TRUE(in->read_image(0, 0, 0, in->spec().nchannels, form, read.data()));
      EXPECT_EQ(read, samples.bytes);
    }
}

TEST(Samples, ThatNoPngHoldsAreNotWrittenToOne) {
  BandSet set;
  set.bands.resize(4);
  EXPECT_TRUE(fits_png(set));
  set.bands.resize(5);
  EXPECT_FALSE(fits_png(set));
  set.bands.resize(1);
  set.type = SampleType::f32;
  EXPECT_FALSE(fits_png(set));
  const TemporaryFolder folder;
  EXPECT_THROW(write_samples(folder.path() / "a.png", noise(3, 3, 1, SampleType::f32), set), std::invalid_argument);
  EXPECT_EQ(folder.count(), 0u);
}

TEST(Samples, AreNotWrittenWhereThereIsNoRoom) {
  const Samples samples = noise(600, 600, 5, SampleType::f32);
  BandSet set;
  set.type = SampleType::f32;
  set.bands.resize(5);
  EXPECT_THROW(write_samples("/dev/full/a.tif", samples, set), OutputError);
  EXPECT_THROW(write_samples("/nowhere/a.tif", samples, set), OutputError);
}

TEST(Samples, AreThoseOfTiffsInAllLayouts) {
  const TemporaryFolder folder;
  const std::uint16_t kSeparate = PLANARCONFIG_SEPARATE;
  const TiffLayout layouts[] = {{},
                                {.coding = COMPRESSION_LZW, .predictor = PREDICTOR_HORIZONTAL},
                                {.coding = COMPRESSION_ADOBE_DEFLATE},
                                {.coding = COMPRESSION_ADOBE_DEFLATE, .planes = kSeparate},
                                {.tile = 16},
                                {.coding = COMPRESSION_LZW, .planes = kSeparate, .tile = 32},
                                {.mode = "w8"},
                                {.mode = "wb"}};
  for (const SampleType type : {SampleType::u8, SampleType::u16, SampleType::f32})
    for (const std::size_t bands : {1u, 2u, 3u, 4u, 5u, 10u, 32u})
      for (std::size_t i = 0; i < std::size(layouts); ++i) {
        TiffLayout layout = layouts[i];
        if (type == SampleType::f32 && layout.predictor != PREDICTOR_NONE) layout.predictor = PREDICTOR_FLOATINGPOINT;
        const Samples samples = noise(37, 23, bands, type);
        test::write_tiff(folder.path() / "a.tif", samples, layout);
        const Samples read = read_samples(folder.path() / "a.tif");
        EXPECT_EQ(read.width, 37);
        EXPECT_EQ(read.height, 23);
        EXPECT_EQ(read.bands, bands);
        EXPECT_EQ(read.type, type);
        EXPECT_EQ(read.bytes, samples.bytes) << bands << " bands, layout " << i;
      }
}

// Strips and tiles are read one by one, and looked at before they are decoded.
TEST(Samples, OfDamagedTiffsAreAnError) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.tif";
  const Samples samples = noise(37, 23, 3, SampleType::u16);
  for (const TiffLayout& layout : {TiffLayout{.coding = COMPRESSION_ADOBE_DEFLATE}, TiffLayout{},
                                   TiffLayout{.coding = COMPRESSION_ADOBE_DEFLATE, .tile = 16, .mode = "w8"}}) {
    test::write_tiff(file, samples, layout);
    const std::string whole = test::read_file(file);
    const auto error_of = [&](const std::string& bytes) -> std::string {
      folder.write("a.tif", bytes);
      try {
        read_samples(file);
        return "";
      } catch (const InputError& error) {
        return error.what();
      }
    };
    EXPECT_EQ(error_of(whole), "");
    for (std::size_t length = 0; length < whole.size(); length += 7)
      EXPECT_TRUE(contains(error_of(whole.substr(0, length)), "a.tif")) << length;
    if (layout.coding == COMPRESSION_NONE) continue;
    // The checksum that ends the first stream, which libtiff does not look at.
    const std::size_t begin = whole.find('\x78');
    ASSERT_NE(begin, std::string::npos);
    std::size_t found = 0;
    for (std::size_t at = begin; at < whole.size(); at += 11) {
      std::string damaged = whole;
      damaged[at] ^= '\x10';
      const std::string error = error_of(damaged);
      found += contains(error, "the compressed data that begin here are damaged") ? 1 : 0;
    }
    EXPECT_GT(found, (whole.size() - begin) / 11 / 2);
  }
}

template <typename T>
std::filesystem::path store(const TemporaryFolder& folder, const std::string& name, int channels, OIIO::TypeDesc type,
                            OIIO::TypeDesc stored, const std::vector<T>& samples) {
  const auto file = folder.path() / name;
  OIIO::ImageSpec spec(static_cast<int>(samples.size()) / channels, 1, channels, stored);
  spec["oiio:UnassociatedAlpha"] = 1;
  const auto out = OIIO::ImageOutput::create(file.string());
  EXPECT_TRUE(out && out->open(file.string(), spec) && out->write_image(type, samples.data()) && out->close());
  return file;
}

TEST(Samples, AreThoseOfPngsAndExrs) {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> words{0, 1, 257, 4095, 40000, 65535};
  const Samples png = read_samples(store(folder, "a.png", 3, OIIO::TypeUInt16, OIIO::TypeUInt16, words));
  EXPECT_EQ(png.type, SampleType::u16);
  EXPECT_EQ(png.bytes, test::bytes_in(words));
  // The fourth of a PNG is its alpha.
  const Samples rgba = read_samples(store(folder, "b.png", 4, OIIO::TypeUInt16, OIIO::TypeUInt16,
                                          std::vector<std::uint16_t>{1, 2, 3, 0, 5, 6, 7, 8}));
  EXPECT_EQ(rgba.bands, 3u);
  EXPECT_EQ(rgba.bytes, test::bytes_in(std::vector<std::uint16_t>{1, 2, 3, 5, 6, 7}));
  const std::vector<float> light{0, 0.25f, 1, 2, 1024, 0.5f};
  for (const OIIO::TypeDesc& stored : {OIIO::TypeFloat, OIIO::TypeHalf}) {
    const Samples exr = read_samples(store(folder, "a.exr", 3, OIIO::TypeFloat, stored, light));
    EXPECT_EQ(exr.type, SampleType::f32);
    EXPECT_EQ(exr.bytes, test::bytes_in(light));
  }
}

TEST(Samples, OfDoublesBecomeFloats) {
  const TemporaryFolder folder;
  std::vector<double> doubles{0.1, 1e-3, 7};
  const auto file = folder.path() / "d.tif";
  TIFF* tiff = TIFFOpen(file.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 3);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 64);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFWriteScanline(tiff, doubles.data(), 0, 0);
  TIFFClose(tiff);
  EXPECT_EQ(read_samples(file).bytes, test::bytes_in(std::vector<float>{0.1f, 1e-3f, 7}));
}

TEST(Samples, OfOtherTypesAreRefusedInOneSentence) {
  const TemporaryFolder folder;
  const auto refusal = [&](OIIO::TypeDesc type) {
    return input_error([&] {
      read_samples(store(folder, "a.tif", 1, type, type, std::vector<std::uint64_t>{1, 2, 3}));
    });
  };
  for (const auto& [type, name] :
       {std::pair{OIIO::TypeDesc::UINT32, "type uint"}, std::pair{OIIO::TypeDesc::INT16, "type int16"},
        std::pair{OIIO::TypeDesc::INT32, "type int"}})
    EXPECT_TRUE(contains(refusal(type), std::string("a.tif: holds samples of ") + name)) << refusal(type);
}

TEST(Samples, WithoutDataAreFoundByNanInfinityAndTheDeclaredNumber) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  Samples samples{4, 1, 2, SampleType::f32, test::bytes_in(std::vector<float>{1, 2, nan, 3, 4, -infinity, 5, -9999})};
  const auto file = folder.path() / "a.tif";
  const auto missing = [&] {
    const StoredPhoto photo = read_stored(file);
    std::string excluded;
    for (int x = 0; x < photo.samples.width; ++x)
      excluded += photo.without_data && photo.without_data->excludes(x, 0) ? 'x' : '.';
    return excluded;
  };
  test::write_tiff(file, samples);
  EXPECT_EQ(missing(), ".xx.");
  test::write_tiff(file, samples, {.nodata = "-9999"});
  EXPECT_EQ(missing(), ".xxx");
  EXPECT_EQ(read_samples(file).bytes, test::bytes_in(std::vector<float>{1, 2, 0, 3, 4, 0, 5, 0}));
  samples = {3, 1, 1, SampleType::u16, test::bytes_in(std::vector<std::uint16_t>{0, 7, 65535})};
  test::write_tiff(file, samples);
  EXPECT_EQ(missing(), "...");
  test::write_tiff(file, samples, {.nodata = " 65535 "});
  EXPECT_EQ(missing(), "..x");
}

TEST(Samples, HolesAreFilledAsThoseOfImagesAre) {
  Samples samples = noise(19, 11, 3, SampleType::u8);
  Image image{19, 11, 3, {}};
  for (const std::byte byte : samples.bytes) image.pixels.push_back(std::to_integer<std::uint8_t>(byte));
  std::vector<std::uint8_t> known(19 * 11, 1);
  for (int y = 3; y < 9; ++y)
    for (int x = 4; x < 15; ++x) known[pixel_index(x, y, 19)] = 0;
  const Samples before = samples;
  fill_holes(samples, known);
  fill_holes(image, known, false);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    EXPECT_NEAR(std::to_integer<int>(samples.bytes[i]), image.pixels[i], 2);  // which rounds at each level
    if (known[i / 3] != 0) {
      EXPECT_EQ(samples.bytes[i], before.bytes[i]);
    }
  }
}

TEST(Samples, AreReducedToMeansRoundedToNearest) {
  const Samples samples{4, 2, 2, SampleType::u16,
                        test::bytes_in(std::vector<std::uint16_t>{1, 65535, 2, 65535, 9, 9, 9, 9,  //
                                                                  2, 65535, 2, 65534, 0, 9, 0, 9})};
  EXPECT_EQ(reduce_samples(samples, 2).bytes, test::bytes_in(std::vector<std::uint16_t>{2, 65535, 5, 9}));
  const Samples reals{2, 2, 1, SampleType::f32, test::bytes_in(std::vector<float>{-1, 0.5f, 0.25f, 1})};
  EXPECT_EQ(reduce_samples(reals, 2).bytes, test::bytes_in(std::vector<float>{0.1875f}));
}

}  // namespace
}  // namespace gpvc::io
