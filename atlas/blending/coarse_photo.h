// A photo without its fine detail.
#pragma once

#include <memory>
#include <utility>

#include "atlas/baking/sampling.h"
#include "io/image.h"
#include "io/photos.h"
#include "io/scene.h"

namespace gpvc::atlas {

using io::kCoarsePixel;

class CoarsePhoto {
 public:
  /// \param means io::coarse_image() of a photo
  explicit CoarsePhoto(std::shared_ptr<const Image> means) : image_(std::move(means)) {}
  const Image& means() const { return *image_; }
  /// At a position in the photo: bilinear between the means of squares; clamped to the outermost of them. O(1).
  Color at(const PhotoPoint& q) const;

 private:
  std::shared_ptr<const Image> image_;
};

}  // namespace gpvc::atlas
