// What kinds of photos there are: depths, channels, colour spaces, orientation tags, embedded profiles.
#include <OpenImageIO/imageio.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <limits>

#include <jpeglib.h>

#include "io/images.h"
#include "io/scene_files.h"
#include "tests/atlas/strip_model.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;

template <typename T>
std::filesystem::path store(const TemporaryFolder& folder, const std::string& name, int channels, OIIO::TypeDesc type,
                            const std::vector<T>& samples, OIIO::ImageSpec spec = {}) {
  const auto file = folder.path() / name;
  spec.width = spec.full_width = static_cast<int>(samples.size()) / channels;
  spec.height = spec.full_height = 1;
  spec.depth = spec.full_depth = 1;
  spec.nchannels = channels;
  spec.default_channel_names();
  spec.set_format(type);
  spec["oiio:UnassociatedAlpha"] = 1;
  const auto out = OIIO::ImageOutput::create(file.string());
  EXPECT_TRUE(out && out->open(file.string(), spec) && out->write_image(type, samples.data()) && out->close())
      << (out ? out->geterror() : "");
  return file;
}

/// A small ICC profile that libpng accepts: a header and one tag. `space` is of four letters.
ColorProfile profile(const std::string& space, std::uint8_t year) {
  ColorProfile icc(512, 0);
  for (std::size_t i = 144; i < icc.size(); ++i)
    icc[i] = static_cast<std::uint8_t>(i * i * i / 7);  // libpng wants some bytes left when deflated
  const auto put = [&](std::size_t at, const std::string& word) {
    std::copy(word.begin(), word.end(), icc.begin() + static_cast<std::ptrdiff_t>(at));
  };
  icc[2] = 2;
  icc[8] = 4;
  put(12, "mntr");
  put(16, space);
  put(20, "XYZ ");
  icc[25] = year;
  put(36, "acsp");
  put(68, std::string("\0\0\xF6\xD6\0\1\0\0\0\0\xD3\x2D", 12));  // D50
  icc[131] = 1;
  put(132, std::string("wtpt\0\0\0\x90\0\0\1\x70", 12));
  return icc;
}

TEST(PhotoKinds, SixteenBitsInOneToFourChannels) {
  const TemporaryFolder folder;
  constexpr std::uint16_t k = 257;  // 255 levels to 65535
  for (const std::string name : {"a.png", "a.tif"}) {
    using Words = std::vector<std::uint16_t>;
    EXPECT_EQ(read_image(store(folder, name, 1, OIIO::TypeUInt16, Words{7 * k, 200 * k})).pixels,
              (Bytes{7, 7, 7, 200, 200, 200}));
    EXPECT_EQ(read_image(store(folder, name, 2, OIIO::TypeUInt16, Words{7 * k, 0, 200 * k, 65535})).pixels,
              (Bytes{7, 7, 7, 200, 200, 200}));
    EXPECT_EQ(read_image(store(folder, name, 3, OIIO::TypeUInt16, Words{1 * k, 2 * k, 3 * k})).pixels,
              (Bytes{1, 2, 3}));
    EXPECT_EQ(read_image(store(folder, name, 4, OIIO::TypeUInt16, Words{1 * k, 2 * k, 3 * k, 9 * k})).pixels,
              (Bytes{1, 2, 3}));
  }
}

std::filesystem::path store_exr(const TemporaryFolder& folder, const OIIO::TypeDesc& type,
                                const std::vector<float>& samples) {
  OIIO::ImageSpec spec(static_cast<int>(samples.size()) / 3, 1, 3, type);
  const auto file = folder.path() / "a.exr";
  const auto out = OIIO::ImageOutput::create(file.string());
  EXPECT_TRUE(out && out->open(file.string(), spec) && out->write_image(OIIO::TypeFloat, samples.data()) &&
              out->close());
  return file;
}

TEST(PhotoKinds, AnExrOfAPartOfItsPictureIsRefused) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "part.exr";
  OIIO::ImageSpec spec(4, 2, 3, OIIO::TypeDesc::HALF);
  spec.x = 2;
  spec.full_width = 8;
  spec.full_height = 2;
  const auto output = OIIO::ImageOutput::create(file.string());
  const std::vector<float> light(24, 0.5f);
  ASSERT_TRUE(output->open(file.string(), spec) && output->write_image(OIIO::TypeDesc::FLOAT, light.data()) &&
              output->close());
  EXPECT_TRUE(contains(test::input_error([&] { read_image(file); }), "its data window is not its display"));
}

// An EXR's samples are light: sRGB's curve makes 0.2140 middle grey, and a fifth 123.6. What is no number is black,
// what is brighter than white is white.
TEST(PhotoKinds, LightInFloatsAndHalvesGetsTheScreensCurve) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (const OIIO::TypeDesc& type : {OIIO::TypeFloat, OIIO::TypeHalf}) {
    const auto file = store_exr(folder, type, {0, 0.2f, 1, 0.0021f, 0.2140f, 16, -3, nan, infinity});
    EXPECT_EQ(read_image(file).pixels, (Bytes{0, 124, 255, 7, 127, 255, 0, 0, 255}));
  }
  EXPECT_EQ(read_image(store(folder, "grey.exr", 1, OIIO::TypeFloat, std::vector<float>{0, 0.2f, 1})).pixels,
            (Bytes{0, 0, 0, 124, 124, 124, 255, 255, 255}));
  // 204/256 of a quarter in each colour: light, unless the file says that it has a curve already.
  const auto hdr = [&](const std::string& more) {
    return read_image(folder.write(
        "a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + more + "\n-Y 1 +X 2\n\xCC\xCC\xCC\x7E\xCC\xCC\xCC\x7E"));
  };
  EXPECT_NEAR(hdr("").pixels[0], 124, 1);
  EXPECT_NEAR(hdr("GAMMA=0.4545\n").pixels[0], 51, 1);
  // A TIFF's floats are not said to be light.
  EXPECT_EQ(read_image(store(folder, "a.tif", 1, OIIO::TypeFloat, std::vector<float>{0, 0.2f, 1})).pixels,
            (Bytes{0, 0, 0, 51, 51, 51, 255, 255, 255}));
}

/// A DNG of 64 x 48 sensor elements, white light left of the middle and a fifth of it right, with a tag that says that
/// the camera was held upright.
std::string tiny_dng() {
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count;
    std::string bytes;
  };
  std::vector<Entry> entries;
  const auto add = [&]<typename T>(unsigned tag, unsigned type, std::initializer_list<T> values,
                                   std::size_t parts = 1) {
    std::string bytes;
    for (const T value : values) bytes += test::bytes_of(value);
    entries.push_back({static_cast<std::uint16_t>(tag), static_cast<std::uint16_t>(type),
                       static_cast<std::uint32_t>(values.size() / parts), bytes});
  };
  using Byte = std::uint8_t;
  using Word = std::uint16_t;
  using Long = std::uint32_t;
  constexpr Long kWidth = 64, kHeight = 48, kOrientation = 274, kStrip = 273;
  constexpr unsigned kByte = 1, kAscii = 2, kShort = 3, kLong = 4, kRational = 5, kSigned = 10;
  add(256, kLong, {kWidth});
  add(257, kLong, {kHeight});
  add(258, kShort, {Word{16}});
  add(259, kShort, {Word{1}});      // not compressed
  add(262, kShort, {Word{32803}});  // a colour filter array
  add(271, kAscii, {'T', 'i', 'n', 'y', '\0'});
  add(272, kAscii, {'T', 'i', 'n', 'y', '\0'});
  add(kStrip, kLong, {Long{0}});
  add(kOrientation, kShort, {Word{6}});
  add(277, kShort, {Word{1}});
  add(278, kLong, {kHeight});
  add(279, kLong, {2 * kWidth * kHeight});
  add(33421, kShort, {Word{2}, Word{2}});
  add(33422, kByte, {Byte{0}, Byte{1}, Byte{1}, Byte{2}});  // red, green; green, blue
  add(50706, kByte, {Byte{1}, Byte{4}, Byte{0}, Byte{0}});
  add(50717, kLong, {Long{65535}});
  add(50721, kSigned, {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1}, 2);
  add(50728, kRational, {Long{1}, Long{1}, Long{1}, Long{1}, Long{1}, Long{1}}, 2);
  add(50778, kShort, {Word{21}});  // lit by D65
  constexpr std::size_t kHeader = 8;
  const std::size_t behind = kHeader + 2 + 12 * entries.size() + 4;
  std::size_t strip = behind;
  for (const Entry& entry : entries) strip += entry.bytes.size() > 4 ? entry.bytes.size() : 0;
  std::string file =
      std::string("II*\0", 4) + test::bytes_of(Long{kHeader}) + test::bytes_of(static_cast<Word>(entries.size()));
  std::string far;
  for (const Entry& entry : entries) {
    file += test::bytes_of(entry.tag) + test::bytes_of(entry.type) + test::bytes_of(entry.count);
    std::string field = entry.bytes;
    if (entry.tag == kStrip) field = test::bytes_of(static_cast<Long>(strip));
    if (field.size() > 4) {
      const auto place = static_cast<Long>(behind + far.size());
      far += field;
      field = test::bytes_of(place);
    }
    field.resize(4, '\0');
    file += field;
  }
  file += test::bytes_of(Long{0}) + far;
  for (Long y = 0; y < kHeight; ++y)
    for (Long x = 0; x < kWidth; ++x) file += test::bytes_of(Word{x < kWidth / 2 ? Word{40000} : Word{8000}});
  return file;
}

// As it lies on the sensor, whatever its orientation says. A name that does not say DNG leads to the TIFF reader, as
// does an OpenImageIO without LibRaw: it would take the sensor's elements for grey pixels.
TEST(PhotoKinds, RawPhotosWhereLibRawIsThere) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.dng", tiny_dng());
  const auto tiff = folder.write("a.tif", tiny_dng());
  EXPECT_TRUE(contains(test::input_error([&] { read_image(tiff); }), "a.tif: is a camera's raw photo"));
  if (!OIIO::ImageInput::create("raw")) {
    EXPECT_TRUE(contains(test::input_error([&] { read_image(file); }), "a.dng: is "));
    return;
  }
  const Image image = read_image(file);
  ASSERT_EQ(image.width, 64);
  ASSERT_EQ(image.height, 48);
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(image.at(10, 20)[c], 190);
    EXPECT_NEAR(image.at(54, 20)[c], image.at(54, 40)[c], 1);
    EXPECT_NEAR(image.at(54, 20)[c], 98, 12);
  }
}

// Adobe's CMYK JPEG, whose samples count what is left of white: 200, 40, 80, 255 everywhere.
TEST(PhotoKinds, CmykBecomesRgb) {
  const TemporaryFolder folder;
  constexpr unsigned char kJpeg[] = {
      0xFF, 0xD8, 0xFF, 0xEE, 0x00, 0x0E, 0x41, 0x64, 0x6F, 0x62, 0x65, 0x00, 0x64, 0x00, 0x00, 0x00, 0x00, 0x00,
      0xFF, 0xDB, 0x00, 0x43, 0x00, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0xFF, 0xC0, 0x00,
      0x14, 0x08, 0x00, 0x08, 0x00, 0x08, 0x04, 0x43, 0x11, 0x00, 0x4D, 0x11, 0x00, 0x59, 0x11, 0x00, 0x4B, 0x11,
      0x00, 0xFF, 0xC4, 0x00, 0x15, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x00, 0x00, 0x00, 0x0A, 0x09, 0xFF, 0xC4, 0x00, 0x14, 0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xFF, 0xDA, 0x00, 0x0E, 0x04, 0x43, 0x00, 0x4D,
      0x00, 0x59, 0x00, 0x4B, 0x00, 0x00, 0x3F, 0x00, 0x48, 0x02, 0x7E, 0x8F, 0xE7, 0xF0, 0xFF, 0xD9,
  };
  const Image jpeg = read_image(folder.write("a.jpg", {reinterpret_cast<const char*>(kJpeg), sizeof kJpeg}));
  ASSERT_EQ(jpeg.pixels.size(), 3u * 64);
  EXPECT_NEAR(jpeg.pixels[0], 200, 1);
  EXPECT_NEAR(jpeg.pixels[1], 40, 1);
  EXPECT_NEAR(jpeg.pixels[2], 80, 1);
}

/// A JPEG of one colour in four inks, as the file holds them.
std::string ink_jpeg(J_COLOR_SPACE space, const std::array<JSAMPLE, 4>& inks, bool mark) {
  jpeg_compress_struct state{};
  jpeg_error_mgr errors{};
  state.err = jpeg_std_error(&errors);
  jpeg_create_compress(&state);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&state, &bytes, &size);
  state.image_width = state.image_height = 16;
  state.input_components = 4;
  state.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&state);
  jpeg_set_colorspace(&state, space);
  jpeg_set_quality(&state, 100, TRUE);
  state.write_Adobe_marker = mark ? TRUE : FALSE;
  jpeg_start_compress(&state, TRUE);
  std::vector<JSAMPLE> samples;
  for (int x = 0; x < 16; ++x) samples.insert(samples.end(), inks.begin(), inks.end());
  for (JSAMPROW row = samples.data(); state.next_scanline < state.image_height;) jpeg_write_scanlines(&state, &row, 1);
  jpeg_finish_compress(&state);
  std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&state);
  std::free(bytes);
  return jpeg;
}

// Adobe's files, which say so, hold what an ink leaves of white; others, as libjpeg has it, the ink.
TEST(PhotoKinds, InksAreInvertedWhereAdobesMarkSaysSo) {
  const TemporaryFolder folder;
  const auto expect_color = [&](const std::string& jpeg, const std::array<int, 3>& color) {
    const Image image = read_image(folder.write("inks.jpg", jpeg));
    ASSERT_EQ(image.pixels.size(), 3u * 16 * 16);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(image.pixels[c], color[c], 2);
  };
  expect_color(ink_jpeg(JCS_CMYK, {200, 40, 80, 255}, true), {200, 40, 80});
  expect_color(ink_jpeg(JCS_CMYK, {200, 40, 80, 102}, true), {80, 16, 32});
  expect_color(ink_jpeg(JCS_YCCK, {200, 40, 80, 255}, true), {200, 40, 80});
  expect_color(ink_jpeg(JCS_YCCK, {200, 40, 80, 102}, true), {80, 16, 32});
  expect_color(ink_jpeg(JCS_CMYK, {55, 215, 175, 0}, false), {200, 40, 80});
  expect_color(ink_jpeg(JCS_CMYK, {55, 215, 175, 153}, false), {80, 16, 32});
}

/// Which samples of a scene of one photo are black and white in what is looked at. \param channels of one value each
template <typename Sample>
std::pair<double, double> range_of(const std::string& name, const OIIO::TypeDesc& type,
                                   const std::vector<Sample>& values, std::size_t channels) {
  const TemporaryFolder folder;
  std::vector<Sample> samples;
  for (const Sample value : values) samples.insert(samples.end(), channels, value);
  const std::string width = std::to_string(values.size());
  folder.write("model/cameras.txt", "1 PINHOLE " + width + " 1 500 500 " + width + " 0.5\n");
  folder.write("model/images.txt", "1 1 0 0 0 0 0 0 1 " + name + "\n\n");
  store(folder, name, static_cast<int>(channels), type, samples);
  const Scene scene = read_scene(folder.path() / "model", {.images_dir = folder.path()});
  EXPECT_TRUE(scene.warnings.empty());
  return scene.bands ? std::pair(scene.bands->black, scene.bands->white) : std::pair(0.0, 255.0);
}

using Range = std::pair<double, double>;
constexpr Range kWords{0, 65535}, kReals{0, 1};

TEST(PhotoKinds, DepthThatIsNotUsedIsNotLookedAt) {
  const auto photo = [](auto sample) {
    std::vector<std::uint16_t> samples;
    for (int i = 0; i < 4096; ++i) samples.push_back(static_cast<std::uint16_t>(sample(i)));
    return samples;
  };
  for (const std::string name : {"a.tif", "a.png"}) {
    const auto range = [&](auto sample) { return range_of(name, OIIO::TypeUInt16, photo(sample), 3); };
    EXPECT_EQ(range([](int i) { return 16 * i; }), kWords);
    EXPECT_EQ(range([](int i) { return i; }), (Range{0, 4296})) << "12 bits in 16";
    EXPECT_EQ(range([](int i) { return 29000 + i / 2; }), (Range{28899, 31148})) << "a camera of heat";
    EXPECT_EQ(range([](int i) { return i == 99 ? 60000 : i; }), kWords) << "night, with a lamp";
    EXPECT_EQ(range([](int i) { return i % 2 * 65535; }), kWords) << "black and white";
    EXPECT_EQ(range([](int) { return 7; }), (Range{7, 8})) << "nothing";
    const auto dark = photo([](int i) { return i % 20; });
    EXPECT_EQ(range_of(name, OIIO::TypeUInt8, Bytes(dark.begin(), dark.end()), 3), (Range{0, 255}))
        << "dark, of 8 bits";
    EXPECT_EQ(range_of(name, OIIO::TypeUInt16, photo([](int i) { return 20000 + 5 * i; }), 1), (Range{18998, 41477}))
        << "counts, which are no colours";
  }
}

TEST(PhotoKinds, FloatsBeyondBlackAndWhiteAreLookedAtOverTheirOwnRange) {
  const auto range = [](const std::string& name, auto sample) {
    std::vector<float> samples;
    for (int i = 0; i < 64; ++i) samples.push_back(static_cast<float>(sample(i)));
    return range_of(name, OIIO::TypeFloat, samples, 1);
  };
  const auto expect_near = [](const Range& is, const Range& expected) {
    EXPECT_NEAR(is.first, expected.first, 0.01);
    EXPECT_NEAR(is.second, expected.second, 0.01);
  };
  const auto degrees = [](int i) { return 15 + 0.1 * i; };
  expect_near(range("a.tif", degrees), {14.685, 21.615});
  expect_near(range("a.tif", [](int i) { return -20 + 0.1 * i; }), {-20.315, -13.385});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_near(range("a.tif", [&](int i) { return i < 60 ? nan : 20 + i - 60; }), {19.85, 23.15});
  expect_near(range("a.tif", [](int i) { return i / 63.0; }), {0, 1.05});
  // Light is looked at as a screen shows it, glints or not.
  EXPECT_EQ(range("a.exr", [](int i) { return i < 40 ? 0.5 : 2; }), kReals);
  expect_near(range("a.exr", degrees), {0, 21.615});
}

TEST(PhotoKinds, OrientationTagsTurnNothing) {
  const TemporaryFolder folder;
  for (const std::string name : {"a.tif", "a.png", "a.jpg"})
    for (int orientation = 1; orientation <= 8; ++orientation) {
      OIIO::ImageSpec spec;
      spec.attribute("Orientation", orientation);
      spec.attribute("Compression", "jpeg:100");
      if (name != "a.jpg") spec.attribute("Compression", "none");
      const Image image =
          read_image(store(folder, name, 1, OIIO::TypeUInt8, Bytes{0, 0, 0, 0, 0, 255, 255, 255, 255, 255}, spec));
      EXPECT_EQ(image.width, 10);
      EXPECT_EQ(image.height, 1);
      EXPECT_LT(image.at(0, 0)[0], 20) << name << " " << orientation;
      EXPECT_GT(image.at(9, 0)[0], 235) << name << " " << orientation;
    }
}

TEST(ColorProfile, ComesFromPhotosOfEveryKind) {
  const TemporaryFolder folder;
  const ColorProfile icc = profile("RGB ", 7);
  OIIO::ImageSpec spec;
  spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())), icc.data());
  for (const char* name : {"a.jpg", "a.png", "a.tif"}) {
    EXPECT_EQ(read_color_profile(store(folder, name, 3, OIIO::TypeUInt8, Bytes{1, 2, 3}, spec)), icc) << name;
    EXPECT_EQ(read_color_profile(store(folder, name, 3, OIIO::TypeUInt8, Bytes{1, 2, 3})), ColorProfile{}) << name;
  }
}

TEST(ColorProfile, IsWrittenIntoPages) {
  const TemporaryFolder folder;
  ColorProfile icc = profile("RGB ", 7);
  const Image page{3, 2, 3, Bytes(18, 99)};
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpg}) {
    const auto file = folder.path() / (format == ImageFormat::png ? "a.png" : "a.jpg");
    write_image(file, page, format, 95, icc);
    EXPECT_EQ(read_color_profile(file), icc);
    EXPECT_EQ(read_image(file).pixels.size(), page.pixels.size());
    write_image(file, page, format, 95);
    EXPECT_EQ(read_color_profile(file), ColorProfile{});
  }
  write_image(folder.path() / "a.png", page, ImageFormat::png, 0, icc);
  EXPECT_FALSE(contains(test::read_file(folder.path() / "a.png"), "sRGB")) << "one or the other";
  // JPEG cuts profiles above 64 KiB into several markers.
  icc.resize(200000, 5);
  icc[1] = 3;
  icc[2] = 13;
  icc[3] = 64;
  write_image(folder.path() / "a.jpg", page, ImageFormat::jpg, 95, icc);
  EXPECT_EQ(read_color_profile(folder.path() / "a.jpg"), icc);
}

// Photos of other colour spaces come converted: their profile would be wrong.
TEST(ColorProfile, OfGreyOrInkIsNoneOfPages) {
  const TemporaryFolder folder;
  for (const std::string space : {"GRAY", "CMYK"}) {
    const ColorProfile icc = profile(space, 7);
    OIIO::ImageSpec spec;
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())), icc.data());
    EXPECT_EQ(read_color_profile(store(folder, "a.tif", 1, OIIO::TypeUInt8, Bytes{1, 2, 3}, spec)), ColorProfile{});
  }
}

}  // namespace
}  // namespace gpvc::io
