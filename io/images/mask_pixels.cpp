// Pixels that masks and alphas exclude.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "io/file_bytes.h"
#include "io/images/codec.h"
#include "io/images/image_file.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

/// Excludes by the pixels' alphas alone, or as mask_pixels() does.
enum class Excludes { transparent, dark };

template <typename Sample>
MaskPixels excluded_samples(const ImageBytes& bytes, const ImageHeader& header, Excludes what, Sample white) {
  const auto channels = static_cast<std::size_t>(header.channels), width = static_cast<std::size_t>(header.width);
  check_jpeg(bytes);  // before there is room for what it claims
  std::vector<Sample> samples(width * static_cast<std::size_t>(header.height) * channels);
  decode_samples(bytes, header, header.channels, samples.data());
  const std::size_t pixels = samples.size() / channels;
  const auto alpha_channel = static_cast<std::size_t>(header.alpha_channel);  // past all channels if there is none
  for (std::size_t i = 0; i < pixels; ++i) {
    const Sample* pixel = samples.data() + i * channels;
    Sample value = what == Excludes::dark ? Sample{0} : white;
    for (std::size_t c = 0; c < channels && what == Excludes::dark; ++c)
      if (c != alpha_channel) value = std::max(value, pixel[c]);
    samples[i] = alpha_channel < channels ? std::min(value, pixel[alpha_channel]) : value;
  }
  samples.resize(pixels);
  const auto half = static_cast<Sample>(white / 2);
  const bool soft = what == Excludes::dark &&
                    (bytes.is_jpeg() || std::ranges::any_of(samples, [&](Sample value) { return value > half; }));
  MaskPixels mask{empty_exclusion(header.width, header.height)};
  std::size_t grey = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (soft ? !(samples[i] > half) : samples[i] == Sample{0}) exclude(mask.excluded, i % width, i / width);
    grey += soft && samples[i] > Sample{0} && samples[i] < white ? 1 : 0;
  }
  mask.grey_share = static_cast<double>(grey) / static_cast<double>(pixels);
  return mask;
}

MaskPixels excluded_pixels(const fs::path& file, Excludes what) {
  const FileBytes bytes = image_bytes(file, FileBytes::Use::whole);
  const ImageBytes image{file, "", bytes.view()};
  const ImageHeader header = read_header(image);
  const bool own_mask = what == Excludes::transparent && header.has_mask;
  if (own_mask && header.alpha_channel < 0) return {decode_mask(image, header)};
  if (what == Excludes::transparent && header.alpha_channel < 0)
    throw InputError(file, "", "has lost its alpha channel");
  // Samples are compared at the file's own depth: where 0 alone is black, it is an exact one.
  MaskPixels mask = header.bits == 8 ? excluded_samples<std::uint8_t>(image, header, what, 255)
                                     : excluded_samples<float>(image, header, what, 1);
  if (own_mask) unite(mask.excluded, decode_mask(image, header));
  return mask;
}

}  // namespace

PhotoExclusion transparent_pixels(const fs::path& file) {
  return excluded_pixels(file, Excludes::transparent).excluded;
}

MaskPixels mask_pixels(const fs::path& file) { return excluded_pixels(file, Excludes::dark); }

}  // namespace gpvc::io
