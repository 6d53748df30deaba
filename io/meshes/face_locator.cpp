// Which faces of a mesh lie in a region.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "io/view_rules.h"

namespace gpvc::io {
namespace {

// The sides of a polygon in bands across y, so that a point is compared with those of its band alone.
class PolygonBands {
 public:
  explicit PolygonBands(const std::vector<std::array<double, 2>>& corners) : corners_(corners) {
    const auto by_y = [](const auto& a, const auto& b) { return a[1] < b[1]; };
    const auto [low, high] = std::minmax_element(corners.begin(), corners.end(), by_y);
    low_ = (*low)[1];
    high_ = (*high)[1];
    // As many as there are corners, unless long sides would be in too many of them.
    const std::size_t most = 8 * corners.size();
    for (bands_ = std::isfinite(high_ - low_) ? corners.size() : 1; bands_ > 1 && entries() > most; bands_ /= 2)
      continue;
    std::vector<std::size_t> end(bands_ + 1, 0);
    for_each_side([&](std::size_t, std::size_t band) { ++end[band + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    first_ = end;
    sides_.resize(first_.back());
    for_each_side([&](std::size_t side, std::size_t band) { sides_[end[band]++] = side; });
  }

  bool contain(double x, double y) const {
    if (!(y >= low_ && y <= high_)) return false;
    bool inside = false;
    const std::size_t band = band_of(y);
    for (std::size_t n = first_[band]; n < first_[band + 1]; ++n) {
      const auto &a = corners_[sides_[n]], &b = before(sides_[n]);
      // Half-open in y, so that a ray through a corner crosses one of its two sides.
      if ((a[1] > y) == (b[1] > y)) continue;
      if (x < a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]))) inside = !inside;
    }
    return inside;
  }

 private:
  const std::array<double, 2>& before(std::size_t corner) const {
    return corners_[corner == 0 ? corners_.size() - 1 : corner - 1];
  }
  // Rises with y, so that a side is in the band of each of its points.
  std::size_t band_of(double y) const {
    if (bands_ == 1) return 0;
    const double share = high_ > low_ ? (y - low_) / (high_ - low_) : 0;
    return std::min(static_cast<std::size_t>(share * static_cast<double>(bands_)), bands_ - 1);
  }
  std::array<std::size_t, 2> bands_of(std::size_t side) const {
    const double a = corners_[side][1], b = before(side)[1];
    return {band_of(std::min(a, b)), band_of(std::max(a, b))};
  }
  std::size_t entries() const {
    std::size_t sum = 0;
    for (std::size_t side = 0; side < corners_.size(); ++side) sum += bands_of(side)[1] - bands_of(side)[0] + 1;
    return sum;
  }
  void for_each_side(const auto& visit) const {
    for (std::size_t side = 0; side < corners_.size(); ++side)
      for (std::size_t band = bands_of(side)[0]; band <= bands_of(side)[1]; ++band) visit(side, band);
  }

  const std::vector<std::array<double, 2>>& corners_;
  double low_ = 0, high_ = 0;
  std::size_t bands_ = 1;
  std::vector<std::size_t> first_;  ///< per band, the place in sides_ at which its sides begin
  std::vector<std::size_t> sides_;  ///< by band; each is named by its second corner
};

bool contains(const BoxRegion& box, const WorldPoint& p) {
  return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y &&
         p.z <= box.high.z;
}

// The x that points of a region may have.
std::array<double, 2> x_range(const BoxRegion& box) { return {box.low.x, box.high.x}; }
std::array<double, 2> x_range(const GroundRegion& ground) {
  const auto [low, high] = std::minmax_element(ground.corners.begin(), ground.corners.end());
  return {(*low)[0], (*high)[0]};
}

}  // namespace

FaceLocator::FaceLocator(std::span<const WorldPoint> positions, std::span<const Triangle> faces)
    : middles_(faces.size()), by_x_(faces.size()) {
  tbb::parallel_for(std::size_t{0}, middles_.size(), [&](std::size_t f) {
    for (const std::uint32_t v : faces[f]) {
      const WorldPoint& p = positions[v];
      middles_[f] = {middles_[f].x + p.x / 3, middles_[f].y + p.y / 3, middles_[f].z + p.z / 3};
    }
  });
  std::iota(by_x_.begin(), by_x_.end(), 0u);
  tbb::parallel_sort(by_x_.begin(), by_x_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return middles_[a].x < middles_[b].x; });
}

std::vector<std::uint32_t> FaceLocator::faces_in(const Region& region) const {
  std::vector<std::uint32_t> faces;
  if (const auto* listed = std::get_if<FaceRegion>(&region)) {
    for (const auto& [first, last] : listed->ranges)
      for (std::size_t f = first; f <= last && f < middles_.size(); ++f) faces.push_back(static_cast<std::uint32_t>(f));
  } else if (const auto* box = std::get_if<BoxRegion>(&region)) {
    faces = faces_where(x_range(*box), [&](const WorldPoint& p) { return contains(*box, p); });
  } else {
    const auto& ground = std::get<GroundRegion>(region);
    const PolygonBands bands(ground.corners);
    faces = faces_where(x_range(ground), [&](const WorldPoint& p) {
      return p.z >= ground.low && p.z <= ground.high && bands.contain(p.x, p.y);
    });
  }
  std::ranges::sort(faces);
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

std::vector<std::uint32_t> FaceLocator::faces_where(std::array<double, 2> x,
                                                    const std::function<bool(const WorldPoint&)>& is_inside) const {
  const auto at = [&](std::uint32_t f) { return middles_[f].x; };
  const auto first = std::ranges::lower_bound(by_x_, x[0], {}, at);
  const auto last = std::ranges::upper_bound(first, by_x_.end(), x[1], {}, at);
  const std::span<const std::uint32_t> near(first, last);
  std::vector<std::uint8_t> inside(near.size(), 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, near.size(), 4096), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) inside[n] = is_inside(middles_[near[n]]) ? 1 : 0;
  });
  std::vector<std::uint32_t> faces;
  for (std::size_t n = 0; n < near.size(); ++n)
    if (inside[n] != 0) faces.push_back(near[n]);
  return faces;
}

std::vector<std::uint8_t> faces_in(const Region& region, const Mesh& mesh) {
  std::vector<std::uint8_t> inside(mesh.faces.size(), 0);
  for (const std::uint32_t f : FaceLocator(mesh).faces_in(region)) inside[f] = 1;
  return inside;
}

}  // namespace gpvc::io
