#include "labeling/costs/photo_lookup.h"

#include <limits>

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

PhotoLookup::Row PhotoLookup::row(int y) const {
  Row row{*this, y, {}};
  if (nodes_.empty()) return row;
  const double fraction = (y % kStep) * (1.0 / kStep);
  const PhotoPoint* above = nodes_.data() + static_cast<std::size_t>(y / kStep) * static_cast<std::size_t>(columns_);
  const PhotoPoint* below = above + columns_;
  row.nodes.resize(static_cast<std::size_t>(columns_));
  for (std::size_t i = 0; i < row.nodes.size(); ++i)
    row.nodes[i] = {above[i].x + fraction * (below[i].x - above[i].x),
                    above[i].y + fraction * (below[i].y - above[i].y)};
  return row;
}

}  // namespace gpvc::labeling
