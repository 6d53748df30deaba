#include "visibility/classify/exact_scan.h"

#include <algorithm>

namespace gpvc::visibility {

/// What one thread gathers: sums and sets, whose order does not matter.
class ExactScan::Scanner {
 public:
  void start(const ClassifyView& view) {
    limits_ = view.quick_limits();
    counts_ = {};
    claims_.clear();
    owners_.start();
  }
  FaceCode scan(const ClassifyView& view, FaceId face, const FaceBounds& bounds);
  void keep_if_right(const ClassifyView& view, const Claim& claim);
  void add_to(FaceScan& scan) const;

 private:
  FaceCode scan_quick(const ClassifyView& view, FaceId face, bool front);
  FaceCode scan_raster(const ClassifyView& view, FaceId face, const FaceBounds& bounds);
  FaceCode full();
  FaceCode contest(const ClassifyView& view, FaceId face, bool front);

  QuickLimits limits_;
  SampleCounts counts_;
  std::vector<Claim> claims_;
  std::vector<Span> spans_;  ///< of the face at hand
  OwnerContest owners_;
};

FaceCode ExactScan::Scanner::scan(const ClassifyView& view, FaceId face, const FaceBounds& bounds) {
  if (limits_.inside(bounds)) {
    const QuickFace quick = view.quick(limits_, face, bounds);
    if (quick.spans(pixel_centres(bounds, view.frame()), spans_))
      return scan_quick(view, face, quick.facing() == Facing::front);
  }
  return scan_raster(view, face, bounds);
}

/// For a face inside the frame whose spans are known.
FaceCode ExactScan::Scanner::scan_quick(const ClassifyView& view, FaceId face, bool front) {
  // The rows lie far apart in memory.
  for (const Span& span : spans_) __builtin_prefetch(view.row(span.y) + span.x0);
  if (!front) return contest(view, face, false);
  if (spans_.empty()) return FaceCode::no_centre;
  return all_stored(view.ivm, view.camera.width, spans_, face) ? full() : contest(view, face, true);
}

FaceCode ExactScan::Scanner::scan_raster(const ClassifyView& view, FaceId face, const FaceBounds& bounds) {
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

/// Claims the pixels whose stored owner the face beats.
FaceCode ExactScan::Scanner::contest(const ClassifyView& view, FaceId face, bool front) {
  const auto width = static_cast<std::size_t>(view.camera.width);
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
        continue;
      }
      if (owner != kNoFace && owners_.keeps(view, limits_, contender, owner, {span.y, x0, end})) {
        counts_.contested_samples += static_cast<std::size_t>(end - x0);
        continue;
      }
      for (std::int32_t x = x0; x < end; ++x) {
        if (!view.mask.contains(x, span.y)) continue;
        ++counts_.contested_samples;
        if (owners_.wins(view, limits_, contender, owner, x, span.y))
          claims_.push_back(
              {static_cast<std::uint32_t>(static_cast<std::size_t>(span.y) * width + static_cast<std::size_t>(x)),
               face});
      }
    }
  }
  if (!front) return FaceCode::hidden;
  return stored ? FaceCode::partial : FaceCode::unstored;
}

void ExactScan::Scanner::keep_if_right(const ClassifyView& view, const Claim& claim) {
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  Contender contender(view, claim.face);
  if (owners_.wins(view, limits_, contender, view.ivm[claim.pixel], static_cast<std::int32_t>(claim.pixel % width),
                   static_cast<std::int32_t>(claim.pixel / width)))
    claims_.push_back(claim);
}

void ExactScan::Scanner::add_to(FaceScan& scan) const {
  scan.claims.insert(scan.claims.end(), claims_.begin(), claims_.end());
  scan.counts += counts_;
}

ExactScan::ExactScan() : scanners_([] { return std::make_unique<Scanner>(); }) {}
ExactScan::~ExactScan() = default;

void ExactScan::start(const ClassifyView& view) {
  view_ = &view;
  for (const std::unique_ptr<Scanner>& scanner : scanners_) scanner->start(view);
}

ExactScan::Scanner& ExactScan::scanner() {
  bool exists = false;
  Scanner& scanner = *scanners_.local(exists);
  if (!exists) scanner.start(*view_);
  return scanner;
}

void ExactScan::gather(FaceScan& scan) const {
  for (const std::unique_ptr<Scanner>& scanner : scanners_) scanner->add_to(scan);
}

void ExactScan::scan(const ClassifyView& view, FaceScan& scan) {
  const std::size_t faces = view.mesh.faces.size();
  scan.start(faces);
  scan.touched.resize((faces + kFacesPerRectangle - 1) / kFacesPerRectangle);
  start(view);
  for_each_block(faces, [&](std::size_t, std::size_t first, std::size_t end) {
    static_assert(kFacesPerBlock % kFacesPerRectangle == 0);
    Scanner& scanner = this->scanner();
    FaceBounds touched;
    for (std::size_t f = first; f < end; ++f) {
      const FaceId face{static_cast<std::uint32_t>(f)};
      const FaceBounds bounds = view.bounds(face);
      const bool seen = !outside(bounds, view.camera.width, view.camera.height);
      scan.codes[f] = seen ? scanner.scan(view, face, bounds) : FaceCode::hidden;
      if (seen) touched = united(touched, bounds);
      if ((f + 1) % kFacesPerRectangle != 0 && f + 1 < end) continue;
      scan.touched[f / kFacesPerRectangle] = touched_pixels(touched, view.frame());
      touched = {};
    }
  });
  gather(scan);
}

void ExactScan::settle(const ClassifyView& view, FaceScan& scan) {
  start(view);
  for_each_block(scan.codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t f = first; f < end; ++f) {
      if (scan.codes[f] != FaceCode::unsure) continue;
      const FaceId face{static_cast<std::uint32_t>(f)};
      scan.codes[f] = scanner().scan(view, face, view.bounds(face));
    }
  });
  for_each_block(scan.claims.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) scanner().keep_if_right(view, scan.claims[i]);
  });
  scan.claims.clear();
  gather(scan);
}

}  // namespace gpvc::visibility
