#include "visibility/classify/front_faces.h"

#include <limits>

#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

/// Samples of a face, counting those beyond the frame as far as one frame away on each side: what
/// FaceCoverage::visible_share is a share of, so that a face of which the frame shows a corner counts as little seen.
std::size_t samples_around(const Camera& camera, const FaceSamples& front) {
  const std::int32_t w = camera.width, h = camera.height;
  const SpanWalker walker(front.raster, pixel_bounds(front.raster, {-w, -h, 2 * w, 2 * h}));
  std::vector<Span> spans;
  collect_spans(front.raster, walker, front.search != SpanSearch::rounded, spans);
  std::size_t samples = 0;
  for (const Span& span : spans) samples += static_cast<std::size_t>(span.x1 - span.x0);
  return samples;
}

}  // namespace

bool inside_frame(const Camera& camera, const RasterFace& face) {
  return std::all_of(face.vertex.begin(), face.vertex.end(), [&](const ProjectedVertex& v) {
    return v.z > 0 && v.u >= 0 && v.v >= 0 && v.u <= camera.width * v.z && v.v <= camera.height * v.z;
  });
}

void collect_spans(const RasterFace& face, const SpanWalker& walker, bool exact, std::vector<Span>& spans) {
  spans.clear();
  walker.walk(
      [&](std::int32_t x, std::int32_t y) {
        return exact ? covers_exactly(face_point(face, x + 0.5, y + 0.5))
                     : covers(face, edge_values(face, x + 0.5, y + 0.5));
      },
      [&](std::int32_t y, std::int32_t x0, std::int32_t x1) {
        spans.push_back({y, x0, x1});
      });
}

bool find_samples(const PreparedView& view, FaceId face, SpanSearch search, FaceSamples& found) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, view.camera.width, view.camera.height)) return false;
  found.face = face;
  found.search = search;
  if (search == SpanSearch::quick && view.limits.inside_frame(bounds)) {
    const QuickFace quick = view.quick(face, bounds);
    found.facing = quick.facing();
    found.inside = true;
    if (quick.spans(pixel_centres(bounds, view.frame()), found.spans)) return true;
  }
  found.raster = view.raster(face);
  found.facing = found.raster.facing;
  if (found.facing == Facing::edge_on || (found.facing == Facing::back && search != SpanSearch::quick)) return false;
  const SpanWalker walker(found.raster, pixel_bounds(found.raster, bounds, view.frame()));
  collect_spans(found.raster, walker, search != SpanSearch::rounded, found.spans);
  found.inside = inside_frame(view.camera, found.raster);
  return !found.spans.empty() || !misses_frame(view.camera, found.raster.vertex);
}

CoverageWriter::CoverageWriter(const PreparedView& view, const FaceSamples& front, CoverageTable& table)
    : view_(view), front_(front), table_(table) {
  entry_.face = front.face;
  entry_.view = view.id;
  entry_.x0 = std::numeric_limits<std::int32_t>::max();
  std::int32_t x1 = 0;
  for (const Span& span : front.spans) {
    entry_.x0 = std::min(entry_.x0, span.x0);
    x1 = std::max(x1, span.x1);
  }
  entry_.y0 = front.spans.front().y;
  entry_.width = x1 - entry_.x0;
  entry_.height = front.spans.back().y + 1 - entry_.y0;
  entry_.first_word = table.words.size();
  const std::size_t bits = static_cast<std::size_t>(entry_.width) * static_cast<std::size_t>(entry_.height);
  table.words.resize(entry_.first_word + (bits + 63) / 64);
}

FaceClass CoverageWriter::finish() {
  if (entry_.visible == 0 || (front_.inside && entry_.visible == samples_)) {
    table_.words.resize(entry_.first_word);
    return entry_.visible == 0 ? FaceClass::hidden : FaceClass::full;
  }
  const std::size_t all = front_.inside ? samples_ : samples_around(view_.camera, front_);
  entry_.visible_share = static_cast<float>(static_cast<double>(entry_.visible) / static_cast<double>(all));
  table_.entries.push_back(entry_);
  return FaceClass::partial;
}

void add_share(const PreparedView& view, FaceId face, std::uint32_t visible, std::uint32_t samples,
               CoverageTable& table) {
  FaceCoverage entry;
  entry.face = face;
  entry.view = view.id;
  entry.visible = visible;
  entry.visible_share = static_cast<float>(visible) / static_cast<float>(samples);
  entry.first_word = table.words.size();
  table.entries.push_back(entry);
}

void FaceBlock::clear() {
  coverage.entries.clear();
  coverage.words.clear();
  counts = {};
}

FaceClass FaceBlock::cover_subpixel(const PreparedView& view, FaceId face, bool inside, std::uint32_t visible) {
  if (visible == 0) return FaceClass::hidden;
  if (visible == kSubpixelSamples && inside) return FaceClass::full;
  add_share(view, face, visible, kSubpixelSamples, coverage);
  return FaceClass::partial;
}

void FaceBlock::append_to(ViewVisibility& result) const {
  const std::size_t words = result.coverage.words.size();
  for (FaceCoverage entry : coverage.entries) {
    entry.first_word += words;
    result.coverage.entries.push_back(entry);
  }
  result.coverage.words.insert(result.coverage.words.end(), coverage.words.begin(), coverage.words.end());
  result.statistics += counts;
  result.statistics.partial += coverage.entries.size();
}

}  // namespace gpvc::visibility
