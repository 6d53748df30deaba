// How unlike what two views show of a cell is, in colour, contrast and structure.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "labeling/costs/cells.h"
#include "labeling/costs/photo_consistency.h"

namespace gpvc::labeling {

using Rgb = std::array<float, 3>;

// Distances are in standard deviations of the difference between two photos of one surface. A doubled contrast counts as much as
// two of them, structure that has nothing in common as five.
inline constexpr float kOfContrast = 2, kOfStructure = 5;

/// Variance of a channel's difference between two photos of a surface.
inline float natural_variance(const Rgb& a, const Rgb& b) {
  const float deviation = natural_deviation((a[0] + a[1] + a[2] + b[0] + b[1] + b[2]) / 6);
  return 2 * deviation * deviation;
}

inline float square(float x) { return x * x; }

inline float squared_difference(const Rgb& a, const Rgb& b) {
  return square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2]);
}

/// What two views, or two places, differ by in colour and contrast.
struct Look {
  Rgb rgb{};
  float log_contrast = 0;
};
inline Look look_of(const CellSight& sight) { return {sight.rgb, sight.log_contrast}; }

inline float squared_distance(const Look& a, const Look& b) {
  return squared_difference(a.rgb, b.rgb) / natural_variance(a.rgb, b.rgb) +
         square(kOfContrast * (a.log_contrast - b.log_contrast));
}

/// Sums over the parts of cells that two views show.
class StructureSums {
 public:
  void add(const CellSight& a, const CellSight& b) {
    if (a.shown == b.shown)
      add_whole(a, b);
    else
      add_shared(a, b);
  }
  /// The variance of the difference by its greatest value, that of two pictures that have nothing in common: 0 to about 1. Where
  /// both are flat it is near 0.
  float unlikeness(float natural_variance) const {
    if (parts_ < 2) return 0;
    const auto parts = static_cast<float>(parts_);
    auto own = static_cast<float>(squares_), difference = static_cast<float>(differences_);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto x = static_cast<float>(x_[c]), y = static_cast<float>(y_[c]);
      own -= (square(x) + square(y)) / parts;
      difference -= square(x - y) / parts;
    }
    return std::max(0.0F, difference) / (std::max(0.0F, own) + 3 * parts * natural_variance);
  }

 private:
  /// Of two that show the same parts, as most do.
  void add_whole(const CellSight& a, const CellSight& b) {
    parts_ += a.shown_parts;
    for (std::size_t c = 0; c < 3; ++c) {
      x_[c] += a.part_levels[c];
      y_[c] += b.part_levels[c];
    }
    squares_ += static_cast<std::int32_t>(a.part_squares + b.part_squares);
    // In two loops, which the compiler vectorizes.
    using Levels = std::array<std::uint8_t, 3 * kCellParts>;
    const auto x = std::bit_cast<Levels>(a.parts), y = std::bit_cast<Levels>(b.parts);
    std::array<std::int16_t, x.size()> differences;
    for (std::size_t i = 0; i < x.size(); ++i) differences[i] = static_cast<std::int16_t>(x[i] - y[i]);
    for (const std::int16_t difference : differences) differences_ += difference * difference;
  }
  void add_shared(const CellSight& a, const CellSight& b) {
    for (std::uint32_t shown = a.shown & b.shown, part = 0; shown != 0; shown >>= 1U, ++part) {
      if ((shown & 1U) == 0) continue;
      ++parts_;
      for (std::size_t c = 0; c < 3; ++c) {
        const int x = a.parts[part][c], y = b.parts[part][c];
        x_[c] += x;
        y_[c] += y;
        squares_ += x * x + y * y;
        differences_ += (x - y) * (x - y);
      }
    }
  }

  std::int32_t parts_ = 0;
  std::int32_t squares_ = 0, differences_ = 0;  // at most 6 x 255^2 for each part of a dozen cells
  std::array<std::int32_t, 3> x_{}, y_{};       // sums of levels
};

}  // namespace gpvc::labeling
