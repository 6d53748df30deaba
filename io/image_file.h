// Parts of the image codec that only io/ needs.
#pragma once

#include <filesystem>

#include "io/io.h"

namespace gpvc {

struct ImageSize {
  int width = 0, height = 0;
};

/// From the header alone, as stored (orientation not applied). Throws InputError.
ImageSize read_image_size(const std::filesystem::path& file);

/// Every `factor` x `factor` block averaged with rounding to nearest; a remainder at the right and bottom is
/// cut. \pre 1 <= factor <= width, height
Image reduce_image(const Image& image, int factor);

/// A PNG of 8 bits a channel and 1 to 4 channels, quick rather than small. The bytes do not depend on the
/// number of threads.
void write_png(OutputFile& out, const Image& image);

}  // namespace gpvc
