#include "visibility/native/ivm_tile.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>

#include "io/wide_clones.h"
#include "visibility/classify/front_faces.h"
#include "visibility/raster/tile_lists.h"
#include "visibility/raster/wide.h"

namespace gpvc::visibility {
namespace {

constexpr double kNear = 0x1p-21;
constexpr float kFar = 0x1p-20F;
/// The greatest error of a plane of 1 / z, relative to D, with which a face is drawn with certainty.
constexpr double kPlane = 0x1p-25;
/// The range of 1 / z. With a plane no further off than kPlane a face is wider than 2^-19 of its area, so that its
/// gradient times a run stays below 2^127; the 2^-143 lost where that product is denormal is negligible beside 2^-24 D.
constexpr double kLeast = 0x1p-100, kMost = 0x1p100;

constexpr auto kSide = static_cast<std::size_t>(IvmTile::kSide);
constexpr std::size_t kPixels = kSide * kSide;
constexpr std::size_t kLanes = 8;

inline bool any(const EightInts& flags) {
  FourFlags words;
  std::memcpy(&words, &flags, sizeof(words));
  return (words[0] | words[1] | words[2] | words[3]) != 0;
}

/// The nearest float in the range of 1 / z.
float stored_depth(double inverse) {
  return inverse > kLeast ? static_cast<float>(std::min(inverse, kMost)) : static_cast<float>(kLeast);
}

}  // namespace

void IvmTile::start_view() {
  doubts_.clear();
  rough_pixels_.clear();
  hidden_samples_ = 0;
}

void IvmTile::start(std::span<const FaceId> faces, std::span<const FaceId> unlisted) {
  depths_.assign(kPixels + kLanes, 0);
  owners_.assign(kPixels + kLanes, 0);
  faces_.clear();
  faces_.push_back(kNoFace);
  faces_.insert(faces_.end(), faces.begin(), faces.end());
  faces_.insert(faces_.end(), unlisted.begin(), unlisted.end());
  entries_.assign(faces_.size(), {});
  lost_.assign(faces_.size(), 0);
  stored_.assign(faces_.size(), 0);
  unsure_.clear();
}

void IvmTile::draw(const PreparedView& view, const PixelBox& box, std::span<const FaceId> faces,
                   std::span<const FaceId> unlisted, std::span<FaceId> ivm, DrawnFaces& drawn) {
  box_ = box;
  view_width_ = static_cast<std::uint32_t>(view.camera.width);
  const std::size_t first_doubt = doubts_.size();
  start(faces, unlisted);
  for (std::uint32_t number = 1; number < faces_.size(); ++number) {
    prefetch(view, faces_, number);
    draw_face(view, number);
  }
  for (const std::uint32_t number : unsure_) draw_unsure(view, number);
  if (!view.mask.whole()) clear_outside_photo(view, first_doubt);
  store(view, ivm);
  add_to(drawn);
}

void IvmTile::draw_face(const PreparedView& view, std::uint32_t number) {
  const FaceBounds bounds = view.bounds(faces_[number]);
  Entry& entry = entries_[number];
  entry.shared =
      !(bounds.bounded && bounds.x0 >= box_.x0 && bounds.y0 >= box_.y0 && bounds.x1 <= box_.x1 && bounds.y1 <= box_.y1);
  if (draw_certain(view, bounds, number)) return;
  entry.marks = kMarkUnsure;
  unsure_.push_back(number);
}

/// False when it is not certain which pixels the face covers; some of its rows may have been drawn all the same.
bool IvmTile::draw_certain(const PreparedView& view, const FaceBounds& bounds, std::uint32_t number) {
  const FaceId face = faces_[number];
  const QuickFace quick = view.quick(face, bounds);
  if (quick.facing() == Facing::edge_on) return false;
  Entry& entry = entries_[number];
  entry.marks = static_cast<std::uint8_t>((quick.facing() == Facing::front ? kMarkFront : 0) |
                                          (view.limits.inside_frame(bounds) ? kMarkInside : 0));
  const PixelBox box = pixel_centres(bounds, box_);
  if (box.empty()) return true;
  const auto [largest, least] = view.inverse_depths(face);
  if (!(least >= kLeast && largest <= kMost && largest <= 2 * least)) return false;
  FaceSetup setup{pixel(box.x0, box.y0), box, {}, view.inverse_depth(quick, face), largest, number};
  if (!(setup.plane.error <= kPlane * largest) || !quick.cross(box, setup.edges)) return false;
  FaceTally tally;
  const bool certain = draw_rows(setup, {depths_.data(), owners_.data(), lost_.data(), &close_}, tally);
  entry.samples = tally.samples;
  if (tally.samples > 0) entry.marks |= kMarkSampled;
  // ExactScan contests unsure faces, and counts their samples.
  if (certain) hidden_samples_ += tally.hidden + close_.size();
  resolve_close(number);
  return certain;
}

/// Samples whose depths floats cannot order: the greater value stays, the face that loses becomes a doubt.
void IvmTile::resolve_close(std::uint32_t number) {
  for (const Close& sample : close_) {
    const bool beats = beats_stored(sample.at, sample.value, number);
    const std::uint32_t loser = beats ? owners_[sample.at] : number;
    if (beats) replace(sample.at, sample.value, number);
    lost_[loser] = 1;
    add_doubt(sample.at, loser);
  }
  close_.clear();
}

/// Depth test and write of one run of pixels, eight at a time. Adds the samples that are behind, as negative lanes of
/// `behind`, and those that replace another face to `hidden`.
[[gnu::always_inline]] inline void IvmTile::fill_run(const RunSetup& run, const Target& target, std::size_t first,
                                                     float value, std::int32_t length, EightInts& behind,
                                                     std::uint32_t& hidden) {
  const EightInts lanes{0, 1, 2, 3, 4, 5, 6, 7};
  const EightFloats lane_numbers{0, 1, 2, 3, 4, 5, 6, 7}, zero{};
  for (std::int32_t x = 0; x < length; x += static_cast<std::int32_t>(kLanes)) {
    const std::size_t at = first + static_cast<std::size_t>(x);
    const EightFloats values = value + run.per_x * (lane_numbers + static_cast<float>(x));
    EightFloats stored;
    EightIds owners;
    std::memcpy(&stored, target.depths + at, sizeof(stored));
    std::memcpy(&owners, target.owners + at, sizeof(owners));
    const EightFloats margin = stored * kFar + run.near, apart = values - stored;
    const EightInts in_run = lanes < length - x;
    const EightInts is_ahead = (apart > margin) & in_run, is_behind = (apart < -margin) & in_run;
    const EightInts replaces = is_ahead & (stored > zero), unclear = in_run & ~(is_ahead | is_behind);
    behind += is_behind;
    const EightFloats new_depths = is_ahead ? values : stored;
    const EightIds new_owners = is_ahead ? run.number : owners;
    std::memcpy(target.depths + at, &new_depths, sizeof(new_depths));
    std::memcpy(target.owners + at, &new_owners, sizeof(new_owners));
    if (!any(replaces | unclear)) continue;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (unclear[lane] != 0) target.close->push_back({static_cast<std::uint32_t>(at + lane), values[lane]});
      if (replaces[lane] == 0) continue;
      target.lost[owners[lane]] = 1;
      ++hidden;
    }
  }
}

/// Draws row by row, until the run of a row is not certain: then returns false.
///
/// The error of a value, with D the largest 1 / z of the face:
///
///     2 2^-25 D       the plane (kPlane) at the run's first pixel and along the run together; rounding the way to the
///                     pixel is within the error of InverseDepth
///     2 2^-24 D       first value and gradient rounded to floats: the gradient times the run's length is at most D
///     2 2^-24 D       rounding of their product and of their sum
///     5.01 2^-24 D    sum, with the values of the run themselves above D by these errors: below 0.63 kNear D
///
/// For the value that is stored, whose D is at most 2 s (1 + 2^-19), that is 0.64 kFar s. The remaining third covers
/// the rounding of the difference of both values and of the sum of both errors.
GPVC_WIDE_CLONES bool IvmTile::draw_rows(const FaceSetup& face, const Target& target, FaceTally& tally) {
  const InverseDepth& plane = face.plane;
  const RunSetup run{EightIds{} + face.number, static_cast<float>(plane.per_x),
                     static_cast<float>(kNear * face.largest)};
  const double from_x = face.box.x0 + 0.5 - plane.x, from_y = face.box.y0 + 0.5 - plane.y;
  const std::int32_t rows = face.box.y1 - face.box.y0;
  EightInts behind{};
  std::uint32_t samples = 0, hidden = 0;
  FourRuns runs;
  runs.sure = true;
  for (std::int32_t first_row = 0; first_row < rows; first_row += 4) {
    find_four_runs(face.edges, first_row, rows, runs);
    if (!runs.sure) break;
    const FourDoubles way_x = __builtin_convertvector(runs.begins, FourDoubles) + from_x;
    const FourDoubles way_y = FourDoubles{0, 1, 2, 3} + (first_row + from_y);
    const FourDoubles starts = plane.first + plane.per_x * way_x + plane.per_y * way_y;
    const std::int32_t last = std::min(rows - first_row, 4);
    for (std::int32_t row = 0; row < last; ++row) {
      const std::int32_t length = runs.ends[row] - runs.begins[row];
      if (length <= 0) continue;
      samples += static_cast<std::uint32_t>(length);
      const std::size_t first =
          face.first + static_cast<std::size_t>(first_row + row) * kSide + static_cast<std::size_t>(runs.begins[row]);
      fill_run(run, target, first, static_cast<float>(starts[row]), length, behind, hidden);
    }
  }
  std::uint32_t all_behind = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) all_behind -= static_cast<std::uint32_t>(behind[lane]);
  if (all_behind != 0) target.lost[face.number] = 1;
  tally = {samples, hidden + all_behind};
  return runs.sure;
}

/// The caller contests these faces in full, so this need only come close to where they are seen: pixels near their
/// edges are covered as doubles compute it. A doubt must cover its pixel in real arithmetic, so an unsure face that is
/// replaced does not become one.
void IvmTile::draw_unsure(const PreparedView& view, std::uint32_t number) {
  const RasterFace raster = view.raster(faces_[number]);
  if (raster.facing == Facing::edge_on) return;
  const SpanWalker walker(raster, pixel_bounds(raster, box_));
  collect_spans(raster, walker, false, spans_);
  if (spans_.empty()) return;
  const InverseDepth plane = inverse_depth_from(raster, spans_.front().x0 + 0.5, spans_.front().y + 0.5);
  for (const Span& run : spans_)
    for (std::int32_t x = run.x0; x < run.x1; ++x) {
      const std::size_t at = pixel(x, run.y);
      const float value = stored_depth(plane.at(x + 0.5, run.y + 0.5));
      const std::uint32_t owner = owners_[at];
      if (owner == number || !beats_stored(at, value, number)) continue;
      if (owner != 0) {
        lost_[owner] = 1;
        if ((entries_[owner].marks & kMarkUnsure) == 0) add_doubt(at, owner);
      }
      replace(at, value, number);
      rough_pixels_.push_back(pixel_of_view(at));
    }
}

/// A total order, so that among certain faces the same one remains in any order of drawing: precedes_at_equal_depth().
bool IvmTile::beats_stored(std::size_t at, float value, std::uint32_t number) const {
  if (value != depths_[at]) return value > depths_[at];
  const auto front = [&](std::uint32_t entry) { return (entries_[entry].marks & kMarkFront) != 0; };
  if (front(number) != front(owners_[at])) return front(number);
  return index(faces_[number]) < index(faces_[owners_[at]]);
}

void IvmTile::replace(std::size_t at, float value, std::uint32_t number) {
  depths_[at] = value;
  owners_[at] = number;
}

std::uint32_t IvmTile::pixel_of_view(std::size_t at) const {
  const auto x = static_cast<std::uint32_t>(box_.x0) + static_cast<std::uint32_t>(at % kSide);
  const auto y = static_cast<std::uint32_t>(box_.y0) + static_cast<std::uint32_t>(at / kSide);
  return y * view_width_ + x;
}

void IvmTile::add_doubt(std::size_t at, std::uint32_t number) {
  doubts_.push_back({pixel_of_view(at), faces_[number]});
}

void IvmTile::clear_outside_photo(const PreparedView& view, std::size_t first_doubt) {
  // Most words of the mask have all bits set.
  static_assert(kSide % 64 == 0);
  for (std::int32_t y = box_.y0; y < box_.y1; ++y)
    for (std::int32_t from = box_.x0; from < box_.x1; from += 64) {
      const std::uint64_t word =
          view.mask.words()[static_cast<std::size_t>(y) * view.mask.stride() + static_cast<std::size_t>(from) / 64];
      if (~word == 0) continue;
      for (std::int32_t x = from; x < std::min(from + 64, box_.x1); ++x) {
        if (view.mask.contains(x, y)) continue;
        std::uint32_t& owner = owners_[pixel(x, y)];
        lost_[owner] = 1;
        owner = 0;
      }
    }
  const auto outside = [&](const Claim& claim) {
    return !view.mask.contains(static_cast<int>(claim.pixel % view_width_),
                               static_cast<int>(claim.pixel / view_width_));
  };
  doubts_.erase(std::remove_if(doubts_.begin() + static_cast<std::ptrdiff_t>(first_doubt), doubts_.end(), outside),
                doubts_.end());
}

void IvmTile::store(const PreparedView& view, std::span<FaceId> ivm) {
  const auto width = static_cast<std::size_t>(box_.x1 - box_.x0);
  const auto stride = static_cast<std::size_t>(view.camera.width);
  for (std::int32_t y = box_.y0; y < box_.y1; ++y) {
    const std::uint32_t* owners = owners_.data() + static_cast<std::size_t>(y - box_.y0) * kSide;
    FaceId* to = ivm.data() + static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(box_.x0);
    for (std::size_t x = 0; x < width; ++x) {
      stored_[owners[x]] = 1;
      to[x] = faces_[owners[x]];
    }
  }
}

void IvmTile::add_to(DrawnFaces& drawn) const {
  for (std::size_t number = 1; number < faces_.size(); ++number) {
    const Entry& entry = entries_[number];
    const auto marks = static_cast<std::uint8_t>(entry.marks | (lost_[number] != 0 ? kMarkLost : 0) |
                                                 (stored_[number] != 0 ? kMarkStored : 0));
    std::uint8_t& all_marks = drawn.marks[index(faces_[number])];
    std::uint32_t& all_samples = drawn.samples[index(faces_[number])];
    if (!entry.shared) {
      all_marks = marks;
      all_samples = entry.samples;
      continue;
    }
    std::atomic_ref(all_marks).fetch_or(marks, std::memory_order_relaxed);
    std::atomic_ref(all_samples).fetch_add(entry.samples, std::memory_order_relaxed);
  }
}

}  // namespace gpvc::visibility
