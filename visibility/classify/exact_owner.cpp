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

const RasterFace& OwnerContest::raster_of(const PreparedView& view, Owner& owner) {
  if (!owner.prepared) owner.raster = view.raster(owner.face);
  owner.prepared = true;
  return owner.raster;
}

bool OwnerContest::covers_ends(const Owner& owner, const Span& run) {
  const double first = run.x0 + 0.5, last = run.x1 - 0.5, y = run.y + 0.5;
  return owner.quick.contains(first, y) && (last == first || owner.quick.contains(last, y));
}

bool OwnerContest::stored_owner_covers_run(const PreparedView& view, FaceId stored, const Span& run) {
  return covers_ends(owner_of(view, stored), run);
}

bool OwnerContest::stored_owner_covers(const PreparedView& view, FaceId stored, std::int32_t x, std::int32_t y) {
  const RasterFace& raster = raster_of(view, owner_of(view, stored));
  return raster.facing != Facing::edge_on && covers_exactly(face_point(raster, x + 0.5, y + 0.5));
}

bool OwnerContest::stored_owner_keeps_run(const PreparedView& view, Contender& contender, FaceId stored,
                                          const Span& run) {
  Owner& owner = owner_of(view, stored);
  if (!covers_ends(owner, run)) return false;
  // Most stored owners belong to a nearer layer.
  if (owner.farthest < contender.nearest()) return true;
  if (!owner.measured) owner.depth = view.inverse_depth(owner.quick, stored);
  owner.measured = true;
  const InverseDepth& other = contender.inverse_depth();
  const double first = run.x0 + 0.5, last = run.x1 - 0.5, y = run.y + 0.5;
  return owner.depth.before(other, first, y) && owner.depth.before(other, last, y);
}

std::optional<bool> OwnerContest::beats_stored_in(const PreparedView& view, Contender& contender, FaceId stored,
                                                  const Span& run) {
  if (stored == kNoFace) return true;
  Owner& owner = owner_of(view, stored);
  if (owner.farthest < contender.nearest() && covers_ends(owner, run)) return false;
  const RasterFace& raster = raster_of(view, owner);
  if (raster.facing == Facing::edge_on) return true;
  // The owner is convex and the difference of both 1 / z is linear: what both ends agree on holds between them.
  const auto beats_at = [&](std::int32_t x) -> std::optional<int> {
    const double px = x + 0.5, py = run.y + 0.5;
    const FacePoint there = face_point(raster, px, py);
    if (!covers_exactly(there)) return std::nullopt;
    return compare_depth_exactly(face_point(contender.raster(), px, py), there);
  };
  const std::optional<int> first = beats_at(run.x0);
  const std::optional<int> last = run.x1 - run.x0 > 1 && first ? beats_at(run.x1 - 1) : first;
  if (run.x1 - run.x0 == 1 && !first) return true;
  if (!first || !last || (*first < 0) != (*last < 0) || (*first > 0) != (*last > 0)) return std::nullopt;
  return *first < 0 ||
         (*first == 0 && precedes_at_equal_depth(contender.raster().facing, contender.face(), raster.facing, stored));
}

void OwnerOverlay::resolve(const PreparedView& view, std::vector<Claim>& claims) {
  for (const Claim& entry : entries_) corrected_[entry.pixel / 64] = 0;
  entries_.clear();
  corrected_.resize((view.ivm.size() + 63) / 64, 0);
  // Ascending faces within a pixel, so that runs of the same claimants are found.
  tbb::parallel_sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.face < b.face;
  });
  claims.erase(std::unique(claims.begin(), claims.end(),
                           [](const Claim& a, const Claim& b) { return a.pixel == b.pixel && a.face == b.face; }),
               claims.end());
  const auto end_of_pixel = [&](std::size_t first) {
    std::size_t end = first;
    while (end < claims.size() && claims[end].pixel == claims[first].pixel) ++end;
    return end;
  };
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  std::vector<FaceId> claimants;
  for (std::size_t first = 0; first < claims.size();) {
    const std::uint32_t pixel = claims[first].pixel, last_of_row = pixel - pixel % width + width - 1;
    claimants.clear();
    std::size_t next = end_of_pixel(first);
    for (std::size_t i = first; i < next; ++i) claimants.push_back(claims[i].face);
    // The pixels right of it that the same faces claim.
    std::uint32_t last = pixel;
    while (last < last_of_row && next < claims.size() && claims[next].pixel == last + 1) {
      const std::size_t end = end_of_pixel(next);
      if (!std::equal(claimants.begin(), claimants.end(), claims.begin() + static_cast<std::ptrdiff_t>(next),
                      claims.begin() + static_cast<std::ptrdiff_t>(end),
                      [](FaceId face, const Claim& claim) { return face == claim.face; }))
        break;
      next = end;
      ++last;
    }
    const auto x0 = static_cast<std::int32_t>(pixel % width);
    add_nearest(view, claimants,
                {static_cast<std::int32_t>(pixel / width), x0, x0 + static_cast<std::int32_t>(last - pixel) + 1});
    first = next;
  }
}

/// \pre the claimants, in ascending order, cover the run. The differences of their 1 / z are linear: the nearest at one
/// end is the nearest in the whole run if it is at the other end, too. Else a nearer one is found in halves.
void OwnerOverlay::add_nearest(const PreparedView& view, std::span<const FaceId> claimants, const Span& run) {
  const double first_x = run.x0 + 0.5, last_x = run.x1 - 0.5, y = run.y + 0.5;
  FaceId nearest = claimants.front();
  RasterFace best = view.raster(nearest);
  bool everywhere = true;  // at the last pixel, too
  for (const FaceId claimant : claimants.subspan(1)) {
    const RasterFace other = view.raster(claimant);
    const auto nearer_at = [&](double x) {
      const int order = compare_depth_exactly(face_point(other, x, y), face_point(best, x, y));
      return order < 0 || (order == 0 && precedes_at_equal_depth(other.facing, claimant, best.facing, nearest));
    };
    const bool nearer = nearer_at(first_x);
    if (first_x < last_x && nearer_at(last_x) != nearer) {
      everywhere = false;
      break;
    }
    if (!nearer) continue;
    best = other;
    nearest = claimant;
  }
  if (!everywhere) {
    const std::int32_t middle = run.x0 + (run.x1 - run.x0) / 2;
    add_nearest(view, claimants, {run.y, run.x0, middle});
    add_nearest(view, claimants, {run.y, middle, run.x1});
    return;
  }
  for (std::int32_t x = run.x0; x < run.x1; ++x) {
    const auto pixel = static_cast<std::uint32_t>(view.pixel_index(x, run.y));
    entries_.push_back({pixel, nearest});
    corrected_[pixel / 64] |= std::uint64_t{1} << (pixel % 64);
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
