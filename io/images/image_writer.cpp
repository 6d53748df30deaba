// Pages as files.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/images/exif.h"
#include "io/images/image_file.h"
#include "io/images/jpeg_errors.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

/// The buffer that libjpeg writes to. Where it needs more, it takes a larger one and leaves that to its caller.
struct Encoded {
  explicit Encoded(std::size_t expected)
      : room(std::make_unique_for_overwrite<unsigned char[]>(expected)), bytes(room.get()), size(expected) {}
  ~Encoded() {
    if (bytes != room.get()) std::free(bytes);
  }
  std::unique_ptr<unsigned char[]> room;
  unsigned char* bytes;
  unsigned long size;
};

/// In memory, and from there to `out`, so that a full disk is noticed.
void write_jpeg(OutputFile& out, const fs::path& file, const Image& image, int quality, const ColorProfile& profile) {
  JpegErrors errors;
  jpeg_compress_struct state{};
  // More than most take. Memory that nothing is written to costs nothing.
  Encoded encoded(image.pixels.size() / 3 + 4096);
  take_errors(state, errors);
  const bool whole = run(errors, [&] {
    jpeg_create_compress(&state);
    jpeg_mem_dest(&state, &encoded.bytes, &encoded.size);
    state.image_width = static_cast<JDIMENSION>(image.width);
    state.image_height = static_cast<JDIMENSION>(image.height);
    state.input_components = image.channels;
    state.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&state);
    jpeg_set_quality(&state, std::clamp(quality, 1, 100), TRUE);
    for (int c = 0; c < image.channels; ++c) state.comp_info[c].h_samp_factor = state.comp_info[c].v_samp_factor = 1;
    jpeg_start_compress(&state, TRUE);
    if (!profile.empty()) jpeg_write_icc_profile(&state, profile.data(), static_cast<unsigned>(profile.size()));
    const std::size_t row_bytes = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
    while (state.next_scanline < state.image_height) {
      auto* row = const_cast<JSAMPROW>(image.pixels.data() + row_bytes * state.next_scanline);
      jpeg_write_scanlines(&state, &row, 1);
    }
    jpeg_finish_compress(&state);
  });
  jpeg_destroy_compress(&state);
  if (!whole) throw OutputError(file, std::string("cannot be encoded: ") + errors.message.data());
  out.write(encoded.bytes, encoded.size);
}

}  // namespace

void write_image(const fs::path& file, const Image& image, ImageFormat format, int quality,
                 const ColorProfile& profile) {
  if (image.width < 1 || image.height < 1 || image.channels < 1 || image.channels > 4 ||
      (format == ImageFormat::jpg && image.channels != 1 && image.channels != 3) ||
      (format == ImageFormat::webp && image.channels != 3) ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                                 static_cast<std::size_t>(image.channels))
    throw std::invalid_argument("write_image: the pixels do not fit the size or the format");
  OutputFile out(file);
  if (format == ImageFormat::png)
    write_png(out, image, profile);
  else if (format == ImageFormat::webp)
    write_webp(out, file, image, quality);
  else
    write_jpeg(out, file, image, quality, profile);
  out.commit();
}

bool fits_png(const BandSet& set) {
  constexpr std::size_t kMostChannels = 4;
  return set.type != SampleType::f32 && set.bands.size() <= kMostChannels;
}

void write_samples(const fs::path& file, const Samples& samples, const BandSet& set,
                   std::span<const std::uint8_t> mask) {
  const bool is_png = lower_case(file.extension().string()) == ".png";
  if (is_png && !fits_png(set)) throw std::invalid_argument("write_samples: the bands do not fit into a PNG");
  OutputFile out(file);
  if (is_png)
    write_png(out, samples, set);
  else
    write_tiff(out, file, samples, set, mask);
  out.commit();
}

void state_exposure(const fs::path& jpeg, double seconds, double f_number, std::uint32_t sensitivity) {
  const std::string exif = exif_data(seconds, f_number, sensitivity);
  const std::size_t length = exif.size() + 2;
  std::string bytes;
  {
    const FileBytes picture(jpeg);
    // Behind the marker that begins the file.
    bytes = picture.view().substr(0, 2);
    bytes += {'\xFF', '\xE1', static_cast<char>(length >> 8), static_cast<char>(length & 0xFF)};
    bytes += exif;
    bytes += picture.view().substr(2);
  }
  write_file(jpeg, bytes);
}

}  // namespace gpvc::io
