// What kinds of photos there are: depths, channels, colour spaces, orientation tags, embedded profiles.
#include <OpenImageIO/imageio.h>

#include "io/io.h"
#include "strip_model.h"

namespace gpvc {
namespace {

using test::contains;
using test::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;

template <typename T>
std::filesystem::path store(const TemporaryFolder& folder, const std::string& name, int channels,
                            OIIO::TypeDesc type, const std::vector<T>& samples, OIIO::ImageSpec spec = {}) {
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
ColourProfile profile(const std::string& space, std::uint8_t year) {
  ColourProfile icc(512, 0);
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

TEST(PhotoKinds, FloatsAndHalvesFromZeroToOne) {
  const TemporaryFolder folder;
  for (const OIIO::TypeDesc& type : {OIIO::TypeFloat, OIIO::TypeHalf}) {
    OIIO::ImageSpec spec;
    spec.set_format(type);
    const auto file = folder.path() / "a.exr";
    const std::vector<float> samples{0, 0.2f, 1};
    spec.width = spec.full_width = spec.height = spec.full_height = spec.depth = 1;
    spec.nchannels = 3;
    spec.default_channel_names();
    const auto out = OIIO::ImageOutput::create(file.string());
    ASSERT_TRUE(out && out->open(file.string(), spec) && out->write_image(OIIO::TypeFloat, samples.data()) &&
                out->close());
    EXPECT_EQ(read_image(file).pixels, (Bytes{0, 51, 255}));
  }
  EXPECT_EQ(read_image(store(folder, "a.tif", 1, OIIO::TypeFloat, std::vector<float>{0, 1})).pixels,
            (Bytes{0, 0, 0, 255, 255, 255}));
}

// Adobe's CMYK JPEG, whose samples count what is left of white: 200, 40, 80, 255 everywhere.
TEST(PhotoKinds, CmykBecomesRgb) {
  const TemporaryFolder folder;
  constexpr unsigned char kJpeg[] = {
      0xFF, 0xD8, 0xFF, 0xEE, 0x00, 0x0E, 0x41, 0x64, 0x6F, 0x62, 0x65, 0x00, 0x64, 0x00, 0x00, 0x00, 0x00,
      0x00, 0xFF, 0xDB, 0x00, 0x43, 0x00, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
      0x01, 0x01, 0xFF, 0xC0, 0x00, 0x14, 0x08, 0x00, 0x08, 0x00, 0x08, 0x04, 0x43, 0x11, 0x00, 0x4D, 0x11,
      0x00, 0x59, 0x11, 0x00, 0x4B, 0x11, 0x00, 0xFF, 0xC4, 0x00, 0x15, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00,
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x0A, 0x09, 0xFF, 0xC4, 0x00, 0x14,
      0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0xFF, 0xDA, 0x00, 0x0E, 0x04, 0x43, 0x00, 0x4D, 0x00, 0x59, 0x00, 0x4B, 0x00, 0x00, 0x3F, 0x00,
      0x48, 0x02, 0x7E, 0x8F, 0xE7, 0xF0, 0xFF, 0xD9,
  };
  const Image jpeg = read_image(folder.write("a.jpg", {reinterpret_cast<const char*>(kJpeg), sizeof kJpeg}));
  ASSERT_EQ(jpeg.pixels.size(), 3u * 64);
  EXPECT_NEAR(jpeg.pixels[0], 200, 1);
  EXPECT_NEAR(jpeg.pixels[1], 40, 1);
  EXPECT_NEAR(jpeg.pixels[2], 80, 1);
}

TEST(PhotoKinds, OrientationTagsTurnNothing) {
  const TemporaryFolder folder;
  for (const std::string name : {"a.tif", "a.png", "a.jpg"})
    for (int orientation = 1; orientation <= 8; ++orientation) {
      OIIO::ImageSpec spec;
      spec.attribute("Orientation", orientation);
      spec.attribute("Compression", "jpeg:100");
      if (name != "a.jpg") spec.attribute("Compression", "none");
      const Image image = read_image(
          store(folder, name, 1, OIIO::TypeUInt8, Bytes{0, 0, 0, 0, 0, 255, 255, 255, 255, 255}, spec));
      EXPECT_EQ(image.width, 10);
      EXPECT_EQ(image.height, 1);
      EXPECT_LT(image.at(0, 0)[0], 20) << name << " " << orientation;
      EXPECT_GT(image.at(9, 0)[0], 235) << name << " " << orientation;
    }
}

TEST(ColourProfile, ComesFromPhotosOfEveryKind) {
  const TemporaryFolder folder;
  const ColourProfile icc = profile("RGB ", 7);
  OIIO::ImageSpec spec;
  spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())),
                 icc.data());
  for (const char* name : {"a.jpg", "a.png", "a.tif"}) {
    EXPECT_EQ(read_colour_profile(store(folder, name, 3, OIIO::TypeUInt8, Bytes{1, 2, 3}, spec)), icc)
        << name;
    EXPECT_EQ(read_colour_profile(store(folder, name, 3, OIIO::TypeUInt8, Bytes{1, 2, 3})), ColourProfile{})
        << name;
  }
}

TEST(ColourProfile, IsWrittenIntoPages) {
  const TemporaryFolder folder;
  ColourProfile icc = profile("RGB ", 7);
  const Image page{3, 2, 3, Bytes(18, 99)};
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpg}) {
    const auto file = folder.path() / (format == ImageFormat::png ? "a.png" : "a.jpg");
    write_image(file, page, format, 95, icc);
    EXPECT_EQ(read_colour_profile(file), icc);
    EXPECT_EQ(read_image(file).pixels.size(), page.pixels.size());
    write_image(file, page, format, 95);
    EXPECT_EQ(read_colour_profile(file), ColourProfile{});
  }
  write_image(folder.path() / "a.png", page, ImageFormat::png, 0, icc);
  EXPECT_FALSE(contains(test::read_file(folder.path() / "a.png"), "sRGB")) << "one or the other";
  // JPEG cuts profiles above 64 KiB into several markers.
  icc.resize(200000, 5);
  icc[1] = 3;
  icc[2] = 13;
  icc[3] = 64;
  write_image(folder.path() / "a.jpg", page, ImageFormat::jpg, 95, icc);
  EXPECT_EQ(read_colour_profile(folder.path() / "a.jpg"), icc);
}

// Photos of other colour spaces come converted: their profile would be wrong.
TEST(ColourProfile, OfGreyOrInkIsNoneOfPages) {
  const TemporaryFolder folder;
  for (const std::string space : {"GRAY", "CMYK"}) {
    const ColourProfile icc = profile(space, 7);
    OIIO::ImageSpec spec;
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(icc.size())),
                   icc.data());
    EXPECT_EQ(read_colour_profile(store(folder, "a.tif", 1, OIIO::TypeUInt8, Bytes{1, 2, 3}, spec)),
              ColourProfile{});
  }
}

}  // namespace
}  // namespace gpvc
