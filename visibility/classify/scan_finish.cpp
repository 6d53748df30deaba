#include "visibility/classify/scan_finish.h"

#include <algorithm>

namespace gpvc::visibility {
namespace {

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

void ScanFinisher::finish(const ClassifyView& view, FaceScan& scan, ViewVisibility& result) {
  correct_owners(view, scan);
  resolve_subpixel(view, scan);
  result.classes.resize(scan.codes.size());
  blocks_.resize(block_count(scan.codes.size()));
  for_each_block(scan.codes.size(), [&](std::size_t number, std::size_t first, std::size_t end) {
    BlockYield& block = blocks_[number];
    block.clear();
    FaceSampler sampler(view, options_, overlay_, block.coverage, block.counts);
    for (std::size_t f = first; f < end; ++f) {
      const FaceId face{static_cast<std::uint32_t>(f)};
      FaceClass& found = result.classes[f];
      found = FaceClass::hidden;
      if (scan.codes[f] == FaceCode::full) {
        found = FaceClass::full;
      } else if (scan.codes[f] == FaceCode::partial) {
        found = sampler.classify(face);
      } else if (scan.codes[f] == FaceCode::no_centre) {
        found = options_.subpixel ? sampler.classify_subpixel(face, subpixel_.visible(face)) : FaceClass::unresolved;
      }
      block.full += found == FaceClass::full;
    }
  });
  join(blocks_, result);
  result.statistics.processed_faces += scan.counts.processed_faces;
  result.statistics.samples += scan.counts.samples;
  result.statistics.contested_samples += scan.counts.contested_samples;
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

void ScanFinisher::resolve_subpixel(const ClassifyView& view, FaceScan& scan) {
  if (!options_.subpixel) return;
  const std::size_t faces = scan.codes.size();
  if (scan.touched.empty() &&
      std::find(scan.codes.begin(), scan.codes.end(), FaceCode::no_centre) != scan.codes.end()) {
    scan.touched.resize((faces + kFacesPerRectangle - 1) / kFacesPerRectangle);
    tbb::parallel_for(std::size_t{0}, scan.touched.size(), [&](std::size_t number) {
      const std::size_t first = number * kFacesPerRectangle;
      scan.touched[number] = pixels_around(view, first, std::min(first + kFacesPerRectangle, faces));
    });
  }
  subpixel_.resolve(view, scan.codes, scan.touched, kFacesPerRectangle);
}

}  // namespace gpvc::visibility
