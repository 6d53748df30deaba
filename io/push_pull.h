// Filling the holes of a picture from ever coarser means of what is known (Gortler et al. 1996, "pull-push").
#pragma once

#include <cstdint>
#include <span>

#include "image.h"
#include "samples.h"

namespace gpvc::io {

/// `known`: per pixel, 0 for unknown ones. Gives each unknown pixel of a picture of 3 channels the color of the smallest block
/// of 2^n x 2^n pixels around it that has a known one: the mean of the block's four parts that have known pixels. A picture
/// without a known pixel stays as it is. `parallel`: rows on several threads, with the same result. O(pixels).
void fill_holes(Image& image, std::span<const std::uint8_t> known, bool parallel);

/// The same of all bands, each mean as a float; on one thread.
void fill_holes(Samples& samples, std::span<const std::uint8_t> known);

}  // namespace gpvc::io
