// Reads PNGs through libpng, whose errors end what is under way by a jump. Its warnings are not looked at: damaged data fail
// their check sum, which is an error.
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <string>
#include <vector>

#include "io/bands/band_tags.h"
#include "io/error.h"
#include "io/images/codec.h"

namespace gpvc::io {
namespace {

struct Decoder {
  std::string_view left;  ///< bytes that libpng has not asked for
  png_structp png = nullptr;
  png_infop info = nullptr;
  int passes = 1;  ///< over the rows
  std::array<char, 200> message{};
};

void read_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto* decoder = static_cast<Decoder*>(png_get_io_ptr(png));
  if (count > decoder->left.size()) png_error(png, "the file ends too early");
  std::memcpy(to, decoder->left.data(), count);
  decoder->left.remove_prefix(count);
}

[[noreturn]] void leave(png_structp png, png_const_charp message) {
  auto* decoder = static_cast<Decoder*>(png_get_error_ptr(png));
  std::strncpy(decoder->message.data(), message, decoder->message.size() - 1);
  png_longjmp(png, 1);
}

/// Grey, grey and alpha, RGB or RGBA of 8 or 16 bits, whatever the file holds.
void read_info(Decoder& decoder) {
  png_read_info(decoder.png, decoder.info);
  png_set_expand(decoder.png);  // palettes, fewer bits, a transparent colour
  png_set_swap(decoder.png);    // to little-endian
  decoder.passes = png_set_interlace_handling(decoder.png);
  png_read_update_info(decoder.png, decoder.info);
}

/// False: an error ended `steps`, and `decoder` tells why. Nothing with a destructor may live in `steps`.
template <typename Steps>
[[gnu::noinline]] bool run(Decoder& decoder, const Steps& steps) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  png_set_read_fn(decoder.png, &decoder, read_bytes);
  read_info(decoder);
  steps(decoder);
  return true;
}

/// Calls `steps` behind the image's header. Throws InputError that begins with `failing` where libpng fails.
template <typename Steps>
void decode(const ImageBytes& image, const char* failing, const Steps& steps) {
  Decoder decoder;
  decoder.left = image.view;
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, leave, [](png_structp, png_const_charp) {});
  if (decoder.png != nullptr) decoder.info = png_create_info_struct(decoder.png);
  const bool whole = decoder.info != nullptr && run(decoder, steps);
  png_destroy_read_struct(&decoder.png, &decoder.info, nullptr);
  if (!whole) throw InputError(image.file, image.part, failing + std::string(decoder.message.data()));
}

void convert(const std::uint16_t* row, std::size_t samples, std::uint8_t* to) {
  // To the nearest of 65535 / 255 = 257 steps.
  for (std::size_t i = 0; i < samples; ++i) to[i] = static_cast<std::uint8_t>((row[i] + 128u) / 257u);
}

void convert(const std::uint16_t* row, std::size_t samples, float* to) {
  for (std::size_t i = 0; i < samples; ++i) to[i] = row[i] / 65535.0f;
}

void convert(const std::uint16_t* row, std::size_t samples, std::uint16_t* to) { std::copy_n(row, samples, to); }

/// \pre bytes become other samples only from 16 bits
template <typename Sample>
void decode_rows(const ImageBytes& image, const ImageHeader& header, Sample* to) {
  const bool deep = header.bits == 16;
  const std::size_t samples = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.channels);
  const auto height = static_cast<std::size_t>(header.height);
  std::vector<std::uint16_t> deep_rows;  // one, or all where rows come in several passes
  decode(image, "cannot be decoded whole: ", [&](Decoder& decoder) {
    const png_structp png = decoder.png;
    if (png_get_rowbytes(png, decoder.info) != samples * (deep ? 2 : 1) ||
        png_get_image_height(png, decoder.info) != height)
      png_error(png, "it changes while it is read");
    const bool at_once = decoder.passes == 1;
    if (deep) deep_rows.resize(at_once ? samples : height * samples);
    for (int pass = 1; pass <= decoder.passes; ++pass)
      for (std::size_t y = 0; y < height; ++y) {
        Sample* row = to + y * samples;
        if (!deep) {
          png_read_row(png, reinterpret_cast<png_bytep>(row), nullptr);
          continue;
        }
        std::uint16_t* deep_row = deep_rows.data() + (at_once ? 0 : y * samples);
        png_read_row(png, reinterpret_cast<png_bytep>(deep_row), nullptr);
        if (pass == decoder.passes) convert(deep_row, samples, row);
      }
    png_read_end(png, nullptr);
  });
}

}  // namespace

ImageHeader read_png_header(const ImageBytes& image) {
  ImageHeader header;
  std::string metadata, xmp;
  header.format = "png";
  decode(image, "is no image that can be read: ", [&](Decoder& decoder) {
    header.width = static_cast<int>(png_get_image_width(decoder.png, decoder.info));
    header.height = static_cast<int>(png_get_image_height(decoder.png, decoder.info));
    header.channels = png_get_channels(decoder.png, decoder.info);
    header.bits = png_get_bit_depth(decoder.png, decoder.info);
    png_charp name = nullptr;
    png_bytep profile = nullptr;
    png_uint_32 bytes = 0;
    int compression = 0;
    if (png_get_iCCP(decoder.png, decoder.info, &name, &compression, &profile, &bytes) != 0)
      header.profile.assign(profile, profile + bytes);
    png_textp texts = nullptr;
    const int count = png_get_text(decoder.png, decoder.info, &texts, nullptr);
    for (int i = 0; i < count; ++i) {
      if (texts[i].text == nullptr) continue;
      if (std::strcmp(texts[i].key, kBandsKeyword) == 0) metadata = texts[i].text;
      if (std::strcmp(texts[i].key, "XML:com.adobe.xmp") == 0) xmp = texts[i].text;
    }
  });
  header.type = header.bits == 16 ? SampleType::u16 : SampleType::u8;
  header.bands = bands_of_tags(metadata, xmp, static_cast<std::size_t>(header.channels));
  const bool may_have_alpha = header.channels % 2 == 0 && !name_all(header.bands, header.channels);
  header.alpha_channel = may_have_alpha ? header.channels - 1 : -1;
  return header;
}

void decode_png(const ImageBytes& image, const ImageHeader& header, std::uint8_t* to) {
  decode_rows(image, header, to);
}
void decode_png(const ImageBytes& image, const ImageHeader& header, float* to) { decode_rows(image, header, to); }
void decode_png(const ImageBytes& image, const ImageHeader& header, std::uint16_t* to) {
  decode_rows(image, header, to);
}

}  // namespace gpvc::io
