#include "visibility/scan_finish.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>

namespace gpvc {
namespace {

constexpr std::size_t kFacesPerBlock = 2048;
/// Few enough that they mostly lie beside each other: where sub-pixel faces are few, most rectangles around
/// the others hold no sample of them.
constexpr std::size_t kFacesPerRectangle = 64;

std::size_t block_count(std::size_t items, std::size_t per_block = kFacesPerBlock) {
  return (items + per_block - 1) / per_block;
}

/// What faces first .. end - 1 may touch.
PixelBox pixels_around(const ClassifyView& view, std::size_t first, std::size_t end) {
  FaceBounds all;
  for (std::size_t f = first; f < end; ++f) {
    const FaceBounds bounds = view.bounds(FaceId{static_cast<std::uint32_t>(f)});
    if (outside(bounds, view.camera.width, view.camera.height)) continue;
    all = united(all, bounds);
  }
  return touched_pixels(all, view.frame());
}

}  // namespace

/// What a thread gathers; sums and sets, whose order does not matter.
struct ScanFinisher::Part {
  SampleCounts counts;
  std::vector<Claim> claims;
  std::vector<Span> spans;
  OwnerContest owners;
};

ScanFinisher::ScanFinisher(const VisibilityOptions& options) : options_(options) {}

void ScanFinisher::finish(const ClassifyView& view, FaceScan& scan, ViewVisibility& result) {
  const auto start = std::chrono::steady_clock::now();
  settle_open(view, scan);
  correct_owners(view, scan);
  result.statistics.claims_s +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  resolve_subpixel(view, scan);
  blocks_.run(view, result, [&](FaceId face, FaceBlock& block) {
    const FaceCode code = scan.codes[index(face)];
    if (code == FaceCode::full) return FaceClass::full;
    if (code != FaceCode::partial && code != FaceCode::no_centre) return FaceClass::hidden;
    if (code == FaceCode::no_centre && !options_.subpixel) return FaceClass::unresolved;
    FaceSampler sampler(view, options_, overlay_, block.coverage, block.counts);
    if (code == FaceCode::no_centre) return sampler.classify_subpixel(face, subpixel_visible(face));
    return sampler.classify(face);
  });
  result.statistics.processed_faces += scan.counts.processed_faces;
  result.statistics.samples += scan.counts.samples;
  result.statistics.contested_samples += scan.counts.contested_samples;
}

/// Scans the faces that shaders are not sure about, and leaves of the claims those that are right.
void ScanFinisher::settle_open(const ClassifyView& view, FaceScan& scan) {
  tbb::enumerable_thread_specific<Part> parts;
  tbb::parallel_for(std::size_t{0}, block_count(scan.codes.size()), [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kFacesPerBlock, scan.codes.size());
    Part* part = nullptr;
    for (std::size_t f = block * kFacesPerBlock; f < end; ++f) {
      if (scan.codes[f] != FaceCode::unsure) continue;
      if (part == nullptr) part = &parts.local();
      scan.codes[f] = scan_face(view, FaceId{static_cast<std::uint32_t>(f)}, *part);
    }
  });
  const QuickLimits limits = view.quick_limits();
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  tbb::parallel_for(std::size_t{0}, block_count(scan.claims.size()), [&](std::size_t block) {
    Part& part = parts.local();
    const std::size_t end = std::min((block + 1) * kFacesPerBlock, scan.claims.size());
    for (std::size_t i = block * kFacesPerBlock; i < end; ++i) {
      const Claim& claim = scan.claims[i];
      Contender contender(view, claim.face);
      if (part.owners.wins(view, limits, contender, view.ivm[claim.pixel],
                           static_cast<std::int32_t>(claim.pixel % width),
                           static_cast<std::int32_t>(claim.pixel / width)))
        part.claims.push_back(claim);
    }
  });
  scan.claims.clear();
  for (const Part& part : parts) {
    scan.claims.insert(scan.claims.end(), part.claims.begin(), part.claims.end());
    scan.counts.processed_faces += part.counts.processed_faces;
    scan.counts.samples += part.counts.samples;
    scan.counts.contested_samples += part.counts.contested_samples;
  }
}

/// What shaders/scan.comp does, with exact spans, and claims that are decided at once.
FaceCode ScanFinisher::scan_face(const ClassifyView& view, FaceId face, Part& part) const {
  const RasterFace raster = view.raster(face);
  if (raster.facing == Facing::edge_on) return FaceCode::hidden;
  const bool front = raster.facing == Facing::front;
  const SpanWalker walker(raster, pixel_bounds(raster, view.frame()));
  collect_spans(raster, walker, true, part.spans);
  const bool inside = inside_frame(view.camera, raster);
  if (part.spans.empty()) {
    const bool elsewhere = !front || misses_frame(view.camera, raster) || (!inside && covers_a_pixel(raster));
    return elsewhere ? FaceCode::hidden : FaceCode::no_centre;
  }
  const QuickLimits limits = view.quick_limits();
  const auto width = static_cast<std::size_t>(view.camera.width);
  Contender contender(view, face);
  std::size_t own = 0, foreign = 0;
  for (const Span& span : part.spans)
    for (std::int32_t x = span.x0; x < span.x1; ++x) {
      const FaceId stored = view.owner(x, span.y);
      if (stored == face) {
        ++own;
        continue;
      }
      ++foreign;
      if (!view.mask.contains(x, span.y)) continue;
      ++part.counts.contested_samples;
      if (part.owners.wins(view, limits, contender, stored, x, span.y))
        part.claims.push_back({static_cast<std::uint32_t>(static_cast<std::size_t>(span.y) * width +
                                                          static_cast<std::size_t>(x)),
                               face});
    }
  if (!front) return FaceCode::hidden;
  if (own == 0) return FaceCode::unstored;
  if (foreign > 0 || !inside) return FaceCode::partial;
  ++part.counts.processed_faces;
  part.counts.samples += own;
  return FaceCode::full;
}

/// Faces that win or lose a pixel are sampled.
void ScanFinisher::correct_owners(const ClassifyView& view, FaceScan& scan) {
  overlay_.resolve(view, scan.claims);
  const auto resample = [&](FaceId face) {
    FaceCode& code = scan.codes[index(face)];
    // The sampler counts it again.
    if (code == FaceCode::full) --scan.counts.processed_faces;
    if (code == FaceCode::full || code == FaceCode::unstored) code = FaceCode::partial;
  };
  for (const Claim& entry : overlay_.entries()) {
    resample(entry.face);
    if (view.ivm[entry.pixel] != kNoFace) resample(view.ivm[entry.pixel]);
  }
}

void ScanFinisher::resolve_subpixel(const ClassifyView& view, const FaceScan& scan) {
  subpixel_faces_.clear();
  if (!options_.subpixel) return;
  for (std::size_t f = 0; f < scan.codes.size(); ++f)
    if (scan.codes[f] == FaceCode::no_centre)
      subpixel_faces_.push_back(FaceId{static_cast<std::uint32_t>(f)});
  touched_.resize(subpixel_faces_.empty() ? 0 : block_count(scan.codes.size(), kFacesPerRectangle));
  tbb::parallel_for(std::size_t{0}, touched_.size(), [&](std::size_t block) {
    touched_[block] = pixels_around(view, block * kFacesPerRectangle,
                                    std::min((block + 1) * kFacesPerRectangle, scan.codes.size()));
  });
  subpixel_.resolve(view, subpixel_faces_, touched_, kFacesPerRectangle);
}

std::uint32_t ScanFinisher::subpixel_visible(FaceId face) const {
  const auto at = std::lower_bound(subpixel_faces_.begin(), subpixel_faces_.end(), face);
  return subpixel_.visible(static_cast<std::size_t>(at - subpixel_faces_.begin()));
}

}  // namespace gpvc
