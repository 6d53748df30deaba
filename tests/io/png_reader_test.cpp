// PNGs of every kind there is, against OpenImageIO's reader, which shares libpng with ours and nothing else.
#include <OpenImageIO/imageio.h>
#include <png.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/images.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

struct Kind {
  int bits, color, interlace;
  bool transparent;  ///< colour or palette entries
};

/// Of random samples.
void write_png(const std::filesystem::path& file, const Kind& kind, png_uint_32 width, png_uint_32 height) {
  const std::unique_ptr<std::FILE, decltype(&std::fclose)> out(std::fopen(file.c_str(), "wb"), std::fclose);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, out.get());
  png_set_IHDR(png, info, width, height, kind.bits, kind.color, kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::mt19937 random(static_cast<unsigned>(kind.bits * 100 + kind.color * 10 + kind.interlace));
  std::vector<png_color> palette(std::size_t{1} << std::min(kind.bits, 8));
  for (png_color& color : palette)
    color = {static_cast<png_byte>(random()), static_cast<png_byte>(random()), static_cast<png_byte>(random())};
  std::vector<png_byte> alphas{0, 128};
  png_color_16 transparent{0, 1, 1, 1, 1};
  if (kind.color == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  if (kind.transparent) png_set_tRNS(png, info, alphas.data(), static_cast<int>(alphas.size()), &transparent);
  png_write_info(png, info);
  std::vector<std::vector<png_byte>> rows(height, std::vector<png_byte>(png_get_rowbytes(png, info)));
  std::vector<png_bytep> pointers;
  for (std::vector<png_byte>& row : rows) {
    for (png_byte& byte : row) byte = static_cast<png_byte>(random());
    pointers.push_back(row.data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
}

std::vector<std::uint8_t> rgb_by_openimageio(const std::filesystem::path& file) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto in = OIIO::ImageInput::open(file.string(), &config);
  const auto channels = static_cast<std::size_t>(in->spec().nchannels);
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(in->spec().image_pixels()) * channels), rgb;
  EXPECT_TRUE(in->read_image(0, 0, 0, in->spec().nchannels, OIIO::TypeUInt8, samples.data()));
  for (std::size_t i = 0; i < samples.size(); i += channels)
    for (std::size_t c = 0; c < 3; ++c) rgb.push_back(samples[i + (channels < 3 ? 0 : c)]);
  return rgb;
}

TEST(PngReader, ReadsEveryKindAsAnotherReaderDoes) {
  const test::TemporaryFolder folder;
  int kinds = 0;
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7})
    for (const int color : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_PALETTE, PNG_COLOR_TYPE_GRAY_ALPHA,
                            PNG_COLOR_TYPE_RGB_ALPHA})
      for (const int bits : {1, 2, 4, 8, 16})
        for (const bool transparent : {false, true}) {
          if (bits < 8 && color != PNG_COLOR_TYPE_GRAY && color != PNG_COLOR_TYPE_PALETTE) continue;
          if (bits == 16 && color == PNG_COLOR_TYPE_PALETTE) continue;
          if (transparent && (color & PNG_COLOR_MASK_ALPHA) != 0) continue;
          const auto file = folder.path() / "a.png";
          write_png(file, {bits, color, interlace, transparent}, 37, 21);
          const Image image = read_image(file);
          EXPECT_EQ(image.width, 37);
          EXPECT_EQ(image.height, 21);
          EXPECT_EQ(image.pixels, rgb_by_openimageio(file)) << bits << " bits, " << color << ", " << transparent;
          ++kinds;
        }
  EXPECT_EQ(kinds, 2 * (2 * (5 + 2 + 4) + 2 + 2));
}

TEST(PngReader, SaysWhatLibpngFinds) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "a.png", {8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, false}, 37, 21);
  std::string bytes = test::read_file(folder.path() / "a.png");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  const std::string said = test::input_error([&] { read_image(folder.write("b.png", bytes)); });
  EXPECT_TRUE(said.find("b.png: cannot be decoded whole: IDAT: ") != std::string::npos) << said;
}

}  // namespace
}  // namespace gpvc::io
