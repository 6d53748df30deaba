// Parts of the image codec that only io/ needs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/file_bytes.h"
#include "io/images.h"
#include "io/output_file.h"
#include "io/photos.h"

namespace gpvc::io {

/// Throws InputError for a path where no file lies.
FileBytes image_bytes(const std::filesystem::path& file, FileBytes::Use use);

/// "WIDTH x HEIGHT".
inline std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

struct PhotoHeader {
  ImageSize size;                         ///< as stored (orientation not applied)
  std::optional<float> exposure_value{};  ///< as in View
  SampleType type = SampleType::u8;
  int channels = 3, alpha_channel = -1;  ///< as in ImageHeader, as what follows
  bool linear_light = false, colors = true;
  std::vector<Band> bands{};
  bool has_mask = false;
};
/// From the header alone. Throws InputError, also for samples of a type that photos can't have.
PhotoHeader read_photo_header(const std::filesystem::path& file);

/// Where the pixels of a picture lie: so many bytes, of any values.
using PixelRoom = std::function<std::vector<std::uint8_t>(std::size_t bytes)>;
inline std::vector<std::uint8_t> new_room(std::size_t bytes) { return std::vector<std::uint8_t>(bytes); }
inline Image image_in(const PixelRoom& room, int width, int height, int channels) {
  return {width, height, channels, room(pixel_index(0, height, width) * static_cast<std::size_t>(channels))};
}
/// All channels 0.
inline Image black_image(int width, int height, int channels) { return image_in(new_room, width, height, channels); }

/// The public functions of these names with pixels in given room. \param transparent not null: becomes transparent_pixels(),
/// which takes no second decoding where alphas have 8 bits
Image read_image(const std::filesystem::path& file, const PixelRoom& room, PhotoExclusion* transparent);
Image reduce_image(const Image& image, int factor, const PixelRoom& room);
Image continue_around(const Image& panorama, const PixelRoom& room);

/// sRGB's curve, IEC 61966-2-1, in levels of 8 bits. Values above white become white, NaN becomes black.
std::uint8_t srgb_from_linear(float light);

/// Means of 2 x 2 pixels of 3 channels, rounded to nearest, as reduce_image() has them: `width` of them.
void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, int width, std::uint8_t* to);

/// read_image of a PNG, JPEG or WebP in memory, `part` of `file`, which are only named. Throws InputError.
Image decode_image(const std::filesystem::path& file, const std::string& part, std::string_view bytes);

/// An exclusion of no pixel.
inline PhotoExclusion empty_exclusion(int width, int height) {
  const std::size_t stride = (static_cast<std::size_t>(width) + 63) / 64;
  return {width, height, stride, std::vector<std::uint64_t>(stride * static_cast<std::size_t>(height))};
}

inline void exclude(PhotoExclusion& exclusion, std::size_t x, std::size_t y) {
  exclusion.words[y * exclusion.stride + x / 64] |= std::uint64_t{1} << (x % 64);
}

inline void unite(PhotoExclusion& all, const PhotoExclusion& more) {
  for (std::size_t i = 0; i < all.words.size(); ++i) all.words[i] |= more.words[i];
}

/// Excludes pixels whose alpha is 0, and those that the file's own mask does. Throws InputError, also when there is neither.
PhotoExclusion transparent_pixels(const std::filesystem::path& file);

/// Calls `excludes` with the number of each pixel, and excludes those for which it returns true; nullopt: there are none.
template <typename Excludes>
std::optional<PhotoExclusion> excluded_where(int width, int height, const Excludes& excludes) {
  std::optional<PhotoExclusion> exclusion;
  std::size_t pixel = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, ++pixel) {
      if (!excludes(pixel)) continue;
      if (!exclusion) exclusion = empty_exclusion(width, height);
      exclude(*exclusion, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
    }
  return exclusion;
}

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

/// The same of samples of 8 or 16 bits, with what their bands are as text. \pre fits_png(set)
void write_png(OutputFile& out, const Samples& samples, const BandSet& set);

/// Samples as TIFF: see write_samples(). Throws OutputError, which names `file`.
void write_tiff(OutputFile& out, const std::filesystem::path& file, const Samples& samples, const BandSet& set,
                std::span<const std::uint8_t> mask);

/// A lossy WebP of 3 channels. The bytes do not depend on the number of threads. Throws OutputError, which names `file`.
void write_webp(OutputFile& out, const std::filesystem::path& file, const Image& image, int quality);

}  // namespace gpvc::io
