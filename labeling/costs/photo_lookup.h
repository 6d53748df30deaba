// Finds the photo's pixel that lies nearest to a pixel of the undistorted frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/image.h"
#include "io/scene.h"

namespace gpvc::labeling {

/// The distortion, evaluated at every kStep-th pixel and interpolated linearly in between. The error is at most
/// c step^2 / 8 where the second derivative is at most c. A lens of k1 = 0.2 and f = 2000 px has c = 6 k1 r / f < 1e-3 per
/// px at r = 1: an error of 0.02 px, too small to matter for the nearest pixel.
class PhotoLookup {
 public:
  static constexpr int kStep = 16;

  explicit PhotoLookup(const Camera& camera);

  static constexpr std::uint32_t kNoPixel = 0xFFFFFFFFu;

  /// Indices (row-major) of the photo's pixels for the frame's row y; kNoPixel where the lens model is undefined. `row` is
  /// resized to the frame's width. \pre the photo has less than 2^32 - 1 pixels
  void find_row(int y, std::vector<std::uint32_t>& row) const;

  /// The same for a single pixel, exactly.
  std::optional<std::size_t> pixel(int x, int y) const;

 private:
  /// kStep pixels of a row: photo coordinates of the first, and from pixel to pixel.
  struct Cell {
    float x, y, dx, dy;
  };

  std::size_t clamped_index(double x, double y) const;
  bool lies_inside(const Cell& cell) const;
  void fill_inside(const Cell& cell, std::uint32_t* out) const;

  Camera camera_;
  int columns_ = 0;
  std::vector<PhotoPoint> nodes_;  ///< empty: no distortion; NaN where the lens model folds, and about a pole
};

}  // namespace gpvc::labeling
