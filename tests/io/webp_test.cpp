// WebP photos and pages.
#include <webp/encode.h>

#include <cmath>
#include <cstring>

#include "io/images.h"
#include "io/images/exif.h"
#include "io/images/image_file.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::read_file;

Image picture(int width, int height) {
  Image image{width, height, 3, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.pixels.push_back(static_cast<std::uint8_t>(128 + 60 * std::sin(0.11 * x + c) + 60 * std::cos(0.07 * y)));
  return image;
}

double mean_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
  return sum / static_cast<double>(a.pixels.size());
}

std::string word(std::size_t value) {
  const auto number = static_cast<std::uint32_t>(value);
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

std::string chunk(const std::string& name, const std::string& data) {
  return name + word(data.size()) + data + std::string(data.size() % 2, '\0');
}

// The extended format around the picture of a plain file. \param flags 0x20: a colour profile, 0x10: alpha, 8: EXIF, 2: it moves
std::string extended(const std::string& plain, char flags, int width, int height, const std::string& before,
                     const std::string& behind) {
  std::string head(10, '\0');
  head[0] = flags;
  head.replace(4, 3, word(static_cast<std::size_t>(width - 1)).substr(0, 3));
  head.replace(7, 3, word(static_cast<std::size_t>(height - 1)).substr(0, 3));
  const std::string content = "WEBP" + chunk("VP8X", head) + before + plain.substr(12) + behind;
  return "RIFF" + word(content.size()) + content;
}

struct WrittenWebp : testing::Test {
  test::TemporaryFolder folder;
  const Image image = picture(121, 83);
  const std::filesystem::path file = folder.path() / "a.webp";
  void SetUp() override { write_image(file, image, ImageFormat::webp, 95); }
};

using Webp = WrittenWebp;

TEST_F(Webp, ReadsWhatWasWritten) {
  const Image back = read_image(file);
  ASSERT_EQ(back.width, 121);
  ASSERT_EQ(back.height, 83);
  ASSERT_EQ(back.channels, 3);
  EXPECT_LT(mean_difference(image, back), 2);
  write_image(file, image, ImageFormat::webp, 20);
  const double coarse = mean_difference(image, read_image(file));
  EXPECT_GT(coarse, mean_difference(image, back)) << "the quality means nothing";
  EXPECT_LT(coarse, 10);
}

TEST_F(Webp, NameMayBeAnotherFormats) {
  std::filesystem::rename(file, folder.path() / "photo.jpg");
  EXPECT_EQ(read_photo_header(folder.path() / "photo.jpg").size.width, 121);
  EXPECT_LT(mean_difference(image, read_image(folder.path() / "photo.jpg")), 2);
}

TEST_F(Webp, HoldsProfileAndExposure) {
  std::string profile(200, '\0');
  profile.replace(16, 4, "RGB ").replace(36, 4, "acsp");
  const std::string exif = exif_data(0.01, 4, 200);
  // Other programs leave out the words that a JPEG's data begin with.
  for (const std::string& data : {exif, exif.substr(6)}) {
    folder.write("x.webp", extended(read_file(file), 0x28, 121, 83, chunk("ICCP", profile), chunk("EXIF", data)));
    EXPECT_EQ(read_color_profile(folder.path() / "x.webp").size(), 200u);
    const std::optional<float> value = read_photo_header(folder.path() / "x.webp").exposure_value;
    ASSERT_TRUE(value.has_value());
    EXPECT_NEAR(*value, *exposure_value(0.01, 4, 200), 1e-3);
    EXPECT_LT(mean_difference(image, read_image(folder.path() / "x.webp")), 2);
  }
  EXPECT_TRUE(read_color_profile(file).empty());
}

TEST_F(Webp, TransparentPixelsAreExcluded) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 32 * 8; ++i)
    rgba.insert(rgba.end(), {200, 100, 50, static_cast<std::uint8_t>(i % 32 < 16 ? 0 : 255)});
  std::uint8_t* bytes = nullptr;
  const std::size_t size = WebPEncodeLosslessRGBA(rgba.data(), 32, 8, 32 * 4, &bytes);
  folder.write("t.webp", {reinterpret_cast<const char*>(bytes), size});
  WebPFree(bytes);
  EXPECT_TRUE(has_alpha(folder.path() / "t.webp"));
  const PhotoExclusion excluded = transparent_pixels(folder.path() / "t.webp");
  EXPECT_EQ(excluded.words[0], 0xFFFFu);
  const Image back = read_image(folder.path() / "t.webp");
  EXPECT_EQ(back.channels, 3);
  EXPECT_EQ(back.at(20, 3)[0], 200);
}

TEST_F(Webp, IsRefusedWhereItIsCut) {
  const std::string good = read_file(file);
  for (std::size_t size = 1; size < good.size(); size += 11) {
    folder.write("cut.webp", good.substr(0, size));
    EXPECT_TRUE(contains(test::input_error([&] { read_image(folder.path() / "cut.webp"); }), "cut.webp: ")) << size;
  }
}

TEST_F(Webp, IsRefusedWhereItMoves) {
  folder.write("m.webp", extended(read_file(file), 2, 121, 83, chunk("ANIM", std::string(6, '\0')), ""));
  EXPECT_TRUE(contains(test::input_error([&] { read_image(folder.path() / "m.webp"); }), "is a WebP that moves"));
}

TEST_F(Webp, HasEdgesOfSoManyPixels) {
  const Image wide{kMostWebpEdge + 1, 1, 3, std::vector<std::uint8_t>(3 * (kMostWebpEdge + 1), 9)};
  try {
    write_image(folder.path() / "wide.webp", wide, ImageFormat::webp, 85);
    FAIL();
  } catch (const OutputError& error) {
    EXPECT_TRUE(contains(error.what(), "wide.webp: cannot be encoded as WebP: it has 16384 x 1 pixels"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "wide.webp"));
  EXPECT_THROW(write_image(file, {1, 1, 1, {7}}, ImageFormat::webp, 85), std::invalid_argument);
}

}  // namespace
}  // namespace gpvc::io
