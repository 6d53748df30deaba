#include "visibility/face_sampler.h"

#include <algorithm>
#include <limits>

#include "visibility/lpcc.h"

namespace gpvc {

template <class Callback>
void FaceSampler::for_each_span(const SpanWalker& walker, Callback&& callback) const {
  walker.walk(
      [&](std::int32_t x, std::int32_t y) { return covers(raster_, edge_values(raster_, x + 0.5, y + 0.5)); },
      callback);
}

FaceClass FaceSampler::classify(FaceId face, bool listed) {
  face_ = face;
  raster_ = view_.raster(face);
  if (raster_.facing != Facing::front) return FaceClass::hidden;
  const SpanWalker walker(raster_, view_.frame());
  scratch_.spans.clear();
  for_each_span(walker, [&](std::int32_t y, std::int32_t x0, std::int32_t x1) {
    scratch_.spans.push_back({y, x0, x1});
  });
  if (scratch_.spans.empty())
    return misses_frame() || covers_a_pixel() ? FaceClass::hidden : classify_subpixel();
  if (!listed) return FaceClass::hidden;
  ++counts_.processed_faces;
  restored_ = 0;
  if (inside_frame()) {
    const bool full = options_.sampling == Sampling::dense ? sees_all_dense()
                      : options_.sampling == Sampling::ves ? sees_all_ves(walker)
                                                           : sees_all_hivers();
    if (full) {
      counts_.corrected_samples += restored_;
      return FaceClass::full;
    }
  }
  return cover();
}

bool FaceSampler::sees(std::int32_t x, std::int32_t y) {
  if (view_.owner(x, y) == face_) return true;
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
  return std::all_of(scratch_.spans.begin(), scratch_.spans.end(),
                     [&](const Span& span) { return sees_run(span.y, span.x0, span.x1); });
}

/// VVC and EVC on the ends of the rows and the whole of the first and the last row, then RVC on what lies
/// between. Deviation from algorithm 2: a region is not cut into three at its barycentre but into blocks of
/// rows, halved until a row is left, so that every sample is read once and none needs to be marked; the
/// conditions, and the class, are those of the paper.
bool FaceSampler::sees_all_hivers() {
  const auto& spans = scratch_.spans;
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
  const Span& span = scratch_.spans[middle];
  return sees_run(span.y, span.x0 + 1, span.x1 - 1) && sees_rows_between(first, middle) &&
         sees_rows_between(middle + 1, last);
}

bool FaceSampler::sees_all_ves(const SpanWalker& walker) {
  for (const Span& span : scratch_.spans) {
    std::int32_t x0 = 0, x1 = 0;
    if (walker.inner(span.y, x0, x1)) {
      x0 = std::clamp(x0, span.x0, span.x1);
      x1 = std::clamp(x1, x0, span.x1);
      if (!sees_run(span.y, span.x0, x0) || !sees_run(span.y, x1, span.x1)) return false;
      continue;
    }
    for (std::int32_t x = span.x0; x < span.x1; ++x)
      if (crossed_by_edge(raster_, edge_values(raster_, x + 0.5, span.y + 0.5)) &&
          !sees_run(span.y, x, x + 1))
        return false;
  }
  return true;
}

/// The face is hidden or partial; every in-image sample is looked at, and noted when it sees the face.
FaceClass FaceSampler::cover() {
  const auto& spans = scratch_.spans;
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
    for (std::int32_t x = span.x0; x < span.x1; ++x) {
      if (!sees(x, span.y)) continue;
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
  const std::size_t all = inside_frame() ? in_image : samples_around();
  entry.visible_share = static_cast<float>(static_cast<double>(entry.visible) / static_cast<double>(all));
  coverage_.entries.push_back(entry);
  return FaceClass::partial;
}

bool FaceSampler::inside_frame() const {
  return std::all_of(raster_.vertex.begin(), raster_.vertex.end(), [&](const ProjectedVertex& v) {
    return v.z > 0 && v.u >= 0 && v.v >= 0 && v.u <= view_.camera.width * v.z &&
           v.v <= view_.camera.height * v.z;
  });
}

/// Samples of the face, those outside the frame included as far as one frame away on each side.
std::size_t FaceSampler::samples_around() const {
  const std::int32_t w = view_.camera.width, h = view_.camera.height;
  std::size_t count = 0;
  for_each_span(
      SpanWalker(raster_, {-w, -h, 2 * w, 2 * h}),
      [&](std::int32_t, std::int32_t x0, std::int32_t x1) { count += static_cast<std::size_t>(x1 - x0); });
  return count;
}

/// On the unbounded grid. The projection of a face that crosses the camera plane is unbounded in two
/// directions that are not parallel, so it covers pixel centres without end.
bool FaceSampler::covers_a_pixel() const {
  for (const ProjectedVertex& v : raster_.vertex)
    if (!(v.z > 0)) return true;
  constexpr std::int32_t kFar = 1 << 22;
  bool found = false;
  for_each_span(SpanWalker(raster_, {-kFar, -kFar, kFar, kFar}),
                [&](std::int32_t, std::int32_t, std::int32_t) { found = true; });
  return found;
}

/// True when the projection certainly lies outside [0, W] x [0, H]; never for a face that crosses the camera
/// plane, unless it is wholly behind it.
bool FaceSampler::misses_frame() const {
  const auto& v = raster_.vertex;
  const double w = view_.camera.width, h = view_.camera.height;
  const auto all = [&](auto&& beyond) { return std::all_of(v.begin(), v.end(), beyond); };
  return all([](const ProjectedVertex& p) { return !(p.z > 0); }) ||
         all([](const ProjectedVertex& p) { return p.z > 0 && p.u < 0; }) ||
         all([](const ProjectedVertex& p) { return p.z > 0 && p.v < 0; }) ||
         all([w](const ProjectedVertex& p) { return p.z > 0 && p.u > w * p.z; }) ||
         all([h](const ProjectedVertex& p) { return p.z > 0 && p.v > h * p.z; });
}

/// The centroid and the midpoints from it to the vertices, each against the owner of the pixel it lies in.
FaceClass FaceSampler::classify_subpixel() {
  if (!options_.subpixel) return FaceClass::unresolved;
  ++counts_.processed_faces;
  const auto& v = raster_.vertex;
  const ProjectedVertex centroid{v[0].u + v[1].u + v[2].u, v[0].v + v[1].v + v[2].v,
                                 v[0].z + v[1].z + v[2].z};
  std::uint32_t seen = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    ProjectedVertex q = centroid;
    if (k < 3) q = {q.u + 3 * v[k].u, q.v + 3 * v[k].v, q.z + 3 * v[k].z};
    ++counts_.samples;
    seen += sees_point({q.u / q.z, q.v / q.z});
  }
  if (seen == 0) return FaceClass::hidden;
  if (seen == 4 && inside_frame()) return FaceClass::full;
  FaceCoverage entry;
  entry.face = face_;
  entry.view = view_.id;
  entry.visible = seen;
  entry.visible_share = static_cast<float>(seen) / 4;
  entry.first_word = coverage_.words.size();
  coverage_.entries.push_back(entry);
  return FaceClass::partial;
}

bool FaceSampler::sees_point(const PixelPoint& q) const {
  const double w = view_.camera.width, h = view_.camera.height;
  if (!(q.x >= 0 && q.y >= 0 && q.x < w && q.y < h)) return false;
  if (!view_.mask.whole() && !in_photo(view_.camera, q)) return false;
  const FaceId stored = view_.owner(static_cast<std::int32_t>(q.x), static_cast<std::int32_t>(q.y));
  if (stored == kNoFace || stored == face_) return true;
  const RasterFace other = view_.raster(stored);
  if (other.facing == Facing::edge_on) return true;
  const EdgeValues other_values = edge_values(other, q.x, q.y);
  if (!covers(other, other_values)) return true;
  const EdgeValues values = edge_values(raster_, q.x, q.y);
  const double order = compare_depth(plane_depth(raster_, values), plane_depth(other, other_values));
  return order < 0 || (order == 0 && face_ < stored);
}

}  // namespace gpvc
