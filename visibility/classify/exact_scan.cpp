#include "visibility/classify/exact_scan.h"

#include <algorithm>
#include <optional>

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
  for (std::int32_t end = 0, x = run.x0; x < run.x1; x = end) {
    end = x + 1;
    if (!view.mask.contains(x, run.y)) continue;
    while (end < run.x1 && view.mask.contains(end, run.y)) ++end;
    counts_.contested_samples += static_cast<std::size_t>(end - x);
    claim_run(view, contender, owner, {run.y, x, end});
  }
}

/// Claims the pixels of the run, all stored as the owner's, where the contender beats it. Faces that nearly coincide
/// contest thousands of pixels, but change places few times in a row: halving finds where.
void ExactScanner::claim_run(const PreparedView& view, Contender& contender, FaceId owner, const Span& run) {
  const std::optional<bool> beats = owners_.beats_stored_in(view, contender, owner, run);
  if (!beats) {
    const std::int32_t middle = run.x0 + (run.x1 - run.x0) / 2;
    claim_run(view, contender, owner, {run.y, run.x0, middle});
    claim_run(view, contender, owner, {run.y, middle, run.x1});
  } else if (*beats) {
    for (std::int32_t x = run.x0; x < run.x1; ++x)
      claims_.push_back({static_cast<std::uint32_t>(view.pixel_index(x, run.y)), contender.face()});
  }
}

void ExactScanner::keep_right(const PreparedView& view, std::span<const Claim> claims) {
  const auto width = static_cast<std::uint32_t>(view.camera.width);
  for (std::size_t end = 0, first = 0; first < claims.size(); first = end) {
    const auto [pixel, face] = claims[first];
    const FaceId owner = view.ivm[pixel];
    const std::size_t row_end = first + (width - pixel % width);
    end = first + 1;
    while (end < std::min(row_end, claims.size()) && claims[end].face == face &&
           claims[end].pixel == claims[end - 1].pixel + 1 && view.ivm[claims[end].pixel] == owner)
      ++end;
    Contender contender(view, face);
    const auto x0 = static_cast<std::int32_t>(pixel % width);
    claim_run(view, contender, owner,
              {static_cast<std::int32_t>(pixel / width), x0, x0 + static_cast<std::int32_t>(end - first)});
  }
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
    scanners.local().keep_right(view, std::span(scan.claims).subspan(first, end - first));
  });
  scan.claims.clear();
  for (const ExactScanner& scanner : scanners) scanner.add_to(scan);
}

}  // namespace gpvc::visibility
