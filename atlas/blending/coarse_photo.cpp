#include "atlas/blending/coarse_photo.h"

#include "io/bilinear.h"

namespace gpvc::atlas {

Color CoarsePhoto::at(const PhotoPoint& q) const {
  const auto rgb = bilinear<float>(*image_, q.x / kCoarsePixel, q.y / kCoarsePixel);
  return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace gpvc::atlas
