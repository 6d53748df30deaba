#include "labeling/costs/photo_lookup.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace gpvc::labeling {

PhotoLookup::PhotoLookup(const Camera& camera) : camera_(camera) {
  if (camera.distortion.is_identity()) return;
  constexpr PhotoPoint kUnknown{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  columns_ = camera.width / kStep + 2;
  const int rows = camera.height / kStep + 2;
  nodes_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
  if (shows_pole(camera.distortion.model)) {
    nodes_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows), kUnknown);
    return;
  }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns_; ++i)
      nodes_.push_back(photo_from_pixel(camera, {i * kStep + 0.5, j * kStep + 0.5}).value_or(kUnknown));
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
    const Cell cell{static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(b.x - a.x) / kStep,
                    static_cast<float>(b.y - a.y) / kStep};
    std::uint32_t* out = row.data() + begin;
    const int count = std::min(kStep, camera_.width - begin);
    const bool defined = cell.dx == cell.dx && cell.dy == cell.dy;  // not NaN
    if (defined && count == kStep && lies_inside(cell)) {
      fill_inside(cell, out);
    } else if (defined) {
      for (int i = 0; i < count; ++i) {
        const float px = std::min(std::max(cell.x + static_cast<float>(i) * cell.dx, 0.0f), last_x);
        const float py = std::min(std::max(cell.y + static_cast<float>(i) * cell.dy, 0.0f), last_y);
        out[i] = static_cast<std::uint32_t>(pixel_index(static_cast<int>(px), static_cast<int>(py), camera_.width));
      }
    } else {
      for (int i = 0; i < count; ++i) {
        const std::optional<std::size_t> exact = pixel(begin + i, y);
        out[i] = exact ? static_cast<std::uint32_t>(*exact) : kNoPixel;
      }
    }
  }
}

/// True if all pixels of a cell lie in the photo. Rounding keeps the order of sums and products, so that the first and
/// the last pixel bound those between.
bool PhotoLookup::lies_inside(const Cell& cell) const {
  const float last_x = cell.x + (kStep - 1) * cell.dx, last_y = cell.y + (kStep - 1) * cell.dy;
  return std::min(cell.x, last_x) >= 0 && std::max(cell.x, last_x) < static_cast<float>(camera_.width) &&
         std::min(cell.y, last_y) >= 0 && std::max(cell.y, last_y) < static_cast<float>(camera_.height);
}

/// Most cells lie in one row of the photo. The loops have no branches, so that the compiler vectorizes them.
void PhotoLookup::fill_inside(const Cell& cell, std::uint32_t* out) const {
  std::array<std::int32_t, kStep> columns;
  for (int i = 0; i < kStep; ++i)
    columns[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(cell.x + static_cast<float>(i) * cell.dx);
  const auto width = static_cast<std::uint32_t>(camera_.width);
  const auto first = static_cast<std::int32_t>(cell.y),
             last = static_cast<std::int32_t>(cell.y + (kStep - 1) * cell.dy);
  if (first == last) {
    const std::uint32_t start = static_cast<std::uint32_t>(first) * width;
    for (std::size_t i = 0; i < kStep; ++i) out[i] = start + static_cast<std::uint32_t>(columns[i]);
    return;
  }
  std::array<std::int32_t, kStep> rows;
  for (int i = 0; i < kStep; ++i)
    rows[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(cell.y + static_cast<float>(i) * cell.dy);
  for (std::size_t i = 0; i < kStep; ++i)
    out[i] = static_cast<std::uint32_t>(rows[i]) * width + static_cast<std::uint32_t>(columns[i]);
}

}  // namespace gpvc::labeling
