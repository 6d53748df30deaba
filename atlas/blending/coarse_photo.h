// A photo without its fine detail.
#pragma once

#include "atlas/baking/sampling.h"
#include "io/image.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Edge, in pixels of the photo, of the squares whose means are the pixels of a coarse photo. Detail finer than twice that
/// comes from one photo. With 4 the error on photos held out of three scenes is higher (benchmarks/README.md).
inline constexpr int kCoarsePixel = 2;

class CoarsePhoto {
 public:
  /// O(pixels).
  explicit CoarsePhoto(const Image& photo);
  /// From the means of another one.
  static CoarsePhoto of_means(Image means);
  const Image& means() const { return image_; }
  /// Bilinear between the means of squares; clamped to the outermost of them.
  Color at(const PhotoPoint& q) const;

 private:
  CoarsePhoto() = default;
  Image image_;
};

/// As CoarsePhoto::at, for a few places of a photo. O(1).
Color coarse_color(const Image& photo, const PhotoPoint& q);

}  // namespace gpvc::atlas
