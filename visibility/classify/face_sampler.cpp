#include "visibility/classify/face_sampler.h"

#include <algorithm>

#include "visibility/classify/lpcc.h"

namespace gpvc::visibility {

FaceClass FaceSampler::classify(FaceId face) {
  ++block_.counts.processed_faces;
  const SpanSearch exact_search = options_.sampling == Sampling::ves ? SpanSearch::exact : SpanSearch::quick;
  // A driver that does not round as `precise` demands may send a face without samples.
  if (!find_samples(view_, face, exact() ? exact_search : SpanSearch::rounded, front_) || front_.spans.empty())
    return FaceClass::hidden;
  restored_ = 0;
  const FaceClass found = front_.inside && sees_all() ? FaceClass::full : cover();
  if (found != FaceClass::hidden) block_.counts.corrected_samples += restored_;
  return found;
}

bool FaceSampler::sees(std::int32_t x, std::int32_t y) {
  const FaceId stored = view_.owner(x, y);
  if (exact()) {
    const std::size_t pixel = view_.pixel_index(x, y);
    if (!overlay_.contains(pixel)) return stored == front_.face;
    if (overlay_.owner(pixel) != front_.face) return false;
    ++restored_;
    return true;
  }
  if (stored == front_.face) return true;
  if (options_.correction == CoverageCorrection::off) return false;
  if (!view_.mask.contains(x, y) || !lpcc_restores(view_, front_.face, front_.raster, x, y)) return false;
  ++restored_;
  return true;
}

bool FaceSampler::sees_all() {
  const auto sees_pixel = [this](std::int32_t x, std::int32_t y) { return sees(x, y); };
  SpanTest test(front_.spans, sees_pixel, block_.counts.samples);
  switch (options_.sampling) {
    case Sampling::dense:
      return test.sees_all_dense();
    case Sampling::ves:
      return sees_all_ves(test);
    case Sampling::hivers:
      break;
  }
  return test.sees_all_hivers();
}

/// VES: only the samples in pixels that an edge crosses.
template <class Test>
bool FaceSampler::sees_all_ves(Test& test) const {
  const RasterFace& raster = front_.raster;
  const SpanWalker walker(raster, pixel_bounds(raster, view_.bounds(front_.face), view_.frame()));
  for (const Span& span : front_.spans) {
    if (const std::optional<Span> inner = walker.inner_run(span.y)) {
      const std::int32_t x0 = std::clamp(inner->x0, span.x0, span.x1), x1 = std::clamp(inner->x1, x0, span.x1);
      if (!test.sees_run(span.y, span.x0, x0) || !test.sees_run(span.y, x1, span.x1)) return false;
      continue;
    }
    for (std::int32_t x = span.x0; x < span.x1; ++x)
      if (crossed_by_edge(raster, edge_values(raster, x + 0.5, span.y + 0.5)) && !test.sees_run(span.y, x, x + 1))
        return false;
  }
  return true;
}

/// The face is hidden or partial: looks at every sample in the frame.
FaceClass FaceSampler::cover() {
  restored_ = 0;
  CoverageWriter writer(view_, front_, block_.coverage);
  for (const Span& span : front_.spans) {
    const FaceId* stored = view_.row(span.y);
    const bool as_stored =
        exact() && !overlay_.touches(view_.pixel_index(span.x0, span.y), view_.pixel_index(span.x1, span.y));
    if (as_stored) {
      writer.add(span, [&](std::int32_t x) { return stored[x] == front_.face; });
    } else {
      writer.add(span, [&](std::int32_t x) { return sees(x, span.y); });
    }
  }
  return writer.finish();
}

FaceClass FaceSampler::classify_subpixel(FaceId face, std::uint32_t visible) {
  ++block_.counts.processed_faces;
  block_.counts.samples += kSubpixelSamples;
  const bool inside = visible == kSubpixelSamples &&
                      (view_.limits.inside_frame(view_.bounds(face)) || inside_frame(view_.camera, view_.raster(face)));
  return block_.cover_subpixel(view_, face, inside, visible);
}

}  // namespace gpvc::visibility
