// Positions in photos as they were taken.
#pragma once

#include "scene.h"

namespace gpvc::io {

/// Where the photo's file has what photo_from_pixel() has at `p`: at full size, whatever the view's reduction, and of a panorama,
/// which views continue beyond its sides, in its own columns. Pixels from the top-left corner; the first one's centre is (0.5, 0.5).
PhotoPoint taken_pixel(const View& view, const PhotoPoint& p);

}  // namespace gpvc::io
