// Positions in photos as they were taken.
#pragma once

#include <optional>

#include "scene.h"

namespace gpvc::io {

/// Where the photo's file has what photo_from_pixel() has at `p`: at full size, whatever the view's reduction, and of a panorama,
/// which views continue beyond its sides, in its own columns. Pixels from the top-left corner; the first one's centre is (0.5, 0.5).
PhotoPoint taken_pixel(const View& view, const PhotoPoint& p);

/// Where the file of a band shows what the photo shows at a place, if that lies 1 / `nearness` along the photo's axis; pixels of both
/// as they were taken. nullopt: nowhere that is known.
std::optional<PhotoPoint> place_in_file(const BandCamera& band, double nearness, const PhotoPoint& photo);

}  // namespace gpvc::io
