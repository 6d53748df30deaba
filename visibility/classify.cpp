#include "visibility/classify.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "visibility/exact_owner.h"
#include "visibility/face_sampler.h"
#include "visibility/subpixel.h"

namespace gpvc {
namespace {

/// Fixed, so that what a block yields does not depend on the number of threads.
constexpr std::size_t kFacesPerBlock = 2048;
/// Few enough that they mostly lie beside each other: most rectangles then hold no sub-pixel sample.
constexpr std::size_t kFacesPerRectangle = 64;

}  // namespace

/// What the scan finds out about a face.
enum class CpuClassifier::State : std::uint8_t {
  hidden,      ///< certainly
  unstored,    ///< a front face with samples in the frame, none of them stored as its own
  full,        ///< all its samples are stored as its own
  sampled,     ///< to be sampled
  subpixel,    ///< no pixel centre in its projection
  unresolved,  ///< the same, with sub-pixel resolution off
};

/// What one block of consecutive faces yields; joined in face order at the end.
struct CpuClassifier::Block : BlockYield {
  std::array<FaceBounds, kFacesPerBlock / kFacesPerRectangle> touched;  ///< what its faces touch
  std::vector<Claim> claims;
  std::vector<FaceId> subpixel_faces;
  std::size_t first_subpixel = 0;  ///< number of the first of them among all
  std::vector<Span> spans;         ///< of the face at hand
  OwnerContest* owners = nullptr;  ///< of the thread at hand

  void start() {
    clear();
    touched.fill({});
    claims.clear();
    subpixel_faces.clear();
  }
};

CpuClassifier::CpuClassifier(const VisibilityOptions& options)
    : options_(options),
      contests_([] { return std::make_unique<OwnerContest>(); }),
      overlay_(std::make_unique<OwnerOverlay>()),
      subpixel_(std::make_unique<SubpixelResolver>()) {}
CpuClassifier::~CpuClassifier() = default;

void CpuClassifier::start(const ClassifyView& view, ViewVisibility& result) {
  result.classes.resize(view.mesh.faces.size());
  states_.resize(view.mesh.faces.size());
  blocks_.resize((view.mesh.faces.size() + kFacesPerBlock - 1) / kFacesPerBlock);
  quick_ = view.quick_limits();
  for (const std::unique_ptr<OwnerContest>& contest : contests_) contest->start();
}

void CpuClassifier::classify(const ClassifyView& view, ViewVisibility& result) {
  start(view, result);
  if (options_.correction != CoverageCorrection::exact) find_candidates(view);
  tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t number) { scan_block(view, number); });
  if (options_.correction == CoverageCorrection::exact) correct_owners(view);
  finish(view, result);
}

void CpuClassifier::complete(const ClassifyView& view, std::span<const FaceCode> codes,
                             ViewVisibility& result) {
  start(view, result);
  for (std::size_t number = 0; number < blocks_.size(); ++number) {
    Block& block = blocks_[number];
    block.start();
    block.touched.fill({0, 0, 0, 0, true, false});
    const std::size_t first = number * kFacesPerBlock;
    for (std::size_t f = first; f < std::min(first + kFacesPerBlock, codes.size()); ++f) {
      constexpr std::array kStates{State::hidden, State::sampled, State::full, State::subpixel};
      states_[f] = kStates[static_cast<std::size_t>(codes[f])];
      if (states_[f] != State::subpixel) continue;
      if (options_.subpixel) {
        block.subpixel_faces.push_back(FaceId{static_cast<std::uint32_t>(f)});
      } else {
        states_[f] = State::unresolved;
      }
    }
  }
  finish(view, result);
}

void CpuClassifier::finish(const ClassifyView& view, ViewVisibility& result) {
  if (options_.subpixel) resolve_subpixel(view);
  tbb::parallel_for(std::size_t{0}, blocks_.size(),
                    [&](std::size_t number) { finish_block(view, number, result); });
  join(blocks_, result);
}

void CpuClassifier::find_candidates(const ClassifyView& view) {
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

void CpuClassifier::scan_block(const ClassifyView& view, std::size_t number) {
  Block& block = blocks_[number];
  block.start();
  block.owners = contests_.local().get();
  const std::size_t first = number * kFacesPerBlock;
  const std::size_t last = std::min(first + kFacesPerBlock, view.mesh.faces.size());
  for (std::size_t f = first; f < last; ++f)
    states_[f] = scan_face(view, FaceId{static_cast<std::uint32_t>(f)}, block);
}

CpuClassifier::State CpuClassifier::scan_face(const ClassifyView& view, FaceId face, Block& block) {
  const FaceBounds bounds = view.bounds(face);
  if (outside(bounds, view.camera.width, view.camera.height)) return State::hidden;
  FaceBounds& touched = block.touched[index(face) % kFacesPerBlock / kFacesPerRectangle];
  touched = united(touched, bounds);
  if (options_.correction == CoverageCorrection::exact && quick_.inside(bounds)) {
    const QuickFace quick = view.quick(quick_, face, bounds);
    if (quick.spans(pixel_centres(bounds, view.frame()), block.spans))
      return scan_quick(view, face, quick.facing() == Facing::front, block);
  }
  return scan_raster(view, face, bounds, block);
}

/// For a face inside the frame whose spans are known.
CpuClassifier::State CpuClassifier::scan_quick(const ClassifyView& view, FaceId face, bool front,
                                               Block& block) const {
  // The rows lie far apart in memory.
  for (const Span& span : block.spans) __builtin_prefetch(view.row(span.y) + span.x0);
  if (!front) return contest(view, face, false, block);
  if (block.spans.empty()) {
    if (!options_.subpixel) return State::unresolved;
    block.subpixel_faces.push_back(face);
    return State::subpixel;
  }
  std::size_t samples = 0;
  if (!all_stored(view.ivm, view.camera.width, block.spans, face)) return contest(view, face, true, block);
  for (const Span& span : block.spans) samples += static_cast<std::size_t>(span.x1 - span.x0);
  block.counts.samples += samples;
  ++block.counts.processed_faces;
  return State::full;
}

CpuClassifier::State CpuClassifier::scan_raster(const ClassifyView& view, FaceId face,
                                                const FaceBounds& bounds, Block& block) {
  const bool exact = options_.correction == CoverageCorrection::exact;
  const RasterFace raster = view.raster(face);
  if (raster.facing == Facing::edge_on) return State::hidden;
  const bool front = raster.facing == Facing::front;
  if (!exact && !front) return State::hidden;
  const SpanWalker walker(raster, pixel_bounds(raster, bounds, view.frame()));
  collect_spans(raster, walker, exact, block.spans);
  if (block.spans.empty()) {
    if (!front || misses_frame(view.camera, raster)) return State::hidden;
    if (!inside_frame(view.camera, raster) && covers_a_pixel(raster)) return State::hidden;
    if (!options_.subpixel) return State::unresolved;
    block.subpixel_faces.push_back(face);
    return State::subpixel;
  }
  if (!exact && candidate_faces_[index(face)] == 0) return State::hidden;
  const std::size_t samples = block.counts.samples;
  if (front && stores_everywhere(view, face, walker, block) && inside_frame(view.camera, raster)) {
    ++block.counts.processed_faces;
    return State::full;
  }
  block.counts.samples = samples;
  return exact ? contest(view, face, front, block) : State::sampled;
}

/// The common case, without corrections: every sample that the sampling mode asks for is stored as the
/// face's.
bool CpuClassifier::stores_everywhere(const ClassifyView& view, FaceId face, const SpanWalker& walker,
                                      Block& block) const {
  const bool ves = options_.sampling == Sampling::ves && options_.correction != CoverageCorrection::exact;
  for (const Span& span : block.spans) {
    std::int32_t x0 = span.x1, x1 = span.x1;
    if (ves && walker.inner(span.y, x0, x1)) {
      x0 = std::clamp(x0, span.x0, span.x1);
      x1 = std::clamp(x1, x0, span.x1);
    }
    for (std::int32_t x = span.x0; x < x0; ++x)
      if (view.owner(x, span.y) != face) return false;
    for (std::int32_t x = x1; x < span.x1; ++x)
      if (view.owner(x, span.y) != face) return false;
    block.counts.samples += static_cast<std::size_t>((x0 - span.x0) + (span.x1 - x1));
  }
  return true;
}

/// Claims the pixels whose stored owner the face beats. What becomes of the face unless somebody corrects an
/// owner.
CpuClassifier::State CpuClassifier::contest(const ClassifyView& view, FaceId face, bool front,
                                            Block& block) const {
  const auto width = static_cast<std::size_t>(view.camera.width);
  Contender contender(view, face);
  bool stored = false;
  for (const Span& span : block.spans) {
    const FaceId* owners = view.row(span.y);
    for (std::int32_t end = 0, x0 = span.x0; x0 < span.x1; x0 = end) {
      const FaceId owner = owners[x0];
      end = x0 + 1;
      while (end < span.x1 && owners[end] == owner) ++end;
      if (owner == face) {
        stored = true;
        continue;
      }
      if (owner != kNoFace && block.owners->keeps(view, quick_, contender, owner, {span.y, x0, end})) {
        block.counts.contested_samples += static_cast<std::size_t>(end - x0);
        continue;
      }
      for (std::int32_t x = x0; x < end; ++x) {
        if (!view.mask.contains(x, span.y)) continue;
        ++block.counts.contested_samples;
        if (block.owners->wins(view, quick_, contender, owner, x, span.y))
          block.claims.push_back({static_cast<std::uint32_t>(static_cast<std::size_t>(span.y) * width +
                                                             static_cast<std::size_t>(x)),
                                  face});
      }
    }
  }
  if (!front) return State::hidden;
  return stored ? State::sampled : State::unstored;
}

void CpuClassifier::correct_owners(const ClassifyView& view) {
  std::vector<Claim> claims;
  for (const Block& block : blocks_) claims.insert(claims.end(), block.claims.begin(), block.claims.end());
  overlay_->resolve(view, claims);
  const auto resample = [&](FaceId face) {
    State& state = states_[index(face)];
    if (state == State::full) {
      // Counted when it was scanned; the sampler counts it again.
      Block& block = blocks_[index(face) / kFacesPerBlock];
      --block.counts.processed_faces;
      state = State::sampled;
    } else if (state == State::unstored) {
      state = State::sampled;
    }
  };
  for (const Claim& entry : overlay_->entries()) {
    resample(entry.face);
    if (view.ivm[entry.pixel] != kNoFace) resample(view.ivm[entry.pixel]);
  }
}

void CpuClassifier::resolve_subpixel(const ClassifyView& view) {
  std::vector<FaceId> faces;
  std::vector<PixelBox> touched;
  for (Block& block : blocks_) {
    block.first_subpixel = faces.size();
    faces.insert(faces.end(), block.subpixel_faces.begin(), block.subpixel_faces.end());
    for (const FaceBounds& bounds : block.touched) touched.push_back(touched_pixels(bounds, view.frame()));
  }
  subpixel_->resolve(view, faces, touched, kFacesPerRectangle);
}

void CpuClassifier::finish_block(const ClassifyView& view, std::size_t number, ViewVisibility& result) {
  Block& block = blocks_[number];
  FaceSampler sampler(view, options_, *overlay_, block.coverage, block.counts);
  const std::size_t first = number * kFacesPerBlock;
  const std::size_t last = std::min(first + kFacesPerBlock, view.mesh.faces.size());
  std::size_t subpixel = block.first_subpixel;
  for (std::size_t f = first; f < last; ++f) {
    const FaceId face{static_cast<std::uint32_t>(f)};
    FaceClass found = FaceClass::hidden;
    switch (states_[f]) {
      case State::hidden:
      case State::unstored:
        break;
      case State::full:
        found = FaceClass::full;
        break;
      case State::sampled:
        found = sampler.classify(face);
        break;
      case State::subpixel:
        found = sampler.classify_subpixel(face, subpixel_->visible(subpixel++));
        break;
      case State::unresolved:
        found = FaceClass::unresolved;
        break;
    }
    result.classes[f] = found;
    block.full += found == FaceClass::full;
  }
}

}  // namespace gpvc
