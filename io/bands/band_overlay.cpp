#include "io/bands/band_overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/bands/band_cameras.h"

namespace gpvc::io {
namespace {

/// Where a file of bands has a place of the photo, and what it shows there.
class Overlay {
 public:
  Overlay(const StoredPhoto& file, const BandPlace& place, const BandCamera* camera)
      : file_(file), m_(place.file_from_photo) {
    if (camera != nullptr) {
      grid_.emplace(*camera, place.nearness);
      return;
    }
    const auto whole = [](double value) { return value == std::floor(value); };
    is_shift_ = m_[0] == 1 && m_[1] == 0 && m_[3] == 0 && m_[4] == 1 && whole(m_[2]) && whole(m_[5]);
  }

  /// Writes all bands of the file at the photo's pixel (x, y). False: the file shows nothing there.
  bool put(int x, int y, std::byte* to) const {
    const Samples& from = file_.samples;
    const std::optional<PhotoPoint> place = place_of(x + 0.5, y + 0.5);
    if (!place) return false;
    const auto [px, py] = *place;
    if (!(px >= 0 && py >= 0 && px < from.width && py < from.height)) return false;
    if (is_shift_) {
      const int at_x = static_cast<int>(px), at_y = static_cast<int>(py);
      std::memcpy(to, from.at(at_x, at_y), from.pixel_bytes());
      return !is_missing(at_x, at_y);
    }
    return interpolate(px - 0.5, py - 0.5, to);
  }

 private:
  std::optional<PhotoPoint> place_of(double x, double y) const {
    if (grid_) return grid_->at(x, y);
    return PhotoPoint{m_[0] * x + m_[1] * y + m_[2], m_[3] * x + m_[4] * y + m_[5]};
  }
  bool is_missing(int x, int y) const { return file_.without_data && file_.without_data->excludes(x, y); }

  /// Cubic convolution (Keys 1981, a = -1/2), within the values that it is made of: what overshoots them would be light that no
  /// pixel has, or less than none.
  bool interpolate(double x, double y, std::byte* to) const {
    const Samples& from = file_.samples;
    const double left = std::floor(x), top = std::floor(y);
    const std::array<float, 4> wx = weights(x - left), wy = weights(y - top);
    std::array<int, 4> columns{}, rows{};
    for (int i = 0; i < 4; ++i) {
      columns[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(left) - 1 + i, 0, from.width - 1);
      rows[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(top) - 1 + i, 0, from.height - 1);
    }
    if (file_.without_data)
      for (const int row : rows)
        for (const int column : columns)
          if (is_missing(column, row)) return false;
    const std::size_t size = bytes_of(from.type);
    for (std::size_t band = 0; band < from.bands; ++band) {
      float sum = 0, low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
      for (std::size_t j = 0; j < 4; ++j)
        for (std::size_t i = 0; i < 4; ++i) {
          const float value = load_sample(from.at(columns[i], rows[j]) + band * size, from.type);
          sum += wx[i] * wy[j] * value;
          low = std::min(low, value);
          high = std::max(high, value);
        }
      store_sample(to + band * size, from.type, std::clamp(sum, low, high));
    }
    return true;
  }

  static std::array<float, 4> weights(double t) {
    const double t2 = t * t, t3 = t2 * t;
    return {static_cast<float>(-0.5 * t + t2 - 0.5 * t3), static_cast<float>(1 - 2.5 * t2 + 1.5 * t3),
            static_cast<float>(0.5 * t + 2 * t2 - 1.5 * t3), static_cast<float>(-0.5 * t2 + 0.5 * t3)};
  }

  const StoredPhoto& file_;
  std::array<double, 6> m_;
  bool is_shift_ = false;
  std::optional<BandGrid> grid_;  ///< instead of these
};

}  // namespace

std::optional<PhotoExclusion> lay_over(const StoredPhoto& file, const BandPlace& place, const BandCamera* camera,
                                       std::size_t first_band, Samples& all) {
  const Overlay overlay(file, place, camera);
  const std::size_t offset = first_band * bytes_of(all.type);
  return excluded_where(all.width, all.height, [&](std::size_t pixel) {
    const auto width = static_cast<std::size_t>(all.width);
    const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
    return !overlay.put(x, y, all.at(x, y) + offset);
  });
}

}  // namespace gpvc::io
