#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <thread>

#include "io/file_bytes.h"
#include "io/images.h"
#include "io/images/exif.h"
#include "io/images/image_file.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;

/// Colours that neither repeat nor compress to nothing, smooth enough for JPEG.
Image picture(int width, int height) {
  Image image{width, height, 3, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.pixels.push_back(static_cast<std::uint8_t>(
            std::lround(127.5 + 60 * std::sin(0.11 * x + c) + 60 * std::cos(0.07 * y - c)) % 256));
  return image;
}

/// Written by OpenImageIO itself, in a layout of the test's choice.
template <typename Values>
std::filesystem::path store(const TemporaryFolder& folder, const std::string& name, int width, int height, int channels,
                            OIIO::TypeDesc type, const Values& samples,
                            const std::vector<std::pair<std::string, int>>& attributes = {}) {
  const auto file = folder.path() / name;
  OIIO::ImageSpec spec(width, height, channels, type);
  for (const auto& [key, value] : attributes) spec.attribute(key, value);
  const auto out = OIIO::ImageOutput::create(file.string());
  EXPECT_TRUE(out && out->open(file.string(), spec) && out->write_image(type, samples.data()) && out->close());
  return file;
}

using Bytes = std::vector<std::uint8_t>;

TEST(ReadImage, RepeatsGrey) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "b.tif", "c.bmp"}) {
    const Image image = read_image(store(folder, name, 2, 1, 1, OIIO::TypeUInt8, Bytes{7, 200}));
    EXPECT_EQ(image.channels, 3);
    EXPECT_EQ(image.pixels, (Bytes{7, 7, 7, 200, 200, 200})) << name;
  }
}

TEST(ReadImage, DropsAlphaWithoutTouchingColors) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, int>> straight{{"oiio:UnassociatedAlpha", 1}};
  const Bytes rgba{10, 20, 30, 0, 40, 50, 60, 128};
  EXPECT_EQ(read_image(store(folder, "a.png", 2, 1, 4, OIIO::TypeUInt8, rgba, straight)).pixels,
            (Bytes{10, 20, 30, 40, 50, 60}));
  EXPECT_EQ(read_image(store(folder, "a.tif", 2, 1, 4, OIIO::TypeUInt8, rgba, straight)).pixels,
            (Bytes{10, 20, 30, 40, 50, 60}));
  EXPECT_EQ(read_image(store(folder, "b.png", 2, 1, 2, OIIO::TypeUInt8, Bytes{10, 0, 40, 128}, straight)).pixels,
            (Bytes{10, 10, 10, 40, 40, 40}));
}

// 16 bits scale by 255 / 65535 = 1 / 257, to the nearest.
TEST(ReadImage, ScalesSixteenBitsWithRounding) {
  const TemporaryFolder folder;
  std::vector<std::uint16_t> samples;
  Bytes expected;
  for (unsigned value = 0; value <= 65535; value += 51) {
    samples.insert(samples.end(), 3, static_cast<std::uint16_t>(value));
    expected.insert(expected.end(), 3, static_cast<std::uint8_t>((value + 128) / 257));
  }
  const int width = static_cast<int>(samples.size() / 3);
  EXPECT_EQ(read_image(store(folder, "a.png", width, 1, 3, OIIO::TypeUInt16, samples)).pixels, expected);
  EXPECT_EQ(read_image(store(folder, "a.tif", width, 1, 3, OIIO::TypeUInt16, samples)).pixels, expected);
}

TEST(ReadImage, ScalesAndClampsFloats) {
  const TemporaryFolder folder;
  const std::vector<float> samples{-1, 0, 0.5f / 255, 0.4f / 255, 1, 7};
  const Bytes expected{0, 0, 1, 0, 255, 255};
  const Image image = read_image(store(folder, "a.tif", 2, 1, 3, OIIO::TypeFloat, samples));
  for (const std::size_t i : {0u, 1u, 3u, 4u, 5u})  // 2 is a tie, which either neighbour may win
    EXPECT_EQ(image.pixels[i], expected[i]) << i;
}

TEST(ReadImage, LeavesOrientationToTheCameras) {
  const TemporaryFolder folder;
  const Image image = picture(64, 40);
  constexpr int kTurnedRight = 6;
  const auto file = store(folder, "a.jpg", 64, 40, 3, OIIO::TypeUInt8, image.pixels, {{"Orientation", kTurnedRight}});
  EXPECT_EQ(OIIO::ImageInput::open(file.string())->spec().get_int_attribute("Orientation"), kTurnedRight);
  const Image back = read_image(file);
  EXPECT_EQ(back.width, 64);
  EXPECT_EQ(back.height, 40);
  EXPECT_NEAR(back.at(60, 2)[0], image.at(60, 2)[0], 12);
}

TEST(ReadImage, ReadsTiledFiles) {
  const TemporaryFolder folder;
  const Image image = picture(100, 70);
  const auto file = folder.path() / "a.tif";
  OIIO::ImageSpec spec(100, 70, 3, OIIO::TypeUInt8);
  spec.tile_width = spec.tile_height = 32;
  const auto out = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(out && out->open(file.string(), spec) && out->write_image(OIIO::TypeUInt8, image.pixels.data()));
  ASSERT_TRUE(out->close());
  EXPECT_EQ(read_image(file).pixels, image.pixels);
}

TEST(ReadImage, RefusesTruncatedFiles) {
  const TemporaryFolder folder;
  const Image image = picture(120, 90);
  for (const std::string name : {"a b.jpg", "a.png", "a.tif", "a.bmp"}) {
    const auto file = store(folder, name, 120, 90, 3, OIIO::TypeUInt8, image.pixels);
    const std::string good = test::read_file(file);
    ASSERT_EQ(read_image(file).width, 120);
    // The last bytes may be a trailer that holds no pixel; a tenth of the file is pixels in every format.
    for (std::size_t part = 0; part < 90; ++part) {
      const auto cut = folder.write("cut " + name, good.substr(0, good.size() * part / 100));
      EXPECT_TRUE(contains(input_error([&] { read_image(cut); }), "cut " + name)) << part << " %";
    }
  }
}

TEST(ReadImage, RefusesJpegAndPngCutAtEveryByte) {
  const TemporaryFolder folder;
  const Image image = picture(24, 20);
  for (const std::string name : {"a.jpg", "a.png"}) {
    const std::string good = test::read_file(store(folder, name, 24, 20, 3, OIIO::TypeUInt8, image.pixels));
    for (std::size_t size = 0; size < good.size(); ++size)
      EXPECT_THROW(read_image(folder.write("cut" + name, good.substr(0, size))), InputError) << name << " at " << size;
  }
}

// Stray bytes before a marker are a warning of libjpeg's, the only one it gives: what is read is whole, and a cut
// behind them must not pass.
TEST(ReadImage, ToleratesStrayBytesInJpegButNoCutBehindThem) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.jpg";
  const Image image = picture(200, 150);
  write_image(file, image, ImageFormat::jpg, 90);
  const std::string good = test::read_file(file);
  const Pixels pixels = read_image(file).pixels;
  const std::size_t table = good.find("\xFF\xC4");
  ASSERT_NE(table, std::string::npos);
  const std::string stray = good.substr(0, table) + "stray" + good.substr(table);
  EXPECT_EQ(read_image(folder.write("stray.jpg", stray)).pixels, pixels);
  const std::string trailed = good + std::string(1000, 'x') + good.substr(0, 100);
  EXPECT_EQ(read_image(folder.write("trailed.jpg", trailed)).pixels, pixels);
  for (const std::size_t lost : {2u, 10u, 500u, 2000u})
    EXPECT_TRUE(
        contains(input_error([&] { read_image(folder.write("cut.jpg", stray.substr(0, stray.size() - lost))); }),
                 "ends too early"));
}

// Zeros decode to something under nearly all tables, and libjpeg is content; flat pictures, whose data may hold many
// zeros, and padding before a marker are no damage.
TEST(ReadImage, RefusesJpegWithZerosInThePlaceOfData) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.jpg";
  write_image(file, picture(400, 300), ImageFormat::jpg, 95);
  const std::string good = test::read_file(file);
  const std::size_t middle = good.size() / 2;
  // A data unit of zeros has 3 blocks of at most 2 + 63 * 3 bits under the tables of T.81, K.3.
  for (const std::size_t count : {200u, 2000u, 10000u}) {
    std::string damaged = good;
    damaged.replace(middle, count, count, '\0');
    const std::string said = input_error([&] { read_image(folder.write("zeros.jpg", damaged)); });
    EXPECT_TRUE(contains(said, "zeros.jpg: byte " + std::to_string(middle))) << count;
    EXPECT_TRUE(contains(said, std::to_string(count) + " bytes")) << count;
    EXPECT_TRUE(contains(said, "overwritten with zeros")) << count;
  }
  const std::size_t end = good.rfind("\xFF\xD9");
  ASSERT_NE(end, std::string::npos);
  const std::string padded = good.substr(0, end) + std::string(4096, '\0') + good.substr(end);
  EXPECT_EQ(read_image(folder.write("padded.jpg", padded)).pixels, read_image(file).pixels);
  for (const std::uint8_t grey : Bytes{0, 127, 128, 255}) {
    write_image(folder.path() / "flat.jpg", {800, 600, 3, Bytes(3 * 800 * 600, grey)}, ImageFormat::jpg, 90);
    EXPECT_EQ(read_image(folder.path() / "flat.jpg").at(400, 300)[1], grey);
  }
}

// libjpeg is content with most damage until it looks for what follows the last row.
TEST(ReadImage, RefusesJpegWithADamagedBody) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.jpg";
  write_image(file, picture(400, 300), ImageFormat::jpg, 95);
  const std::string good = test::read_file(file);
  const std::size_t data = good.find("\xFF\xDA") + 20;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::string damaged = good;
    for (int n = 0; n < 30; ++n) damaged[data + random() % (good.size() - data - 2)] = static_cast<char>(random());
    const std::string said = input_error([&] { read_image(folder.write("damaged.jpg", damaged)); });
    EXPECT_TRUE(contains(said, "damaged.jpg: ")) << seed;  // at a byte, where the damage made the data end too early
    EXPECT_TRUE(contains(said, "cannot be decoded whole")) << seed;
  }
  const std::string lacking = good.substr(0, data + 1000) + good.substr(data + 3000);
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("lacking.jpg", lacking)); }), "lacking.jpg"));
  // A harmless oddity before the damage: another revision of JFIF.
  std::string odd = good;
  odd[odd.find("JFIF") + 5] = 9;
  EXPECT_EQ(read_image(folder.write("odd.jpg", odd)).pixels, read_image(file).pixels);
  odd.replace(data + 1000, 2000, "");
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("odd.jpg", odd)); }), "odd.jpg"));
}

// Of bytes between the data and the next marker libjpeg warns, though all pixels are there; FF is legal padding (T.81,
// B.1.1.2). More than padding has found no place in the picture, as nearly always where data are damaged.
TEST(ReadImage, TakesPaddingBehindJpegDataButNoDataWithoutPlace) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.jpg";
  write_image(file, picture(200, 150), ImageFormat::jpg, 90);
  const std::string good = test::read_file(file);
  const Pixels pixels = read_image(file).pixels;
  const std::size_t data = good.find("\xFF\xDA") + 20, end = good.rfind("\xFF\xD9");
  const auto padded = [&](const std::string& padding) { return good.substr(0, end) + padding + good.substr(end); };
  for (const std::string& padding :
       {std::string(7, '\xFF'), std::string("\x5A"), std::string("\x12\x34\x56\x78"), std::string(300, '\0')}) {
    EXPECT_EQ(read_image(folder.write("padded.jpg", padded(padding))).pixels, pixels) << padding.size();
    std::string damaged = padded(padding);
    damaged.replace(data + 1000, 700, "");
    EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("damaged.jpg", damaged)); }), "damaged.jpg: "))
        << padding.size();
  }
  const std::string said = input_error([&] { read_image(folder.write("more.jpg", padded("data without a place"))); });
  EXPECT_TRUE(contains(said, "more.jpg: cannot be decoded whole")) << said;
  EXPECT_TRUE(contains(said, "extraneous bytes before marker 0xd9")) << said;
}

// Deflate ends each strip or tile with a checksum, to which libtiff seldom comes, and of JPEGs libjpeg tells what was lost. The
// other codings have neither: of them only what cannot be decoded at all is found.
TEST(ReadImage, RefusesTiffWithDamagedCompressedData) {
  const TemporaryFolder folder;
  const Image image = picture(320, 192);  // whole tiles, so that no byte is left to chance
  const std::vector<std::uint16_t> deep(image.pixels.begin(), image.pixels.end());
  const auto store_as = [&](const std::string& coding) {
    const auto file = folder.path() / "a.tif";
    OIIO::ImageSpec spec(320, 192, 3, coding == "deep" ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8);
    spec.attribute("compression", coding == "jpeg" ? "jpeg:95" : "zip");
    spec.attribute("tiff:RowsPerStrip", coding == "whole" ? 192 : 48);
    if (coding == "big") spec.attribute("tiff:bigtiff", 1);
    if (coding == "tiles") spec.tile_width = spec.tile_height = 64;
    const auto out = OIIO::ImageOutput::create(file.string());
    EXPECT_TRUE(out->open(file.string(), spec) &&
                (coding == "deep" ? out->write_image(OIIO::TypeDesc::UINT16, deep.data())
                                  : out->write_image(OIIO::TypeDesc::UINT8, image.pixels.data())) &&
                out->close());
    return test::read_file(file);
  };
  for (const std::string coding : {"strips", "whole", "big", "tiles", "deep", "jpeg"}) {
    const bool jpeg = coding == "jpeg";
    const std::string good = store_as(coding);
    const Image whole = read_image(folder.write("good.tif", good));
    EXPECT_EQ(whole.width, 320) << coding;
    EXPECT_TRUE(coding == "deep" || jpeg || whole.pixels == image.pixels) << coding;
    for (unsigned seed = 0; seed < 20; ++seed) {
      std::mt19937 random(seed);
      std::string damaged = good;
      for (int n = 0; n < (jpeg ? 60 : 1); ++n)
        damaged[good.size() / 4 + random() % (good.size() / 2)] ^= static_cast<char>(1 + random() % 255);
      EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("damaged.tif", damaged)); }), "damaged.tif: "))
          << coding << " " << seed;
    }
    // All pixels can be read from a stream of which only the end is damaged. The last strip or tile ends the file: four bytes of
    // checksum, and before them a byte that may have bits without a meaning.
    for (unsigned bit = 0; !jpeg && coding != "big" && bit < 80; ++bit) {
      if (bit / 8 == 4) continue;
      std::string damaged = good;
      damaged[good.size() - 1 - bit / 8] ^= static_cast<char>(1 << bit % 8);
      EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("damaged.tif", damaged)); }), "damaged.tif: "))
          << coding << ", bit " << bit;
    }
  }
}

TEST(ReadImage, RefusesPngWithADamagedBody) {
  const TemporaryFolder folder;
  const std::string good =
      test::read_file(store(folder, "a.png", 120, 90, 3, OIIO::TypeUInt8, picture(120, 90).pixels));
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::string damaged = good;
    for (int n = 0; n < 10; ++n) damaged[200 + random() % (good.size() / 2)] = static_cast<char>(random());
    EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("damaged.png", damaged)); }), "damaged.png"))
        << seed;
  }
}

// No pixel is lost where metadata say that they reach beyond their segment.
TEST(ReadImage, TakesJpegWithUnsoundMetadata) {
  const TemporaryFolder folder;
  const Image image = picture(40, 30);
  write_image(folder.path() / "good.jpg", image, ImageFormat::jpg, 95);
  const std::string good = test::read_file(folder.path() / "good.jpg");
  for (const std::string& segment :
       {std::string("Photoshop 3.0\0"
                    "8BIM\x04\x04\0\0\0\0\0\x7F",
                    26),
        std::string("Exif\0\0II*\0\xFF\xFF\xFF\xFF", 14), std::string("ICC_PROFILE\0\x02\x01none", 18)}) {
    for (const char marker : {'\xED', '\xE1', '\xE2'}) {
      const std::string head{'\xFF', marker, '\0', static_cast<char>(segment.size() + 2)};
      const auto file = folder.write("odd.jpg", good.substr(0, 2) + head + segment + good.substr(2));
      EXPECT_EQ(read_image(file).pixels, read_image(folder.path() / "good.jpg").pixels);
      EXPECT_TRUE(read_color_profile(file).empty());
    }
  }
}

TEST(ReadImage, FindsTheExposureValueOfAJpeg) {
  const TemporaryFolder folder;
  write_image(folder.path() / "good.jpg", picture(40, 30), ImageFormat::jpg, 95);
  const std::string good = test::read_file(folder.path() / "good.jpg");
  const auto exposure_of = [&](const std::string& exif) {
    const std::string head{'\xFF', '\xE1', '\0', static_cast<char>(exif.size() + 2)};
    return read_photo_header(folder.write("photo.jpg", good.substr(0, 2) + head + exif + good.substr(2)))
        .exposure_value;
  };
  // f/2.8, 1/400 s, ISO 200: log2(7.84 * 400 / 2).
  ASSERT_TRUE(exposure_of(exif_data(1.0 / 400, 2.8, 200)).has_value());
  EXPECT_NEAR(*exposure_of(exif_data(1.0 / 400, 2.8, 200)), 10.615, 0.001);
  EXPECT_FALSE(exposure_of(exif_data(0, 2.8, 200)).has_value());
  EXPECT_FALSE(exposure_of(exif_data(1.0 / 400, 0.0, 200)).has_value());
  EXPECT_FALSE(exposure_of(exif_data(1.0 / 400, 2.8, 200).substr(0, 50)).has_value());
  EXPECT_FALSE(read_photo_header(folder.path() / "good.jpg").exposure_value.has_value());
}

TEST(ReadImage, GoesByTheBytesNotTheNameInManyThreads) {
  const TemporaryFolder folder;
  const auto named = folder.path() / "in truth a PNG.jpg", other = folder.path() / "in truth a JPEG.png";
  const Image image = picture(40, 30);
  write_image(named, image, ImageFormat::png, 0);
  write_image(other, image, ImageFormat::jpg, 95);
  std::atomic<int> failed = 0, equal = 0;
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int n = 0; n < 100; ++n) try {
          equal += read_image(named).pixels == image.pixels;
          if (read_image(other).width != 40) ++failed;
        } catch (const InputError&) {
          ++failed;
        }
    });
  threads.clear();
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(equal, 400);
}

TEST(ReadImage, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.path() / "absent.jpg"); }), "absent.jpg: does not exist"));
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("a.jpg", "no jpeg")); }), "a.jpg: is no image"));
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("a", "")); }), "a: is empty, expected an image"));
  std::filesystem::create_directory(folder.path() / "b.jpg");
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.path() / "b.jpg"); }), "b.jpg: is a folder"));
}

// Before room for the pixels is asked for: the header alone is changed.
TEST(ReadImage, HoldsClaimedSizesAgainstTheBytes) {
  const TemporaryFolder folder;
  using namespace std::string_view_literals;
  const Image image = picture(24, 20);
  const auto changed = [&](const std::string& name, std::string_view mark, std::size_t behind, std::string_view size) {
    std::string bytes = test::read_file(store(folder, name, 24, 20, 3, OIIO::TypeUInt8, image.pixels));
    bytes.replace(bytes.find(mark) + behind, size.size(), size);
    const PixelRoom none = [](std::size_t bytes_asked) {
      ADD_FAILURE() << bytes_asked << " bytes were asked for";
      return std::vector<std::uint8_t>(bytes_asked);
    };
    return input_error([&] { read_image(folder.write("big" + name, bytes), none, nullptr); });
  };
  EXPECT_TRUE(contains(changed("a.png", "IHDR", 4, "\0\0\x40\0\0\0\x40\0"sv),
                       "biga.png: claims 16384 x 16384 pixels, more than its "));
  EXPECT_TRUE(contains(changed("a.png", "IHDR", 4, "\0\1\0\0\0\1\0\0"sv), "expected at most 2^30"));
  EXPECT_TRUE(contains(changed("a.png", "IHDR", 4, "\0\0\0\0\0\0\0\1"sv), "has no pixels"));
  EXPECT_TRUE(contains(changed("a.jpg", "\xFF\xC0"sv, 5, "\x40\0\x40\0"sv),
                       "biga.jpg: claims 16384 x 16384 pixels, more than its "));
}

// A Targa has no signature: 18 bytes of anything are one. A BMP's size stands at byte 18, little endian, a PNM's in its
// first line.
TEST(ReadImage, TakesNoChanceImages) {
  const TemporaryFolder folder;
  using namespace std::string_view_literals;
  const auto targa = store(folder, "a.tga", 24, 20, 3, OIIO::TypeUInt8, picture(24, 20).pixels);
  EXPECT_TRUE(contains(input_error([&] { read_image(targa); }), "a.tga: is no image that can be read"));
  std::string bmp = test::read_file(store(folder, "a.bmp", 24, 20, 3, OIIO::TypeUInt8, picture(24, 20).pixels));
  bmp.replace(18, 8, "\0\x40\0\0\0\x40\0\0"sv);
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("b.bmp", bmp)); }),
                       "b.bmp: claims 16384 x 16384 pixels, more than its "));
  EXPECT_TRUE(
      contains(input_error([&] { read_image(folder.write("c.ppm", "P6 20000 20000 255\n12345")); }), "c.ppm: "));
  EXPECT_TRUE(contains(input_error([&] { read_image(folder.write("d.null", "x")); }), "d.null: is no image"));
}

// The densest there is: a single colour compresses to 1 of 1028 bytes.
TEST(ReadImage, TakesThePlainestPng) {
  const TemporaryFolder folder;
  const Bytes black(4000 * 4000);
  const auto file = store(folder, "a.png", 4000, 4000, 1, OIIO::TypeUInt8, black, {{"png:compressionLevel", 9}});
  EXPECT_LT(std::filesystem::file_size(file), black.size() / 900);
  EXPECT_EQ(read_image(file).width, 4000);
}

/// How many bytes of a file the system holds in memory.
std::size_t cached_bytes(const std::filesystem::path& file) {
  const FileBytes bytes(file, FileBytes::Use::in_places);
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  std::vector<unsigned char> cached((bytes.view().size() + page - 1) / page);
  EXPECT_EQ(::mincore(const_cast<char*>(bytes.view().data()), bytes.view().size(), cached.data()), 0);
  return page *
         static_cast<std::size_t>(std::count_if(cached.begin(), cached.end(), [](unsigned char c) { return c & 1; }));
}

// All headers of a scene are read before its first photo is.
TEST(ReadImageSize, ReadsNoMoreThanTheHeader) {
  const TemporaryFolder folder(std::filesystem::current_path());  // on a disk as a rule
  const auto file = folder.path() / "p.jpg";
  write_image(file, picture(64, 48), ImageFormat::jpg, 95);
  constexpr std::size_t kSize = 32 << 20;  // many times what any system reads ahead
  const std::string jpeg = test::read_file(file);
  folder.write("p.jpg", jpeg + std::string(kSize - jpeg.size(), 'x'));
  const int descriptor = ::open(file.c_str(), O_RDONLY);
  ASSERT_EQ(::fsync(descriptor), 0);
  ASSERT_EQ(::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED), 0);
  ::close(descriptor);
  if (cached_bytes(file) > kSize / 2) GTEST_SKIP() << "the folder is in memory, where nothing is read ahead";
  EXPECT_EQ(read_photo_header(file).size.width, 64);
  EXPECT_LT(cached_bytes(file), kSize / 2);
  const FileBytes whole(file);
  EXPECT_GT(cached_bytes(file), kSize / 2);
}

TEST(WriteImage, PngReadsBackExactly) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 1}, {1, 5}, {301, 207}, {2048, 700}, {400000, 3}}) {
    const Image image = picture(width, height);
    const auto file = folder.path() / "a page.png";
    write_image(file, image, ImageFormat::png, 0);
    const Image back = read_image(file);
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.pixels, image.pixels);
  }
  EXPECT_EQ(folder.count(), 1);
}

TEST(WriteImage, PngTakesOneToFourChannels) {
  const TemporaryFolder folder;
  for (int channels = 1; channels <= 4; ++channels) {
    Image image{30, 20, channels, {}};
    for (int i = 0; i < 600 * channels; ++i) image.pixels.push_back(static_cast<std::uint8_t>(7 * i));
    const auto file = folder.path() / "a.png";
    write_image(file, image, ImageFormat::png, 0);
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    const auto in = OIIO::ImageInput::open(file.string(), &config);
    ASSERT_TRUE(in);
    ASSERT_EQ(in->spec().nchannels, channels);
    Bytes back(image.pixels.size());
    EXPECT_TRUE(in->read_image(0, 0, 0, channels, OIIO::TypeUInt8, back.data()));
    EXPECT_EQ(back, image.pixels);
  }
}

TEST(WriteImage, PngBytesDoNotDependOnThreads) {
  const TemporaryFolder folder;
  const Image image = picture(1500, 1500);
  const auto written = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    write_image(folder.path() / "a.png", image, ImageFormat::png, 0);
    return test::read_file(folder.path() / "a.png");
  };
  const std::string one = written(1);
  EXPECT_EQ(written(2), one);
  EXPECT_EQ(written(7), one);
}

TEST(WriteImage, RefusesPixelsThatDoNotFitTheSize) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_image(folder.path() / "a.png", {2, 2, 3, Bytes(11)}, ImageFormat::png, 0), std::invalid_argument);
  EXPECT_THROW(write_image(folder.path() / "a.png", {0, 2, 3, {}}, ImageFormat::png, 0), std::invalid_argument);
  EXPECT_EQ(folder.count(), 0);
}

// One red pixel among green: with subsampled chroma it would bleed into its neighbours.
TEST(WriteImage, JpegKeepsChromaOfSinglePixels) {
  const TemporaryFolder folder;
  Image image{16, 16, 3, {}};
  for (int i = 0; i < 256; ++i) image.pixels.insert(image.pixels.end(), {0, 160, 0});
  std::uint8_t* red = image.at(6, 7);
  red[0] = 160;
  red[1] = 0;
  write_image(folder.path() / "a.jpg", image, ImageFormat::jpg, 100);
  const Image back = read_image(folder.path() / "a.jpg");
  EXPECT_NEAR(back.at(6, 7)[0], 160, 6);
  EXPECT_NEAR(back.at(7, 7)[0], 0, 6);
  EXPECT_NEAR(back.at(6, 6)[0], 0, 6);
}

TEST(ReduceImage, AveragesBlocksOfAnySizeAndRoundsOnce) {
  for (const int channels : {1, 3, 4})
    for (const int factor : {2, 3, 4, 7}) {
      Image image{30, 17, channels, {}};
      for (int i = 0; i < 30 * 17 * channels; ++i) image.pixels.push_back(static_cast<std::uint8_t>(i * i % 251));
      const Image reduced = reduce_image(image, factor);
      ASSERT_EQ(reduced.width, 30 / factor);
      ASSERT_EQ(reduced.height, 17 / factor);
      for (int y = 0; y < reduced.height; ++y)
        for (int x = 0; x < reduced.width; ++x)
          for (int c = 0; c < channels; ++c) {
            int sum = 0;
            for (int i = 0; i < factor * factor; ++i)
              sum += image.at(x * factor + i % factor, y * factor + i / factor)[c];
            ASSERT_EQ(reduced.at(x, y)[c], (sum + factor * factor / 2) / (factor * factor))
                << factor << ", " << channels;
          }
    }
}

TEST(WriteImage, JpegQualityTradesSizeForFidelity) {
  const TemporaryFolder folder;
  const Image image = picture(200, 200);
  std::array<std::size_t, 2> size{};
  std::array<double, 2> error{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto file = folder.path() / "a.jpg";
    write_image(file, image, ImageFormat::jpg, i == 0 ? 20 : 95);
    size[i] = std::filesystem::file_size(file);
    const Image back = read_image(file);
    for (std::size_t p = 0; p < image.pixels.size(); ++p) error[i] += std::abs(back.pixels[p] - image.pixels[p]);
  }
  EXPECT_LT(size[0], size[1]);
  EXPECT_GT(error[0], 2 * error[1]);
}

}  // namespace
}  // namespace gpvc::io
