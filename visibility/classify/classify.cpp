#include "visibility/classify/classify.h"

#include <tbb/blocked_range.h>

#include <algorithm>
#include <atomic>

#include "io/clock.h"
#include "visibility/classify/face_sampler.h"
#include "visibility/raster/tile_lists.h"

namespace gpvc::visibility {
namespace {

constexpr int kOwnerTileShift = 6;

/// The pixels that faces first .. end - 1 may touch.
PixelBox pixels_around(const PreparedView& view, std::size_t first, std::size_t end) {
  FaceBounds all;
  for (std::size_t f = first; f < end; ++f) {
    const FaceBounds bounds = view.bounds(FaceId{static_cast<std::uint32_t>(f)});
    if (outside(bounds, view.camera.width, view.camera.height)) continue;
    all = united(all, bounds);
  }
  return touched_pixels(all, view.frame());
}

bool contains(const std::vector<FaceCode>& codes, FaceCode code) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

}  // namespace

void CpuClassifier::classify(const PreparedView& view, FaceScan& scan, ViewVisibility& result) {
  if (options_.correction == CoverageCorrection::exact) {
    const auto start = Clock::now();
    decide_unsure_exactly(view, exact_, scan);
    result.statistics.claims_s += seconds_since(start);
  } else if (contains(scan.codes, FaceCode::unsure)) {
    find_candidates(view);
    decide_unsure(view, scan);
  }
  correct_owners(view, scan);
  if (options_.subpixel) resolve_subpixel(view, scan);
  blocks_.run(view, result, [&](FaceId face, FaceBlock& block) {
    switch (scan.codes[index(face)]) {
      case FaceCode::full:
        return FaceClass::full;
      case FaceCode::partial:
        return FaceSampler(view, options_, overlay_, block).classify(face);
      case FaceCode::no_centre:
        if (!options_.subpixel) return FaceClass::unresolved;
        return FaceSampler(view, options_, overlay_, block).classify_subpixel(face, subpixel_.visible(face));
      default:
        return FaceClass::hidden;
    }
  });
  result.statistics += scan.counts;
  if (options_.correction == CoverageCorrection::exact && !result.ivm.faces.empty())
    store_owners(view, scan, result.ivm.faces);
}

// --- exact

/// The item buffer becomes the same whatever drew it: where the stored owner is wrong the right one is in the overlay,
/// except at pixels that no face covers.
void CpuClassifier::store_owners(const PreparedView& view, const FaceScan& scan, std::span<FaceId> ivm) {
  clear_uncovered(view, scan, ivm);
  for (const Claim& entry : overlay_.entries()) ivm[entry.pixel] = entry.face;
}

/// Clears the pixels whose stored owner does not cover their centre.
void CpuClassifier::clear_uncovered(const PreparedView& view, const FaceScan& scan, std::span<FaceId> ivm) {
  for (OwnerContest& owners : owners_) owners.start();
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  const auto clear_pixel = [&](OwnerContest& owners, std::int32_t x, std::int32_t y) {
    FaceId& stored = ivm[view.pixel_index(x, y)];
    if (stored != kNoFace && !owners.stored_owner_covers(view, stored, x, y)) stored = kNoFace;
  };
  if (scan.rough_pixels) {
    for (const std::uint32_t pixel : *scan.rough_pixels)
      clear_pixel(owners_.local(), static_cast<std::int32_t>(pixel % width), static_cast<std::int32_t>(pixel / width));
    return;
  }
  // Squares rather than rows, so that the owners of a row are those that were cached for the row above.
  const TileGrid grid(view.frame(), kOwnerTileShift);
  tbb::parallel_for(std::size_t{0}, grid.count(), [&](std::size_t tile) {
    OwnerContest& owners = owners_.local();
    const PixelBox box = grid.pixels(tile);
    for (std::int32_t y = box.y0; y < box.y1; ++y)
      for (std::int32_t end = 0, x0 = box.x0; x0 < box.x1; x0 = end) {
        const FaceId stored = view.owner(x0, y);
        end = x0 + 1;
        while (end < box.x1 && view.owner(end, y) == stored) ++end;
        if (stored == kNoFace || owners.stored_owner_covers_run(view, stored, {y, x0, end})) continue;
        for (std::int32_t x = x0; x < end; ++x) clear_pixel(owners, x, y);
      }
  });
}

// --- off and paper

void CpuClassifier::find_candidates(const PreparedView& view) {
  candidate_faces_.assign(view.mesh.faces.size(), 0);
  const auto width = static_cast<std::size_t>(view.camera.width);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, static_cast<std::size_t>(view.camera.height), 16),
      [&](const tbb::blocked_range<std::size_t>& rows) {
        FaceId last = kNoFace;
        for (const FaceId face : view.ivm.subspan(rows.begin() * width, rows.size() * width)) {
          if (face == last) continue;
          last = face;
          if (face == kNoFace) continue;
          std::atomic_ref<std::uint8_t>(candidate_faces_[index(face)]).store(1, std::memory_order_relaxed);
        }
      });
}

/// Faces with samples get the code partial, to be sampled, if they own a pixel.
void CpuClassifier::decide_unsure(const PreparedView& view, FaceScan& scan) {
  tbb::enumerable_thread_specific<FaceSamples> scratch;
  for_each_block(scan.codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    FaceSamples& samples = scratch.local();
    for (std::size_t f = first; f < end; ++f) {
      FaceCode& code = scan.codes[f];
      if (code != FaceCode::unsure) continue;
      const bool front = find_samples(view, FaceId{static_cast<std::uint32_t>(f)}, SpanSearch::rounded, samples);
      if (front && samples.spans.empty()) {
        code = FaceCode::no_centre;
      } else {
        code = front && candidate_faces_[f] != 0 ? FaceCode::partial : FaceCode::hidden;
      }
    }
  });
}

// --- all corrections

/// Faces that win or lose a pixel get the code partial, to be sampled.
void CpuClassifier::correct_owners(const PreparedView& view, FaceScan& scan) {
  overlay_.resolve(view, scan.claims);
  const auto resample = [&](FaceId face) {
    FaceCode& code = scan.codes[index(face)];
    // The sampler will count this face again.
    if (code == FaceCode::full) --scan.counts.processed_faces;
    if (code == FaceCode::full || code == FaceCode::unstored) code = FaceCode::partial;
  };
  for (const Claim& entry : overlay_.entries()) {
    resample(entry.face);
    if (view.ivm[entry.pixel] != kNoFace) resample(view.ivm[entry.pixel]);
  }
}

void CpuClassifier::resolve_subpixel(const PreparedView& view, FaceScan& scan) {
  const std::size_t faces = scan.codes.size();
  if (scan.touched.empty() && contains(scan.codes, FaceCode::no_centre)) {
    scan.touched.resize((faces + kFacesPerRectangle - 1) / kFacesPerRectangle);
    tbb::parallel_for(std::size_t{0}, scan.touched.size(), [&](std::size_t number) {
      const std::size_t first = number * kFacesPerRectangle;
      scan.touched[number] = pixels_around(view, first, std::min(first + kFacesPerRectangle, faces));
    });
  }
  subpixel_.resolve(view, scan.codes, scan.touched, kFacesPerRectangle);
}

}  // namespace gpvc::visibility
