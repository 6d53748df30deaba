// Parts of the image codec that only io/ needs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/file_bytes.h"
#include "io/images.h"
#include "io/output_file.h"
#include "io/photos.h"

namespace gpvc::io {

/// All channels 0.
inline Image black_image(int width, int height, int channels) {
  return {width, height, channels,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                    static_cast<std::size_t>(channels))};
}

/// Throws InputError for a path where no file lies.
FileBytes image_bytes(const std::filesystem::path& file, FileBytes::Use use);

struct ImageSize {
  int width = 0, height = 0;
};
/// "WIDTH x HEIGHT".
inline std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

/// From the header alone, as stored (orientation not applied). Throws InputError.
ImageSize read_image_size(const std::filesystem::path& file);

/// Bits a sample, and 0 for samples that are no integers. From the header alone. Throws InputError.
int sample_bits(const std::filesystem::path& file);

/// From the header alone. Throws InputError.
bool has_alpha(const std::filesystem::path& file);

/// read_image into `storage`, whose content is lost, if its capacity is what is needed or little more. That of another
/// photo saves asking the system for new pages.
Image read_image(const std::filesystem::path& file, std::vector<std::uint8_t> storage);

/// read_image of a PNG or JPEG in memory, `part` of `file`, which are only named. Throws InputError.
Image decode_image(const std::filesystem::path& file, const std::string& part, std::string_view bytes);

/// An exclusion of no pixel.
inline PhotoExclusion empty_exclusion(int width, int height) {
  const std::size_t stride = (static_cast<std::size_t>(width) + 63) / 64;
  return {width, height, stride, std::vector<std::uint64_t>(stride * static_cast<std::size_t>(height))};
}

inline void exclude(PhotoExclusion& exclusion, std::size_t x, std::size_t y) {
  exclusion.words[y * exclusion.stride + x / 64] |= std::uint64_t{1} << (x % 64);
}

/// Excludes pixels whose alpha is 0. Throws InputError, also when there is no alpha channel.
PhotoExclusion transparent_pixels(const std::filesystem::path& file);

struct MaskPixels {
  PhotoExclusion excluded;
  double grey_share = 0;  ///< of the pixels, of which half tells; 0 where it does not
};

/// Excludes a mask's black pixels: a pixel is worth the largest of its colors, or its alpha if that is less. JPEGs and masks
/// that were resampled are not exactly black and white: what is darker than half of white is excluded. In other files than
/// JPEGs that hold nothing as bright, labels of 0 and 1 as a rule, 0 alone is black, at the file's own depth. Throws
/// InputError.
MaskPixels mask_pixels(const std::filesystem::path& file);

/// A PNG of 8 bits a channel and 1 to 4 channels, quick rather than small. The bytes do not depend on the number of
/// threads.
void write_png(OutputFile& out, const Image& image, const ColorProfile& profile);

}  // namespace gpvc::io
