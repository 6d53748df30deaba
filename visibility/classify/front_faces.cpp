#include "visibility/classify/front_faces.h"

#include <limits>

#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

std::size_t count(const std::vector<Span>& spans) {
  std::size_t samples = 0;
  for (const Span& span : spans) samples += static_cast<std::size_t>(span.x1 - span.x0);
  return samples;
}

/// Samples of a face, those outside the frame included as far as one frame away on each side.
std::size_t samples_around(const ClassifyView& view, const RasterFace& raster) {
  const std::int32_t w = view.camera.width, h = view.camera.height;
  const SpanWalker walker(raster, pixel_bounds(raster, {-w, -h, 2 * w, 2 * h}));
  std::vector<Span> spans;
  collect_spans(raster, walker, true, spans);
  return count(spans);
}

}  // namespace

bool find_front_face(const ClassifyView& view, FaceId face, FrontFace& found) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, view.camera.width, view.camera.height)) return false;
  found.face = face;
  found.raster = view.raster(face);
  if (found.raster.facing != Facing::front) return false;
  const SpanWalker walker(found.raster, pixel_bounds(found.raster, bounds, view.frame()));
  collect_spans(found.raster, walker, true, found.spans);
  found.inside = inside_frame(view.camera, found.raster);
  return !found.spans.empty() || !misses_frame(view.camera, found.raster.vertex);
}

InverseDepth::InverseDepth(const RasterFace& raster, const Span& near) : x0_(near.x0), y0_(near.y) {
  const EdgeValues values = edge_values(raster, x0_ + 0.5, y0_ + 0.5);
  double sum = 0, determinant = 0, sum_per_x = 0, sum_per_y = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Gradient gradient = edge_gradient(raster, values, k);
    sum += values.e[k];
    determinant += values.e[k] * raster.vertex[k].z;
    sum_per_x += gradient.x;
    sum_per_y += gradient.y;
  }
  first_ = sum / determinant;
  per_x_ = sum_per_x / determinant;
  per_y_ = sum_per_y / determinant;
}

std::array<SubpixelSample, kSubpixelSamples> subpixel_samples(const ClassifyView& view, const RasterFace& raster) {
  const auto& v = raster.vertex;
  std::array<SubpixelSample, kSubpixelSamples> samples;
  for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
    // Sums of three and of six vertices.
    ProjectedVertex q{v[0].u + v[1].u + v[2].u, v[0].v + v[1].v + v[2].v, v[0].z + v[1].z + v[2].z};
    if (k < 3) q = {q.u + 3 * v[k].u, q.v + 3 * v[k].v, q.z + 3 * v[k].z};
    SubpixelSample& sample = samples[k];
    sample = {q.u / q.z, q.v / q.z, q.z / (k < 3 ? 6 : 3), false};
    sample.in_image = sample.z > 0 && sample.x >= 0 && sample.y >= 0 && sample.x <= view.camera.width &&
                      sample.y <= view.camera.height && view.mask.contains(PixelPoint{sample.x, sample.y});
  }
  return samples;
}

FaceCoverage FaceBlock::empty_entry(const ClassifyView& view) {
  FaceCoverage entry;
  entry.face = front.face;
  entry.view = view.id;
  entry.x0 = std::numeric_limits<std::int32_t>::max();
  std::int32_t x1 = 0;
  for (const Span& span : front.spans) {
    entry.x0 = std::min(entry.x0, span.x0);
    x1 = std::max(x1, span.x1);
  }
  entry.y0 = front.spans.front().y;
  entry.width = x1 - entry.x0;
  entry.height = front.spans.back().y + 1 - entry.y0;
  entry.first_word = coverage.words.size();
  const std::size_t bits = static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height);
  coverage.words.resize(entry.first_word + (bits + 63) / 64);
  return entry;
}

FaceClass FaceBlock::finish(const ClassifyView& view, FaceCoverage entry) {
  const std::size_t samples = count(front.spans);
  if (entry.visible == 0 || (front.inside && entry.visible == samples)) {
    coverage.words.resize(entry.first_word);
    return entry.visible == 0 ? FaceClass::hidden : FaceClass::full;
  }
  const std::size_t all = front.inside ? samples : samples_around(view, front.raster);
  entry.visible_share = static_cast<float>(static_cast<double>(entry.visible) / static_cast<double>(all));
  coverage.entries.push_back(entry);
  return FaceClass::partial;
}

FaceClass FaceBlock::cover_subpixel(const ClassifyView& view, std::uint32_t visible) {
  if (visible == 0) return FaceClass::hidden;
  if (visible == kSubpixelSamples && front.inside) return FaceClass::full;
  FaceCoverage entry;
  entry.face = front.face;
  entry.view = view.id;
  entry.visible = visible;
  entry.visible_share = static_cast<float>(visible) / kSubpixelSamples;
  entry.first_word = coverage.words.size();
  coverage.entries.push_back(entry);
  return FaceClass::partial;
}

}  // namespace gpvc::visibility
