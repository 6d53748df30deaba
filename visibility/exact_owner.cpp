#include "visibility/exact_owner.h"

#include <tbb/parallel_sort.h>

#include <algorithm>

namespace gpvc {

void OwnerContest::start() {
  for (Owner& owner : owners_) owner.face = kNoFace;
}

bool OwnerContest::wins(const ClassifyView& view, const QuickLimits& limits, Contender& contender,
                        FaceId stored, std::int32_t x, std::int32_t y) {
  if (stored == kNoFace) return true;
  Owner& owner = owners_[index(stored) % owners_.size()];
  if (owner.face != stored) {
    owner.face = stored;
    owner.quick = view.quick(limits, stored, view.bounds(stored));
    owner.farthest = view.depths(stored).farthest;
    owner.prepared = false;
  }
  const double px = x + 0.5, py = y + 0.5;
  // Most owners are right, and a layer nearer.
  if (owner.farthest < contender.nearest() && owner.quick.contains(px, py)) return false;
  if (!owner.prepared) owner.raster = view.raster(stored);
  owner.prepared = true;
  if (owner.raster.facing == Facing::edge_on) return true;
  const FacePoint there = face_point(owner.raster, px, py);
  if (!covers_exactly(there)) return true;
  const int order = compare_depth_exactly(face_point(contender.raster(), px, py), there);
  return order < 0 || (order == 0 && contender.face() < stored);
}

void OwnerOverlay::resolve(const ClassifyView& view, std::vector<Claim>& claims) {
  for (const Claim& entry : entries_) corrected_[entry.pixel / 64] = 0;
  entries_.clear();
  corrected_.resize((view.ivm.size() + 63) / 64, 0);
  // Ascending faces within a pixel: a later claimant must be strictly nearer, so ties keep the lower index.
  tbb::parallel_sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.face < b.face;
  });
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  for (std::size_t first = 0; first < claims.size();) {
    const std::uint32_t pixel = claims[first].pixel;
    std::size_t next = first + 1;
    FaceId nearest = claims[first].face;
    if (next < claims.size() && claims[next].pixel == pixel) {
      const double px = pixel % width + 0.5, py = pixel / width + 0.5;
      RasterFace best = view.raster(nearest);
      for (; next < claims.size() && claims[next].pixel == pixel; ++next) {
        const RasterFace other = view.raster(claims[next].face);
        if (compare_depth_exactly(face_point(other, px, py), face_point(best, px, py)) >= 0) continue;
        best = other;
        nearest = claims[next].face;
      }
    }
    entries_.push_back({pixel, nearest});
    corrected_[pixel / 64] |= std::uint64_t{1} << (pixel % 64);
    first = next;
  }
}

FaceId OwnerOverlay::owner(std::size_t pixel) const {
  return std::lower_bound(entries_.begin(), entries_.end(), pixel,
                          [](const Claim& entry, std::size_t wanted) { return entry.pixel < wanted; })
      ->face;
}

}  // namespace gpvc
