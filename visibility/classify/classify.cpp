#include "visibility/classify/classify.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>

#include "io/clock.h"
#include "visibility/classify/scan_finish.h"

namespace gpvc::visibility {
namespace {

/// True when every sample that the sampling mode looks at is stored as the face's; counts the samples looked at.
bool stores_everywhere(const PreparedView& view, FaceId face, const SpanWalker& walker, std::span<const Span> spans,
                       Sampling sampling, std::size_t& samples) {
  for (const Span& span : spans) {
    // VES leaves out the inner pixels from x0 to x1.
    std::int32_t x0 = span.x1, x1 = span.x1;
    const std::optional<Span> inner = sampling == Sampling::ves ? walker.inner_run(span.y) : std::nullopt;
    if (inner) {
      x0 = std::clamp(inner->x0, span.x0, span.x1);
      x1 = std::clamp(inner->x1, x0, span.x1);
    }
    for (std::int32_t x = span.x0; x < x0; ++x)
      if (view.owner(x, span.y) != face) return false;
    for (std::int32_t x = x1; x < span.x1; ++x)
      if (view.owner(x, span.y) != face) return false;
    samples += static_cast<std::size_t>((x0 - span.x0) + (span.x1 - x1));
  }
  return true;
}

}  // namespace

CpuClassifier::CpuClassifier(const ClassifyOptions& options)
    : options_(options),
      scan_(std::make_unique<FaceScan>()),
      exact_(std::make_unique<ExactScan>()),
      finisher_(std::make_unique<ScanFinisher>(options)) {}
CpuClassifier::~CpuClassifier() = default;

void CpuClassifier::classify(const PreparedView& view, ViewVisibility& result) {
  if (options_.correction == CoverageCorrection::exact) {
    exact_->scan(view, *scan_);
  } else {
    find_candidates(view);
    scan_faces(view);
  }
  finisher_->finish(view, *scan_, result);
}

void CpuClassifier::finish_exact_scan(const PreparedView& view, FaceScan& scan, ViewVisibility& result) {
  const auto start = Clock::now();
  exact_->settle(view, scan);
  result.statistics.claims_s += seconds_since(start);
  finisher_->finish(view, scan, result);
}

void CpuClassifier::finish_codes(const PreparedView& view, std::span<const FaceCode> codes, ViewVisibility& result) {
  scan_->start(codes.size());
  tbb::enumerable_thread_specific<std::vector<Span>> spans_of_unsure;
  for_each_block(codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t f = first; f < end; ++f) {
      scan_->codes[f] = codes[f];
      if (codes[f] != FaceCode::unsure) continue;
      const RasterFace raster = view.raster(FaceId{static_cast<std::uint32_t>(f)});
      const SpanWalker walker(raster, pixel_bounds(raster, view.frame()));
      std::vector<Span>& spans = spans_of_unsure.local();
      collect_spans(raster, walker, false, spans);
      scan_->codes[f] = spans.empty() ? FaceCode::no_centre : FaceCode::partial;  // a partial face is sampled below
    }
  });
  finisher_->finish(view, *scan_, result);
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

/// Faces that own all their samples are full; the others that own a pixel get the code partial, to be sampled.
void CpuClassifier::scan_faces(const PreparedView& view) {
  struct Part {
    std::vector<Span> spans;
    SampleCounts counts;
  };
  tbb::enumerable_thread_specific<Part> parts;
  scan_->start(view.mesh.faces.size());
  for_each_block(view.mesh.faces.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    Part& part = parts.local();
    for (std::size_t f = first; f < end; ++f) {
      std::size_t samples = 0;
      FaceCode& code = scan_->codes[f];
      code = scan_face(view, FaceId{static_cast<std::uint32_t>(f)}, part.spans, samples);
      if (code != FaceCode::full) continue;
      ++part.counts.processed_faces;
      part.counts.samples += samples;
    }
  });
  for (const Part& part : parts) scan_->counts += part.counts;
}

FaceCode CpuClassifier::scan_face(const PreparedView& view, FaceId face, std::vector<Span>& spans,
                                  std::size_t& samples) const {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, view.camera.width, view.camera.height)) return FaceCode::hidden;
  const RasterFace raster = view.raster(face);
  if (raster.facing != Facing::front) return FaceCode::hidden;
  const SpanWalker walker(raster, pixel_bounds(raster, bounds, view.frame()));
  collect_spans(raster, walker, false, spans);
  if (spans.empty()) return misses_frame(view.camera, raster.vertex) ? FaceCode::hidden : FaceCode::no_centre;
  if (candidate_faces_[index(face)] == 0) return FaceCode::hidden;
  return stores_everywhere(view, face, walker, spans, options_.sampling, samples) && inside_frame(view.camera, raster)
             ? FaceCode::full
             : FaceCode::partial;
}

}  // namespace gpvc::visibility
