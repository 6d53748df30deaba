// Numbers of places such that those with close numbers lie close together.
#pragma once

#include <algorithm>
#include <cstdint>

#include "box.h"

namespace gpvc {

/// A Morton curve (Z-order) through the cells of a cube around a box, 2^21 of them along each edge.
class MortonCurve {
 public:
  explicit MortonCurve(const Box& box)
      : low_(box.low),
        extent_(std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z, 1e-300})) {}

  /// The number of the point's cell, or of the nearest one to a point outside the box; less than 2^63.
  std::uint64_t at(const WorldPoint& p) const {
    return spread(p.x - low_.x) | (spread(p.y - low_.y) << 1) | (spread(p.z - low_.z) << 2);
  }

 private:
  /// The bits of the cell's number along an edge, with two zeros between them.
  std::uint64_t spread(double distance) const {
    constexpr double kCells = 2097151;
    auto bits = static_cast<std::uint64_t>(std::clamp(distance / extent_ * kCells, 0.0, kCells));
    bits = (bits | (bits << 32)) & 0x001F00000000FFFFu;
    bits = (bits | (bits << 16)) & 0x001F0000FF0000FFu;
    bits = (bits | (bits << 8)) & 0x100F00F00F00F00Fu;
    bits = (bits | (bits << 4)) & 0x10C30C30C30C30C3u;
    return (bits | (bits << 2)) & 0x1249249249249249u;
  }

  WorldPoint low_;
  double extent_;
};

}  // namespace gpvc
