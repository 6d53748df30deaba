// A photo without its fine detail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "atlas/sampling/sampling.h"
#include "io/image.h"
#include "io/photos.h"
#include "io/scene.h"

namespace gpvc::atlas {

using io::kCoarsePixel;

/// Colours times kSumUnit, summed up as whole numbers, so that no order of the views changes them. Rounding is a 32nd of a
/// grey level a view.
using ColorSum = std::array<std::int16_t, 3>;
inline constexpr float kSumUnit = 16;

class CoarsePhoto {
 public:
  /// \param means io::coarse_image() of a photo
  explicit CoarsePhoto(std::shared_ptr<const Image> means) : image_(std::move(means)) {}
  /// At a position in the photo: bilinear between the means of squares; clamped to the outermost of them. O(1).
  Color at(const PhotoPoint& q) const;

 private:
  std::shared_ptr<const Image> image_;
};

/// What a colour is multiplied by. `gain` is the part of the exposure, above 1 of which highlights are compressed.
struct CellFactor {
  Color factor, gain{1, 1, 1};
};

/// The same for rows of positions.
class CoarseRows {
 public:
  /// \param means io::coarse_image() of a photo. O(pixels).
  explicit CoarseRows(const Image& means);

  /// Adds to sums[i] the colour at the photo's position first + i step times at.factor + i change.factor, its highlights as
  /// with_highlights() leaves them. \pre no sum leaves its range, see kMostSum in face_share.cpp
  void add_row(const PhotoPoint& first, const PhotoPoint& step, const CellFactor& at, const CellFactor& change,
               std::span<ColorSum> sums) const;

 private:
  int width_, height_;
  /// Bytes r, g, b, 0 from the lowest, row-major; the last row and column twice, so that every pixel has neighbours there.
  std::vector<std::uint32_t> pixels_;
};

}  // namespace gpvc::atlas
