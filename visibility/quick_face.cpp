#include "visibility/quick_face.h"

#include <limits>

namespace gpvc {

/// Each edge, cut to the row. A position and the point where an edge is cut are off by a few roundings of a
/// coordinate below 2^20 px, far less than the 2^-24 px that are added.
FaceBounds QuickFace::in_row(std::int32_t y) const {
  constexpr double kSlack = 0x1p-24;
  const double top = y - kSlack, bottom = y + 1 + kSlack;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double first = std::min(y_[i], y_[j]), last = std::max(y_[i], y_[j]);
    if (last < top || first > bottom) continue;
    double a = x_[i], b = x_[j];
    if (last - first > kSlack) {
      const double slope = (x_[j] - x_[i]) / (y_[j] - y_[i]);
      a = x_[i] + slope * (std::clamp(top, first, last) - y_[i]);
      b = x_[i] + slope * (std::clamp(bottom, first, last) - y_[i]);
    }
    low = std::min(low, std::min(a, b));
    high = std::max(high, std::max(a, b));
  }
  return {std::max(low - kSlack, bounds_.x0),
          std::max(top, bounds_.y0),
          std::min(high + kSlack, bounds_.x1),
          std::min(bottom, bounds_.y1),
          true,
          true};
}

/// Where a row crosses the line of an edge is known to margin / |height of the edge|, twice that with the
/// rounding of the division. Edges that have the face on their right bound the run from the left.
bool QuickFace::spans(const PixelBox& box, std::vector<Span>& found) const {
  found.clear();
  if (facing_ == Facing::edge_on) return false;
  if (box.empty()) return true;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double turn = facing_ == Facing::front ? -1 : 1;
  const double first_x = box.x0 + 0.5, first_y = box.y0 + 0.5;
  std::array<double, 3> at{}, slope{}, not_left{}, not_right{};
  double least = kNever;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double height = y_[j] - y_[i];
    least = std::min(least, std::abs(height));
    slope[i] = (x_[j] - x_[i]) / height;
    at[i] = (x_[i] - first_x) + slope[i] * (first_y - y_[i]);
    const bool left = turn * height < 0;
    not_left[i] = left ? 0 : -kNever;
    not_right[i] = left ? kNever : 0;
  }
  if (!(least > 8 * margin_)) return false;
  const double tolerance = 2 * margin_ / least;
  const double width = box.x1 - box.x0;
  found.resize(static_cast<std::size_t>(box.y1 - box.y0));
  std::size_t count = 0;
  for (std::int32_t row = 0; row < box.y1 - box.y0; ++row) {
    const double a = at[0] + slope[0] * row, b = at[1] + slope[1] * row, c = at[2] + slope[2] * row;
    double low = std::max(std::max(a + not_left[0], b + not_left[1]), c + not_left[2]);
    double high = std::min(std::min(a + not_right[0], b + not_right[1]), c + not_right[2]);
    // Half a pixel beyond the box is as good as any further.
    low = std::min(std::max(low, -0.5), width + 0.5);
    high = std::min(std::max(high, -0.5), width - 0.5);
    const auto begin = static_cast<std::int32_t>(low + 1), end = static_cast<std::int32_t>(high + 1);
    const double nearest =
        std::min(std::min(begin - low, low - (begin - 1)), std::min(end - high, high - (end - 1)));
    if (!(nearest > tolerance)) return false;
    found[count] = {box.y0 + row, box.x0 + begin, box.x0 + end};
    count += begin < end;
  }
  found.resize(count);
  return true;
}

}  // namespace gpvc
