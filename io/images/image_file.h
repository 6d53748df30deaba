// Parts of the image codec that only io/ needs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/images.h"
#include "io/output_file.h"

namespace gpvc::io {

struct ImageSize {
  int width = 0, height = 0;
};
/// "WIDTH x HEIGHT".
inline std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

/// From the header alone, as stored (orientation not applied). Throws InputError.
ImageSize read_image_size(const std::filesystem::path& file);

/// From the header alone. Throws InputError.
bool has_alpha(const std::filesystem::path& file);

/// read_image of a PNG or JPEG in memory, `part` of `file`, which are only named. Throws InputError.
Image decode_image(const std::filesystem::path& file, const std::string& part, std::string_view bytes);

struct PixelMarks {
  int width = 0, height = 0;
  std::vector<std::uint8_t> marked;  ///< per pixel, 0 or 1
};

/// Marks pixels whose colour channels are all 0 or whose alpha is 0, at the file's own depth: 1 of 65535 is not black.
/// Throws InputError.
PixelMarks black_pixels(const std::filesystem::path& file);
/// Marks pixels whose alpha is 0. Throws InputError, also when there is no alpha channel.
PixelMarks transparent_pixels(const std::filesystem::path& file);

/// A PNG of 8 bits a channel and 1 to 4 channels, quick rather than small. The bytes do not depend on the number of
/// threads.
void write_png(OutputFile& out, const Image& image, const ColorProfile& profile);

}  // namespace gpvc::io
