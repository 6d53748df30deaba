#include "labeling/costs/photo_lookup.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace gpvc::labeling {

PhotoLookup::PhotoLookup(const Camera& camera) : camera_(camera) {
  if (camera.distortion.is_identity()) return;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  columns_ = camera.width / kStep + 2;
  const int rows = camera.height / kStep + 2;
  nodes_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns_; ++i)
      nodes_.push_back(photo_from_pixel(camera, {i * kStep + 0.5, j * kStep + 0.5}).value_or(PhotoPoint{kNan, kNan}));
}

std::optional<std::size_t> PhotoLookup::pixel(int x, int y) const {
  const std::optional<PhotoPoint> exact = photo_from_pixel(camera_, {x + 0.5, y + 0.5});
  if (!exact) return std::nullopt;
  return clamped_index(exact->x, exact->y);
}

std::size_t PhotoLookup::clamped_index(double x, double y) const {
  // A cast truncates instead of flooring; the two differ below 0 alone, where the result is clamped.
  const auto clamp = [](double value, int size) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(value), 0, size - 1));
  };
  return clamp(y, camera_.height) * static_cast<std::size_t>(camera_.width) + clamp(x, camera_.width);
}

void PhotoLookup::find_row(int y, std::vector<std::uint32_t>& row) const {
  row.resize(static_cast<std::size_t>(camera_.width));
  if (nodes_.empty()) {
    std::iota(row.begin(), row.end(), static_cast<std::uint32_t>(pixel_index(0, y, camera_.width)));
    return;
  }
  const double down = (y % kStep) * (1.0 / kStep);
  const PhotoPoint* above = nodes_.data() + static_cast<std::size_t>(y / kStep) * static_cast<std::size_t>(columns_);
  const PhotoPoint* below = above + columns_;
  const auto node = [&](int cell) -> PhotoPoint {
    return {above[cell].x + down * (below[cell].x - above[cell].x),
            above[cell].y + down * (below[cell].y - above[cell].y)};
  };
  // Floats, of which a vector register holds more, round photo coordinates by less than 1e-3 px.
  const auto last_x = static_cast<float>(camera_.width - 1), last_y = static_cast<float>(camera_.height - 1);
  for (int begin = 0; begin < camera_.width; begin += kStep) {
    const PhotoPoint a = node(begin / kStep), b = node(begin / kStep + 1);
    const auto x0 = static_cast<float>(a.x), y0 = static_cast<float>(a.y);
    const float dx = static_cast<float>(b.x - a.x) / kStep, dy = static_cast<float>(b.y - a.y) / kStep;
    const int count = std::min(kStep, camera_.width - begin);
    std::uint32_t* out = row.data() + begin;
    if (dx == dx && dy == dy) {  // not NaN
      for (int i = 0; i < count; ++i) {
        const float px = std::min(std::max(x0 + static_cast<float>(i) * dx, 0.0f), last_x);
        const float py = std::min(std::max(y0 + static_cast<float>(i) * dy, 0.0f), last_y);
        out[i] = static_cast<std::uint32_t>(static_cast<int>(py)) * static_cast<std::uint32_t>(camera_.width) +
                 static_cast<std::uint32_t>(static_cast<int>(px));
      }
    } else {
      for (int i = 0; i < count; ++i) {
        const std::optional<std::size_t> exact = pixel(begin + i, y);
        out[i] = exact ? static_cast<std::uint32_t>(*exact) : kNoPixel;
      }
    }
  }
}

}  // namespace gpvc::labeling
