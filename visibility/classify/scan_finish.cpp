#include "visibility/classify/scan_finish.h"

#include <algorithm>

#include "visibility/classify/face_sampler.h"

namespace gpvc::visibility {
namespace {

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

}  // namespace

void ScanFinisher::finish(const PreparedView& view, FaceScan& scan, ViewVisibility& result) {
  correct_owners(view, scan);
  resolve_subpixel(view, scan);
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
  result.statistics.processed_faces += scan.counts.processed_faces;
  result.statistics.samples += scan.counts.samples;
  result.statistics.contested_samples += scan.counts.contested_samples;
}

/// Faces that win or lose a pixel get the code partial, to be sampled.
void ScanFinisher::correct_owners(const PreparedView& view, FaceScan& scan) {
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

void ScanFinisher::resolve_subpixel(const PreparedView& view, FaceScan& scan) {
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
