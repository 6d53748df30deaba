#include "visibility/classify/face_sampler.h"

#include <algorithm>
#include <limits>

#include "visibility/classify/lpcc.h"
#include "visibility/classify/subpixel.h"
#include "visibility/raster/exact.h"

namespace gpvc::visibility {

namespace {

bool covers_plainly(const RasterFace& face, std::int32_t x, std::int32_t y) {
  return covers(face, edge_values(face, x + 0.5, y + 0.5));
}

}  // namespace

void BlockYield::clear() {
  coverage.entries.clear();
  coverage.words.clear();
  counts = {};
  full = 0;
}

void append(const BlockYield& block, ViewVisibility& result) {
  CoverageTable& coverage = result.coverage;
  const std::size_t words = coverage.words.size();
  for (FaceCoverage entry : block.coverage.entries) {
    entry.first_word += words;
    coverage.entries.push_back(entry);
  }
  coverage.words.insert(coverage.words.end(), block.coverage.words.begin(), block.coverage.words.end());
  VisibilityStatistics& statistics = result.statistics;
  statistics.processed_faces += block.counts.processed_faces;
  statistics.samples += block.counts.samples;
  statistics.corrected_samples += block.counts.corrected_samples;
  statistics.contested_samples += block.counts.contested_samples;
  statistics.full += block.full;
  statistics.partial += block.coverage.entries.size();
}

bool inside_frame(const Camera& camera, const RasterFace& face) {
  return std::all_of(face.vertex.begin(), face.vertex.end(), [&](const ProjectedVertex& v) {
    return v.z > 0 && v.u >= 0 && v.v >= 0 && v.u <= camera.width * v.z && v.v <= camera.height * v.z;
  });
}

void collect_spans(const RasterFace& face, const SpanWalker& walker, bool exact, std::vector<Span>& spans) {
  spans.clear();
  walker.walk(
      [&](std::int32_t x, std::int32_t y) {
        return exact ? covers_exactly(face_point(face, x + 0.5, y + 0.5)) : covers_plainly(face, x, y);
      },
      [&](std::int32_t y, std::int32_t x0, std::int32_t x1) {
        spans.push_back({y, x0, x1});
      });
}

FaceClass FaceSampler::classify(FaceId face) {
  face_ = face;
  ++counts_.processed_faces;
  restored_ = 0;
  bool full = false;
  quick_ = find_spans_quickly();
  if (quick_) {
    full = options_.sampling == Sampling::dense ? sees_all_dense() : sees_all_hivers();
  } else {
    raster_ = view_.raster(face);
    const SpanWalker walker(raster_, pixel_bounds(raster_, view_.frame()));
    collect_spans(raster_, walker, exact(), spans_);
    if (spans_.empty()) return FaceClass::hidden;  // where a driver rounds as it should not
    if (inside_frame(view_.camera, raster_))
      full = options_.sampling == Sampling::dense ? sees_all_dense()
             : options_.sampling == Sampling::ves ? sees_all_ves(walker)
                                                  : sees_all_hivers();
  }
  if (!full) return cover();
  counts_.corrected_samples += restored_;
  return FaceClass::full;
}

/// Where samples are decided exactly, the certain spans are the same. VES asks for the edges as well.
bool FaceSampler::find_spans_quickly() {
  if (!exact() || options_.sampling == Sampling::ves) return false;
  const FaceBounds bounds = view_.bounds(face_);
  return limits_.inside(bounds) &&
         view_.quick(limits_, face_, bounds).spans(pixel_centres(bounds, view_.frame()), spans_);
}

bool FaceSampler::sees(std::int32_t x, std::int32_t y) {
  const FaceId stored = view_.owner(x, y);
  if (exact()) {
    const std::size_t pixel = pixel_number(x, y);
    if (!overlay_.contains(pixel)) return stored == face_;
    if (overlay_.owner(pixel) != face_) return false;
    ++restored_;
    return true;
  }
  if (stored == face_) return true;
  if (options_.correction == CoverageCorrection::off) return false;
  if (!view_.mask.contains(x, y) || !lpcc_restores(view_, face_, raster_, x, y)) return false;
  ++restored_;
  return true;
}

bool FaceSampler::sees_run(std::int32_t y, std::int32_t x0, std::int32_t x1) {
  for (std::int32_t x = x0; x < x1; ++x) {
    ++counts_.samples;
    if (!sees(x, y)) return false;
  }
  return true;
}

bool FaceSampler::sees_all_dense() {
  return std::all_of(spans_.begin(), spans_.end(),
                     [&](const Span& span) { return sees_run(span.y, span.x0, span.x1); });
}

/// VVC and EVC on the ends of the rows and the whole of the first and the last row, then RVC on what lies between.
/// Deviation from algorithm 2: a region is not cut into three at its barycentre but into blocks of rows, halved until a
/// row is left, so that every sample is read once and none needs to be marked; the conditions, and the class, are those
/// of the paper.
bool FaceSampler::sees_all_hivers() {
  const auto& spans = spans_;
  const Span &top = spans.front(), &bottom = spans.back();
  if (!sees_run(top.y, top.x0, top.x1)) return false;
  if (spans.size() == 1) return true;
  if (!sees_run(bottom.y, bottom.x0, bottom.x1)) return false;
  for (std::size_t i = 1; i + 1 < spans.size(); ++i) {
    const Span& span = spans[i];
    if (!sees_run(span.y, span.x0, span.x0 + 1)) return false;
    if (span.x1 - span.x0 > 1 && !sees_run(span.y, span.x1 - 1, span.x1)) return false;
  }
  return sees_rows_between(1, spans.size() - 1);
}

bool FaceSampler::sees_rows_between(std::size_t first, std::size_t last) {
  if (first >= last) return true;
  const std::size_t middle = first + (last - first) / 2;
  const Span& span = spans_[middle];
  return sees_run(span.y, span.x0 + 1, span.x1 - 1) && sees_rows_between(first, middle) &&
         sees_rows_between(middle + 1, last);
}

bool FaceSampler::sees_all_ves(const SpanWalker& walker) {
  for (const Span& span : spans_) {
    std::int32_t x0 = 0, x1 = 0;
    if (walker.inner(span.y, x0, x1)) {
      x0 = std::clamp(x0, span.x0, span.x1);
      x1 = std::clamp(x1, x0, span.x1);
      if (!sees_run(span.y, span.x0, x0) || !sees_run(span.y, x1, span.x1)) return false;
      continue;
    }
    for (std::int32_t x = span.x0; x < span.x1; ++x)
      if (crossed_by_edge(raster_, edge_values(raster_, x + 0.5, span.y + 0.5)) && !sees_run(span.y, x, x + 1))
        return false;
  }
  return true;
}

/// The face is hidden or partial; every in-image sample is looked at, and noted when it sees the face.
FaceClass FaceSampler::cover() {
  const auto& spans = spans_;
  FaceCoverage entry;
  entry.face = face_;
  entry.view = view_.id;
  std::int32_t x1 = 0;
  entry.x0 = std::numeric_limits<std::int32_t>::max();
  for (const Span& span : spans) {
    entry.x0 = std::min(entry.x0, span.x0);
    x1 = std::max(x1, span.x1);
  }
  entry.y0 = spans.front().y;
  entry.width = x1 - entry.x0;
  entry.height = spans.back().y + 1 - entry.y0;
  entry.first_word = coverage_.words.size();
  const auto width = static_cast<std::size_t>(entry.width);
  coverage_.words.resize(entry.first_word + (width * static_cast<std::size_t>(entry.height) + 63) / 64);
  std::size_t in_image = 0;
  restored_ = 0;
  for (const Span& span : spans) {
    in_image += static_cast<std::size_t>(span.x1 - span.x0);
    const FaceId* stored = view_.row(span.y);
    const std::size_t row = pixel_number(0, span.y);
    const bool as_stored =
        exact() && !overlay_.touches(row + static_cast<std::size_t>(span.x0), row + static_cast<std::size_t>(span.x1));
    for (std::int32_t x = span.x0; x < span.x1; ++x) {
      if (as_stored ? stored[x] != face_ : !sees(x, span.y)) continue;
      const std::size_t bit =
          static_cast<std::size_t>(span.y - entry.y0) * width + static_cast<std::size_t>(x - entry.x0);
      coverage_.words[entry.first_word + bit / 64] |= std::uint64_t{1} << (bit % 64);
      ++entry.visible;
    }
  }
  if (entry.visible == 0) {
    coverage_.words.resize(entry.first_word);
    return FaceClass::hidden;
  }
  counts_.corrected_samples += restored_;
  const std::size_t all = quick_ || inside_frame(view_.camera, raster_) ? in_image : samples_around();
  entry.visible_share = static_cast<float>(static_cast<double>(entry.visible) / static_cast<double>(all));
  coverage_.entries.push_back(entry);
  return FaceClass::partial;
}

/// Samples of the face, those outside the frame included as far as one frame away on each side.
std::size_t FaceSampler::samples_around() const {
  const std::int32_t w = view_.camera.width, h = view_.camera.height;
  const SpanWalker walker(raster_, pixel_bounds(raster_, {-w, -h, 2 * w, 2 * h}));
  std::size_t count = 0;
  walker.walk([&](std::int32_t x, std::int32_t y) { return covers_plainly(raster_, x, y); },
              [&](std::int32_t, std::int32_t x0, std::int32_t x1) { count += static_cast<std::size_t>(x1 - x0); });
  return count;
}

FaceClass FaceSampler::classify_subpixel(FaceId face, std::uint32_t visible) {
  ++counts_.processed_faces;
  counts_.samples += kSubpixelSamples;
  if (visible == 0) return FaceClass::hidden;
  if (visible == kSubpixelSamples &&
      (limits_.inside(view_.bounds(face)) || inside_frame(view_.camera, view_.raster(face))))
    return FaceClass::full;
  FaceCoverage entry;
  entry.face = face;
  entry.view = view_.id;
  entry.visible = visible;
  entry.visible_share = static_cast<float>(visible) / kSubpixelSamples;
  entry.first_word = coverage_.words.size();
  coverage_.entries.push_back(entry);
  return FaceClass::partial;
}

}  // namespace gpvc::visibility
