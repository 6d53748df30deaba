// What a photo itself says of its use for a texture: how blurred it is, how bright, how much of it is burnt out.
#pragma once

#include <string>
#include <vector>

#include "io/image.h"

namespace gpvc::evaluate {

struct PhotoQuality {
  /// Standard deviation, in pixels, of the Gaussian that would blur the photo's strongest edges as they are, in the median;
  /// of edges along x or along y, whichever are worse, so that a shake along one axis shows. 0: sharper than can be told, or
  /// no edges.
  double blur = 0;
  double brightness = 0;  ///< mean of the linear luma of sRGB, 0..1
  double clipped = 0;     ///< share of pixels that have a channel at its upper end
};

/// Of a photo of 3 channels. Looks at tiles spread over it, 4 megapixels at most.
///
/// Blur: an edge blurred by sigma has the slope A / sqrt(2 pi (sigma^2 + s^2)) after a Gaussian filter of s. The ratio of
/// its slopes after two such filters gives sigma, whatever its height A and the exposure (Zhuo and Sim 2011, "Defocus map
/// estimation from a single image", section 3); the narrower filter keeps noise away.
PhotoQuality photo_quality(const Image& photo);

/// One line for each kind of thing among the photos that will hurt a texture: blurred ones, and brightness that jumps.
/// `names` are those of the photos, for the lines.
std::vector<std::string> quality_warnings(const std::vector<PhotoQuality>& photos,
                                          const std::vector<std::string>& names);

}  // namespace gpvc::evaluate
