#include "visibility/classify/exact_owner.h"

#include <tbb/parallel_sort.h>

#include <algorithm>

namespace gpvc::visibility {

void OwnerContest::start() {
  for (Owner& owner : owners_) owner.face = kNoFace;
}

OwnerContest::Owner& OwnerContest::owner_of(const PreparedView& view, FaceId stored) {
  Owner& owner = owners_[index(stored) % owners_.size()];
  if (owner.face == stored) return owner;
  owner.face = stored;
  owner.quick = view.quick(stored, view.bounds(stored));
  owner.farthest = view.depths(stored).farthest;
  owner.measured = owner.prepared = false;
  return owner;
}

bool OwnerContest::stored_owner_keeps_run(const PreparedView& view, Contender& contender, FaceId stored,
                                          const Span& run) {
  Owner& owner = owner_of(view, stored);
  const double first = run.x0 + 0.5, last = run.x1 - 0.5, y = run.y + 0.5;
  if (!owner.quick.contains(first, y) || (last > first && !owner.quick.contains(last, y))) return false;
  // Most stored owners belong to a nearer layer.
  if (owner.farthest < contender.nearest()) return true;
  if (!owner.measured) owner.depth = view.inverse_depth(owner.quick, stored);
  owner.measured = true;
  const InverseDepth& other = contender.inverse_depth();
  return owner.depth.before(other, first, y) && owner.depth.before(other, last, y);
}

bool OwnerContest::beats_stored_at(const PreparedView& view, Contender& contender, FaceId stored, std::int32_t x,
                                   std::int32_t y) {
  if (stored == kNoFace) return true;
  Owner& owner = owner_of(view, stored);
  const double px = x + 0.5, py = y + 0.5;
  if (owner.farthest < contender.nearest() && owner.quick.contains(px, py)) return false;
  if (!owner.prepared) owner.raster = view.raster(stored);
  owner.prepared = true;
  if (owner.raster.facing == Facing::edge_on) return true;
  const FacePoint there = face_point(owner.raster, px, py);
  if (!covers_exactly(there)) return true;
  const int order = compare_depth_exactly(face_point(contender.raster(), px, py), there);
  return order < 0 || (order == 0 && contender.face() < stored);
}

void OwnerOverlay::resolve(const PreparedView& view, std::vector<Claim>& claims) {
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

bool OwnerOverlay::touches(std::size_t first, std::size_t end) const {
  if (first >= end) return false;
  const std::size_t first_word = first / 64, last_word = (end - 1) / 64;
  const std::uint64_t from = ~std::uint64_t{0} << (first % 64), to = ~std::uint64_t{0} >> (63 - (end - 1) % 64);
  if (first_word == last_word) return (corrected_[first_word] & from & to) != 0;
  if ((corrected_[first_word] & from) != 0 || (corrected_[last_word] & to) != 0) return true;
  for (std::size_t word = first_word + 1; word < last_word; ++word)
    if (corrected_[word] != 0) return true;
  return false;
}

FaceId OwnerOverlay::owner(std::size_t pixel) const {
  return std::lower_bound(entries_.begin(), entries_.end(), pixel,
                          [](const Claim& entry, std::size_t wanted) { return entry.pixel < wanted; })
      ->face;
}

}  // namespace gpvc::visibility
