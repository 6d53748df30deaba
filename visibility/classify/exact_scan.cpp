#include "visibility/classify/exact_scan.h"

namespace gpvc::visibility {

void ExactScanner::start() {
  counts_ = {};
  claims_.clear();
  owners_.start();
}

FaceCode ExactScanner::scan(const PreparedView& view, FaceId face) {
  if (!find_samples(view, face, SpanSearch::quick, samples_)) return FaceCode::hidden;
  if (samples_.facing == Facing::front && samples_.spans.empty()) return FaceCode::no_centre;
  return contest(view, face);
}

/// Run by run of pixels with the same stored owner, claims those whose owner the face beats.
FaceCode ExactScanner::contest(const PreparedView& view, FaceId face) {
  Contender contender(view, face);
  std::size_t own = 0, all = 0;
  for (const Span& span : samples_.spans) {
    const FaceId* owners = view.row(span.y);
    all += static_cast<std::size_t>(span.x1 - span.x0);
    for (std::int32_t end = 0, x0 = span.x0; x0 < span.x1; x0 = end) {
      const FaceId owner = owners[x0];
      end = x0 + 1;
      while (end < span.x1 && owners[end] == owner) ++end;
      if (owner == face) {
        own += static_cast<std::size_t>(end - x0);
      } else {
        contest_run(view, contender, owner, {span.y, x0, end});
      }
    }
  }
  if (samples_.facing != Facing::front) return FaceCode::hidden;
  if (own == 0) return FaceCode::unstored;
  if (own < all || !samples_.inside) return FaceCode::partial;
  counts_.samples += all;
  ++counts_.processed_faces;
  return FaceCode::full;
}

void ExactScanner::contest_run(const PreparedView& view, Contender& contender, FaceId owner, const Span& run) {
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

void ExactScanner::keep_if_right(const PreparedView& view, const Claim& claim) {
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  Contender contender(view, claim.face);
  if (owners_.beats_stored_at(view, contender, view.ivm[claim.pixel], static_cast<std::int32_t>(claim.pixel % width),
                              static_cast<std::int32_t>(claim.pixel / width)))
    claims_.push_back(claim);
}

void ExactScanner::add_to(FaceScan& scan) const {
  scan.claims.insert(scan.claims.end(), claims_.begin(), claims_.end());
  scan.counts += counts_;
}

void decide_unsure_exactly(const PreparedView& view, ExactScanners& scanners, FaceScan& scan) {
  for (ExactScanner& scanner : scanners) scanner.start();
  for_each_block(scan.codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    ExactScanner& scanner = scanners.local();
    for (std::size_t f = first; f < end; ++f)
      if (scan.codes[f] == FaceCode::unsure) scan.codes[f] = scanner.scan(view, FaceId{static_cast<std::uint32_t>(f)});
  });
  for_each_block(scan.claims.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    ExactScanner& scanner = scanners.local();
    for (std::size_t i = first; i < end; ++i) scanner.keep_if_right(view, scan.claims[i]);
  });
  scan.claims.clear();
  for (const ExactScanner& scanner : scanners) scanner.add_to(scan);
}

}  // namespace gpvc::visibility
