// Where the sub-pixel samples of a face lie.
#pragma once

#include <array>
#include <cstddef>

#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

inline constexpr std::size_t kSubpixelSamples = 4;

/// The midpoints from the centroid to the three vertices, nearest vertex first, then the centroid. x is NaN for a
/// sample that is not in front of the camera.
struct SubpixelPositions {
  std::array<double, kSubpixelSamples> x, y;
  std::array<double, kSubpixelSamples> weighted_z;  ///< depth times the weight of the sample
  double depth(std::size_t k) const { return weighted_z[k] / (k < 3 ? 6 : 3); }
};

/// Each position is rounded once from sums of the projected vertices.
SubpixelPositions subpixel_positions(const PreparedView& view, FaceId face);

}  // namespace gpvc::visibility
