#include "io/bands/band_cameras.h"

#include <algorithm>
#include <cmath>

#include "io/order_statistics.h"

namespace gpvc::io {

std::optional<PhotoPoint> place_in_file(const BandCamera& band, double nearness, const PhotoPoint& photo) {
  const std::optional<PixelPoint> p = pixel_from_photo(band.photo, photo);
  if (!p) return std::nullopt;
  const double x = (p->x - band.photo.cx) / band.photo.fx, y = (p->y - band.photo.cy) / band.photo.fy;
  const auto& r = band.file_from_photo;
  const CameraPoint ray{r[0] * x + r[1] * y + r[2] + nearness * band.shift.x,
                        r[3] * x + r[4] * y + r[5] + nearness * band.shift.y,
                        r[6] * x + r[7] * y + r[8] + nearness * band.shift.z};
  if (!(ray.z > 0)) return std::nullopt;
  return photo_from_pixel(band.file, pixel_from_camera(band.file, ray));
}

BandGrid::BandGrid(const BandCamera& band, double nearness) : columns_(band.photo.width / kStep + 2) {
  const int rows = band.photo.height / kStep + 2;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns_; ++column)
      nodes_.push_back(place_in_file(band, nearness, {double{kStep} * column, double{kStep} * row}));
}

std::optional<PhotoPoint> BandGrid::at(double x, double y) const {
  const int column = static_cast<int>(x) / kStep, row = static_cast<int>(y) / kStep;
  const auto* above = nodes_.data() + static_cast<std::ptrdiff_t>(row) * columns_ + column;
  const auto* below = above + columns_;
  if (!above[0] || !above[1] || !below[0] || !below[1]) return std::nullopt;
  const double u = x / kStep - column, v = y / kStep - row;
  const auto mixed = [](const PhotoPoint& a, const PhotoPoint& b, double part) {
    return PhotoPoint{a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part};
  };
  return mixed(mixed(*above[0], *above[1], u), mixed(*below[0], *below[1], u), v);
}

namespace {

/// Where a match shows the place of the photo, and how that place would move with the nearness; pixels of the photo.
struct Residual {
  double right, down, by_x, by_y;
};

std::optional<Residual> residual_of(const CameraMatch& matched) {
  const BandMatch& match = matched.match;
  const BandCamera& band = *matched.band;
  const auto place = [&](double right, double down, double nearness) {
    return place_in_file(band, nearness, {match.x + right, match.y + down});
  };
  const double length = std::hypot(band.shift.x, band.shift.y, band.shift.z);
  const double step = length > 0 ? 1e-4 / length : 0;
  const auto here = place(0, 0, 0), beside = place(1, 0, 0), below = place(0, 1, 0), nearer = place(0, 0, step);
  if (!here || !beside || !below || !nearer) return std::nullopt;
  if (step == 0) return Residual{match.right, match.down, 0, 0};
  // Back from the file's pixels to the photo's.
  const double a = beside->x - here->x, b = below->x - here->x, c = beside->y - here->y, d = below->y - here->y;
  const double x = (nearer->x - here->x) / step, y = (nearer->y - here->y) / step, determinant = a * d - b * c;
  if (determinant == 0) return std::nullopt;
  return Residual{match.right, match.down, (d * x - b * y) / determinant, (a * y - c * x) / determinant};
}

}  // namespace

NearnessFit fit_nearness(std::span<const CameraMatch> matches) {
  if (matches.size() < kFewestMatches) return {};
  // A match tells by how much of the photo a place of the file is wrong. How that changes with the nearness is the same all over the range
  // of it: lenses lie much closer together than what they look at.
  std::vector<Residual> residuals;
  std::vector<double> estimates;
  for (const CameraMatch& match : matches) {
    const std::optional<Residual> r = residual_of(match);
    if (!r) continue;
    residuals.push_back(*r);
    const double squared = r->by_x * r->by_x + r->by_y * r->by_y;
    if (squared > 0) estimates.push_back((r->right * r->by_x + r->down * r->by_y) / squared);
  }
  if (residuals.size() < kFewestMatches) return {};
  const auto error = [&](double nearness) {
    std::vector<double> distances;
    for (const Residual& r : residuals)
      distances.push_back(std::hypot(r.right - nearness * r.by_x, r.down - nearness * r.by_y));
    return upper_median(std::span(distances));
  };
  const double far = error(0);
  if (estimates.size() < kFewestMatches) return {0, far};
  const double nearness = std::max(0.0, upper_median(std::span(estimates)));
  constexpr double kBetter = 0.9;
  const double near = error(nearness);
  return near < kBetter * far ? NearnessFit{nearness, near} : NearnessFit{0, far};
}

}  // namespace gpvc::io
