// Reads JPEGs. Of libjpeg's warnings a harmless one may be the first, and most damage shows in what follows the last row: data
// that found no place.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/images/jpeg_errors.h"
// Behind jpeglib.h:
#include <jerror.h>

#include "io/error.h"
#include "io/images/codec.h"
#include "io/images/exif.h"

namespace gpvc::io {
namespace {

struct Decoder : JpegErrors {
  jpeg_decompress_struct state{};
  const JOCTET* begin = nullptr;
  bool in_header = true;
};

/// Bytes between the data of a scan and the next marker are padding if they are zeros or fit into a word, as some encoders
/// write. Others found no place in the picture, because data before them is damaged.
bool is_padding(const Decoder& decoder, int count) {
  constexpr int kWord = 4;
  if (count <= kWord) return true;
  const JOCTET* end = decoder.state.src->next_input_byte;  // before the marker
  if (count > end - decoder.begin) return false;
  for (const JOCTET* byte = end - count; byte != end; ++byte)
    if (*byte != 0) return false;
  return true;
}

/// libjpeg's warnings include oddities that lose no pixel, as do all about what stands between headers.
void on_message(j_common_ptr state, int level) {
  if (level >= 0) return;  // no warning
  const auto* decoder = static_cast<const Decoder*>(static_cast<const JpegErrors*>(state->client_data));
  if (decoder->in_header) return;
  switch (state->err->msg_code) {
    case JWRN_JFIF_MAJOR:
    case JWRN_NOT_SEQUENTIAL:
    case JWRN_ADOBE_XFORM:
      return;
    case JWRN_EXTRANEOUS_DATA:
      if (is_padding(*decoder, state->err->msg_parm.i[0])) return;
  }
  leave(state);
}

/// Adobe's programs store inks inverted, 255 being none, and mark their files; libjpeg leaves that to its callers. In files
/// without that mark 255 is all ink.
void rgb_from_cmyk(const std::vector<std::uint8_t>& inks, bool inverted, std::uint8_t* rgb) {
  const auto light = [&](std::size_t at) { return inverted ? inks[at] : 255 - inks[at]; };
  for (std::size_t i = 0; i < inks.size(); i += 4)
    for (std::size_t c = 0; c < 3; ++c) *rgb++ = static_cast<std::uint8_t>((light(i + c) * light(i + 3) + 127) / 255);
}

bool is_printed(const jpeg_decompress_struct& state) {
  return state.jpeg_color_space == JCS_CMYK || state.jpeg_color_space == JCS_YCCK;
}

int channels_of(const jpeg_decompress_struct& state) { return is_printed(state) ? 3 : state.output_components; }

/// Calls `steps` with a decoder behind the image's header. Throws InputError that begins with `failing` where libjpeg fails.
template <typename Steps>
void decode(const ImageBytes& image, const char* failing, const Steps& steps) {
  Decoder decoder;
  jpeg_decompress_struct& state = decoder.state;
  decoder.begin = reinterpret_cast<const JOCTET*>(image.view.data());
  take_errors(state, decoder);
  decoder.manager.emit_message = on_message;
  const bool whole = run(decoder, [&] {
    jpeg_create_decompress(&state);
    jpeg_mem_src(&state, decoder.begin, static_cast<unsigned long>(image.view.size()));
    jpeg_save_markers(&state, JPEG_APP0 + 1, 0xFFFF);  // EXIF
    jpeg_save_markers(&state, JPEG_APP0 + 2, 0xFFFF);  // colour profiles
    jpeg_read_header(&state, TRUE);
    if (is_printed(state)) state.out_color_space = JCS_CMYK;
    steps(decoder);
  });
  jpeg_destroy_decompress(&state);
  if (!whole) throw InputError(image.file, image.part, failing + std::string(decoder.message.data()));
}

std::optional<float> exposure_value_of(const jpeg_decompress_struct& state) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  for (const jpeg_marker_struct* marker = state.marker_list; marker != nullptr; marker = marker->next) {
    const std::span<const std::uint8_t> data(marker->data, marker->data_length);
    if (marker->marker == JPEG_APP0 + 1 && data.size() > kExif.size() &&
        std::equal(kExif.begin(), kExif.end(), data.begin()))
      return exposure_value(data);
  }
  return std::nullopt;
}

}  // namespace

ImageHeader read_jpeg_header(const ImageBytes& image) {
  ImageHeader header;
  header.format = "jpeg";
  JOCTET* profile = nullptr;
  unsigned profile_bytes = 0;
  decode(image, "is no image that can be read: ", [&](Decoder& decoder) {
    jpeg_calc_output_dimensions(&decoder.state);
    header.width = static_cast<int>(decoder.state.output_width);
    header.height = static_cast<int>(decoder.state.output_height);
    header.channels = channels_of(decoder.state);
    jpeg_read_icc_profile(&decoder.state, &profile, &profile_bytes);
    header.exposure_value = exposure_value_of(decoder.state);
  });
  const std::unique_ptr<JOCTET, decltype(&std::free)> freed(profile, std::free);
  header.profile.assign(profile, profile + profile_bytes);
  return header;
}

void decode_jpeg(const ImageBytes& image, const ImageHeader& header, std::uint8_t* pixels) {
  std::vector<std::uint8_t> inks(std::size_t{4} * static_cast<std::size_t>(header.width));
  decode(image, "cannot be decoded whole: ", [&](Decoder& decoder) {
    jpeg_decompress_struct& state = decoder.state;
    decoder.in_header = false;
    jpeg_start_decompress(&state);
    const int channels = channels_of(state);
    if (state.output_width != static_cast<JDIMENSION>(header.width) ||
        state.output_height != static_cast<JDIMENSION>(header.height) || channels != header.channels) {
      constexpr std::string_view kChanged = "it changes while it is read";
      std::ranges::copy(kChanged, decoder.message.begin());
      std::longjmp(decoder.failed, 1);
    }
    const bool printed = is_printed(state);
    const std::size_t row_bytes = state.output_width * static_cast<std::size_t>(channels);
    while (state.output_scanline < state.output_height) {
      JSAMPROW rgb = pixels + row_bytes * state.output_scanline, row = printed ? inks.data() : rgb;
      jpeg_read_scanlines(&state, &row, 1);
      if (printed) rgb_from_cmyk(inks, state.saw_Adobe_marker != FALSE, rgb);
    }
    jpeg_finish_decompress(&state);
  });
}

}  // namespace gpvc::io
