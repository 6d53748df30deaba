// JPEGs through libjpeg itself. OpenImageIO tells the first of libjpeg's warnings alone, which may be a harmless one, and
// ends before libjpeg looks at what follows the last row, where most damage shows: data that found no place.
#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <vector>

#include <jpeglib.h>
// Behind jpeglib.h:
#include <jerror.h>

#include "io/error.h"
#include "io/images/image_bounds.h"

namespace gpvc::io {
namespace {

/// What libjpeg's callbacks reach.
struct Decoder {
  jpeg_decompress_struct state{};
  jpeg_error_mgr errors{};
  std::jmp_buf failed{};
  const JOCTET* begin = nullptr;
  bool in_header = true;
  std::array<char, JMSG_LENGTH_MAX> message{};
};

[[noreturn]] void leave(j_common_ptr state) {
  auto* decoder = static_cast<Decoder*>(state->client_data);
  decoder->errors.format_message(state, decoder->message.data());
  std::longjmp(decoder->failed, 1);
}

/// Bytes between the data of a scan and the next marker are padding if they are zeros or fit into a word, as some encoders
/// write. Others found no place in the picture, because data before them is damaged. Between headers anything may stand.
bool is_padding(const Decoder& decoder, int count) {
  constexpr int kWord = 4;
  if (decoder.in_header || count <= kWord) return true;
  const JOCTET* end = decoder.state.src->next_input_byte;  // before the marker
  if (count > end - decoder.begin) return false;
  for (const JOCTET* byte = end - count; byte != end; ++byte)
    if (*byte != 0) return false;
  return true;
}

/// libjpeg's warnings include oddities that lose no pixel.
void on_message(j_common_ptr state, int level) {
  if (level >= 0) return;  // no warning
  const auto* decoder = static_cast<const Decoder*>(state->client_data);
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

void print_nothing(j_common_ptr) {}

/// Adobe's programs store inks inverted, 255 being none, and mark their files; libjpeg leaves that to its callers. In files
/// without that mark 255 is all ink.
void rgb_from_cmyk(const std::vector<std::uint8_t>& inks, bool inverted, std::uint8_t* rgb) {
  const auto light = [&](std::size_t at) { return inverted ? inks[at] : 255 - inks[at]; };
  for (std::size_t i = 0; i < inks.size(); i += 4)
    for (std::size_t c = 0; c < 3; ++c) *rgb++ = static_cast<std::uint8_t>((light(i + c) * light(i + 3) + 127) / 255);
}

/// False: `decoder` tells why. No object with a destructor may live here, since errors jump out of it.
bool decode_rows(Decoder& decoder, std::string_view bytes, const JpegRoom& room, std::vector<std::uint8_t>& inks) {
  jpeg_decompress_struct& state = decoder.state;
  if (setjmp(decoder.failed) != 0) return false;
  jpeg_mem_src(&state, decoder.begin, bytes.size());
  jpeg_read_header(&state, TRUE);
  decoder.in_header = false;
  const bool printed = state.jpeg_color_space == JCS_CMYK || state.jpeg_color_space == JCS_YCCK;
  if (printed) state.out_color_space = JCS_CMYK;
  jpeg_start_decompress(&state);
  if (printed) inks.resize(std::size_t{4} * state.output_width);
  const int channels = printed ? 3 : state.output_components;
  if (state.output_width != static_cast<JDIMENSION>(room.width) ||
      state.output_height != static_cast<JDIMENSION>(room.height) || channels != room.channels) {
    constexpr std::string_view kChanged = "it changes while it is read";
    std::ranges::copy(kChanged, decoder.message.begin());
    return false;
  }
  const std::size_t row_bytes = state.output_width * static_cast<std::size_t>(channels);
  while (state.output_scanline < state.output_height) {
    JSAMPROW rgb = room.pixels + row_bytes * state.output_scanline, row = printed ? inks.data() : rgb;
    jpeg_read_scanlines(&state, &row, 1);
    if (printed) rgb_from_cmyk(inks, state.saw_Adobe_marker != FALSE, rgb);
  }
  jpeg_finish_decompress(&state);
  return true;
}

}  // namespace

void decode_jpeg(const ImageBytes& image, const JpegRoom& room) {
  Decoder decoder;
  decoder.begin = reinterpret_cast<const JOCTET*>(image.view.data());
  decoder.state.err = jpeg_std_error(&decoder.errors);
  decoder.state.client_data = &decoder;
  decoder.errors.error_exit = leave;
  decoder.errors.emit_message = on_message;
  decoder.errors.output_message = print_nothing;
  std::vector<std::uint8_t> inks;
  jpeg_create_decompress(&decoder.state);
  const bool whole = decode_rows(decoder, image.view, room, inks);
  jpeg_destroy_decompress(&decoder.state);
  if (!whole)
    throw InputError(image.file, image.part, std::string("cannot be decoded whole: ") + decoder.message.data());
}

}  // namespace gpvc::io
