#include "atlas/blending/coarse_photo.h"

#include <algorithm>

#include "io/bilinear.h"
#include "io/images.h"

namespace gpvc::atlas {

CoarsePhoto::CoarsePhoto(const Image& photo)
    : image_(io::reduce_image(photo, std::min({kCoarsePixel, photo.width, photo.height}))) {}

Color CoarsePhoto::at(const PhotoPoint& q) const {
  const auto rgb = bilinear<float>(image_, q.x / kCoarsePixel, q.y / kCoarsePixel);
  return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace gpvc::atlas
