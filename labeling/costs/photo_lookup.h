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

  /// One row of the frame, cheap to make.
  struct Row {
    const PhotoLookup& lookup;
    int y = 0;
    std::vector<PhotoPoint> nodes;  ///< empty: no distortion; NaN where the lens model folds

    /// Index of the photo's pixel (row-major); nullopt where the lens model is undefined.
    std::optional<std::size_t> pixel(int x) const;
  };
  Row row(int y) const;

  /// The same for a single pixel, exactly.
  std::optional<std::size_t> pixel(int x, int y) const;

 private:
  std::size_t clamped_index(double x, double y) const;

  Camera camera_;
  int columns_ = 0;
  std::vector<PhotoPoint> nodes_;
};

inline std::size_t PhotoLookup::clamped_index(double x, double y) const {
  // A cast truncates instead of flooring; the two differ below 0 alone, where the result is clamped.
  const auto clamp = [](double value, int size) {
    const int i = static_cast<int>(value);
    return static_cast<std::size_t>(i < 0 ? 0 : i >= size ? size - 1 : i);
  };
  return clamp(y, camera_.height) * static_cast<std::size_t>(camera_.width) + clamp(x, camera_.width);
}

inline std::optional<std::size_t> PhotoLookup::Row::pixel(int x) const {
  if (nodes.empty()) return pixel_index(x, y, lookup.camera_.width);
  const auto cell = static_cast<std::size_t>(x / kStep);
  const double fraction = (x % kStep) * (1.0 / kStep);
  const PhotoPoint &a = nodes[cell], &b = nodes[cell + 1];
  const double photo_x = a.x + fraction * (b.x - a.x), photo_y = a.y + fraction * (b.y - a.y);
  if (photo_x == photo_x && photo_y == photo_y) return lookup.clamped_index(photo_x, photo_y);
  return lookup.pixel(x, y);
}

}  // namespace gpvc::labeling
