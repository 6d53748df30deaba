#include "visibility/classify/exact_scan.h"

#include <algorithm>

namespace gpvc::visibility {

/// The claims and counts of one thread: sums and sets, whose order does not matter.
class ExactScan::Scanner {
 public:
  void start() {
    counts_ = {};
    claims_.clear();
    owners_.start();
  }
  FaceCode scan(const PreparedView& view, FaceId face);
  void keep_if_right(const PreparedView& view, const Claim& claim);
  void add_to(FaceScan& scan) const;

 private:
  FaceCode scan_quick(const PreparedView& view, FaceId face, bool front);
  FaceCode scan_raster(const PreparedView& view, FaceId face, const FaceBounds& bounds);
  FaceCode full();
  FaceCode contest(const PreparedView& view, FaceId face, bool front);
  void contest_run(const PreparedView& view, Contender& contender, FaceId owner, const Span& run);

  SampleCounts counts_;
  std::vector<Claim> claims_;
  std::vector<Span> spans_;  ///< of the current face
  OwnerContest owners_;
};

FaceCode ExactScan::Scanner::scan(const PreparedView& view, FaceId face) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, view.camera.width, view.camera.height)) return FaceCode::hidden;
  if (view.limits.inside_frame(bounds)) {
    const QuickFace quick = view.quick(face, bounds);
    if (quick.spans(pixel_centres(bounds, view.frame()), spans_))
      return scan_quick(view, face, quick.facing() == Facing::front);
  }
  return scan_raster(view, face, bounds);
}

/// For a face inside the frame whose spans are certain.
FaceCode ExactScan::Scanner::scan_quick(const PreparedView& view, FaceId face, bool front) {
  // The rows are far apart in memory.
  for (const Span& span : spans_) __builtin_prefetch(view.row(span.y) + span.x0);
  if (!front) return contest(view, face, false);
  if (spans_.empty()) return FaceCode::no_centre;
  return all_stored(view.ivm, view.camera.width, spans_, face) ? full() : contest(view, face, true);
}

FaceCode ExactScan::Scanner::scan_raster(const PreparedView& view, FaceId face, const FaceBounds& bounds) {
  const RasterFace raster = view.raster(face);
  if (raster.facing == Facing::edge_on) return FaceCode::hidden;
  const bool front = raster.facing == Facing::front;
  const SpanWalker walker(raster, pixel_bounds(raster, bounds, view.frame()));
  collect_spans(raster, walker, true, spans_);
  if (spans_.empty())
    return front && !misses_frame(view.camera, raster.vertex) ? FaceCode::no_centre : FaceCode::hidden;
  if (front && all_stored(view.ivm, view.camera.width, spans_, face) && inside_frame(view.camera, raster))
    return full();
  return contest(view, face, front);
}

FaceCode ExactScan::Scanner::full() {
  for (const Span& span : spans_) counts_.samples += static_cast<std::size_t>(span.x1 - span.x0);
  ++counts_.processed_faces;
  return FaceCode::full;
}

/// Run by run of pixels with the same stored owner, claims those whose owner the face beats.
FaceCode ExactScan::Scanner::contest(const PreparedView& view, FaceId face, bool front) {
  Contender contender(view, face);
  bool stored = false;
  for (const Span& span : spans_) {
    const FaceId* owners = view.row(span.y);
    for (std::int32_t end = 0, x0 = span.x0; x0 < span.x1; x0 = end) {
      const FaceId owner = owners[x0];
      end = x0 + 1;
      while (end < span.x1 && owners[end] == owner) ++end;
      if (owner == face) {
        stored = true;
      } else {
        contest_run(view, contender, owner, {span.y, x0, end});
      }
    }
  }
  if (!front) return FaceCode::hidden;
  return stored ? FaceCode::partial : FaceCode::unstored;
}

void ExactScan::Scanner::contest_run(const PreparedView& view, Contender& contender, FaceId owner, const Span& run) {
  if (owner != kNoFace && owners_.stored_owner_keeps_run(view, contender, owner, run)) {
    counts_.contested_samples += static_cast<std::size_t>(run.x1 - run.x0);
    return;
  }
  for (std::int32_t x = run.x0; x < run.x1; ++x) {
    if (!view.mask.contains(x, run.y)) continue;
    ++counts_.contested_samples;
    if (owners_.beats_stored_at(view, contender, owner, x, run.y))
      claims_.push_back({static_cast<std::uint32_t>(view.pixel_index(x, run.y)), contender.face()});
  }
}

void ExactScan::Scanner::keep_if_right(const PreparedView& view, const Claim& claim) {
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  Contender contender(view, claim.face);
  if (owners_.beats_stored_at(view, contender, view.ivm[claim.pixel], static_cast<std::int32_t>(claim.pixel % width),
                              static_cast<std::int32_t>(claim.pixel / width)))
    claims_.push_back(claim);
}

void ExactScan::Scanner::add_to(FaceScan& scan) const {
  scan.claims.insert(scan.claims.end(), claims_.begin(), claims_.end());
  scan.counts += counts_;
}

ExactScan::ExactScan() : scanners_([] { return std::make_unique<Scanner>(); }) {}
ExactScan::~ExactScan() = default;

void ExactScan::scan(const PreparedView& view, FaceScan& scan) {
  scan.start(view.mesh.faces.size());
  std::fill(scan.codes.begin(), scan.codes.end(), FaceCode::unsure);
  settle(view, scan);
}

void ExactScan::settle(const PreparedView& view, FaceScan& scan) {
  for (const std::unique_ptr<Scanner>& scanner : scanners_) scanner->start();
  for_each_block(scan.codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    Scanner& scanner = *scanners_.local();
    for (std::size_t f = first; f < end; ++f)
      if (scan.codes[f] == FaceCode::unsure) scan.codes[f] = scanner.scan(view, FaceId{static_cast<std::uint32_t>(f)});
  });
  for_each_block(scan.claims.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    Scanner& scanner = *scanners_.local();
    for (std::size_t i = first; i < end; ++i) scanner.keep_if_right(view, scan.claims[i]);
  });
  scan.claims.clear();
  for (const std::unique_ptr<Scanner>& scanner : scanners_) scanner->add_to(scan);
}

}  // namespace gpvc::visibility
