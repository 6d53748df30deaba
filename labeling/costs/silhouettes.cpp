#include "labeling/costs/silhouettes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kWordBits = 64;

void set(std::vector<std::uint64_t>& bits, std::uint32_t x) {
  bits[x / kWordBits] |= std::uint64_t{1} << (x % kWordBits);
}

/// A bit for each of the first `count` <= 64 faces, set where the two rows differ. Comparisons become bytes, which the
/// compiler vectorizes, and eight bytes of 0 or 1 become bits by a product: byte i times 2^(56 - 7 i) is bit 56 + i, and no
/// two of the other partial products fall on one bit.
std::uint64_t differences(const FaceId* a, const FaceId* b, std::size_t count) {
  static_assert(std::endian::native == std::endian::little);
  std::array<std::uint8_t, kWordBits> differs{};
  if (count == kWordBits) {
    for (std::size_t i = 0; i < kWordBits; ++i) differs[i] = a[i] != b[i] ? 1 : 0;
  } else {
    for (std::size_t i = 0; i < count; ++i) differs[i] = a[i] != b[i] ? 1 : 0;
  }
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < kWordBits; i += 8) {
    std::uint64_t bytes;
    std::memcpy(&bytes, differs.data() + i, sizeof(bytes));
    bits |= (bytes * 0x0102040810204080u >> 56) << i;
  }
  return bits;
}

/// Calls visit(x) for every x, ascending, where the two rows of `width` faces differ.
template <class Visit>
void for_each_difference(const FaceId* a, const FaceId* b, std::size_t width, Visit visit) {
  for (std::size_t from = 0; from < width; from += kWordBits)
    for (std::uint64_t bits = differences(a + from, b + from, std::min<std::size_t>(kWordBits, width - from));
         bits != 0; bits &= bits - 1)
      visit(static_cast<std::uint32_t>(from) + static_cast<std::uint32_t>(std::countr_zero(bits)));
}

/// Every bit also sets the `count` bits above it; bits beyond the last word are lost. `count` is at most 63.
void spread_up(std::vector<std::uint64_t>& bits, int count) {
  for (std::size_t i = bits.size() - 1; i > 0; --i)
    bits[i] |= bits[i] << count | bits[i - 1] >> (static_cast<int>(kWordBits) - count);
  bits[0] |= bits[0] << count;
}

/// The same downwards.
void spread_down(std::vector<std::uint64_t>& bits, int count) {
  for (std::size_t i = 0; i + 1 < bits.size(); ++i)
    bits[i] |= bits[i] >> count | bits[i + 1] << (static_cast<int>(kWordBits) - count);
  bits.back() |= bits.back() >> count;
}

}  // namespace

CameraTriangle camera_corners(const Mesh& mesh, std::size_t face, const Pose& pose) {
  CameraTriangle corners;
  for (std::size_t i = 0; i < 3; ++i) corners[i] = camera_from_world(pose, mesh.positions[mesh.faces[face][i]]);
  return corners;
}

CameraPoint area_normal(const CameraTriangle& corners) {
  const auto& [a, b, c] = corners;
  const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
  const double vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
  return {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
}

InverseDepth inverse_depth(const Camera& camera, const CameraTriangle& corners) {
  const CameraPoint n = area_normal(corners);
  const CameraPoint& a = corners[0];
  const double offset = n.x * a.x + n.y * a.y + n.z * a.z;  // n . X = offset, X = z (u, v, 1)
  if (offset == 0) return {};
  return {static_cast<float>(n.x / (offset * camera.fx)), static_cast<float>(n.y / (offset * camera.fy)),
          static_cast<float>(n.z / offset)};
}

void FaceRuns::find(std::span<const FaceId> row) {
  const std::size_t width = row.size();
  begins.resize(width + 1);
  std::size_t runs = 1;
  begins[0] = 0;
  for_each_difference(row.data() + 1, row.data(), width - 1, [&](std::uint32_t x) { begins[runs++] = x + 1; });
  begins[runs] = static_cast<std::uint32_t>(width);
  begins.resize(runs + 1);
  faces.resize(runs);
  // Stores more than a run has pixels, which the next run overwrites: most runs are short, of a length that cannot be
  // predicted.
  constexpr std::size_t kAtOnce = 16;
  of_pixel.resize(width + kAtOnce);
  for (std::size_t i = 0; i < runs; ++i) {
    faces[i] = row[begins[i]];
    for (std::size_t x = begins[i]; x < begins[i + 1]; x += kAtOnce)
      std::fill_n(of_pixel.begin() + static_cast<std::ptrdiff_t>(x), kAtOnce, static_cast<std::uint32_t>(i));
  }
}

Silhouettes::Silhouettes(const Camera& camera, const visibility::Ivm& ivm, int margin_px)
    : camera_(camera),
      ivm_(ivm),
      margin_px_(margin_px),
      footprints_(static_cast<float>(margin_px / std::sqrt(camera.fx * camera.fy))) {
  for (int x = 0; x < ivm.width; ++x) centred_columns_.push_back(static_cast<float>(x + 0.5 - camera.cx));
}

std::span<const FaceId> Silhouettes::row(int y) const {
  const auto width = static_cast<std::size_t>(ivm_.width);
  return {ivm_.faces.data() + static_cast<std::size_t>(y) * width, width};
}

float Silhouettes::centred_row(int y) const { return static_cast<float>(y + 0.5 - camera_.cy); }

/// True if two neighbouring pixels lie across a discontinuity.
inline bool Silhouettes::is_step(const Shown& a, const Shown& b) const {
  if (a.face == kNoFace) return in_photo(camera_, {a.x + 0.5, a.y + 0.5});
  if (b.face == kNoFace) return in_photo(camera_, {b.x + 0.5, b.y + 0.5});
  const float x0 = centred_columns_[a.x], y0 = centred_row(a.y);
  const float x1 = centred_columns_[b.x], y1 = centred_row(b.y);
  const float gap0 = a.plane.at(x0, y0) - b.plane.at(x0, y0);
  const float gap1 = a.plane.at(x1, y1) - b.plane.at(x1, y1);
  // |1/wa - 1/wb| > margin / (f w_near)  <=>  |wa - wb| > margin / f * w_far
  const float far = std::min(a.plane.at(x0, y0), b.plane.at(x1, y1));
  // Few pairs pass the first test, while the signs of small gaps cannot be predicted.
  return std::min(std::abs(gap0), std::abs(gap1)) > footprints_ * far && (gap0 > 0) == (gap1 > 0);
}

void StripRows::start(const Silhouettes& silhouettes, int begin, int end, FindFaces find_faces) {
  find_faces_ = std::move(find_faces);
  of_ = &silhouettes;
  const int height = silhouettes.ivm_.height, margin = silhouettes.margin_px_;
  y_ = begin - 1;
  end_ = end;
  first_ = std::max(0, begin - margin);
  last_ = std::min(height - 1, end - 1 + margin);
  loaded_ = first_ - 1;
  rows_.resize(static_cast<std::size_t>(std::max(2, std::min(2 * margin, height))));
  strip_.resize(margin > 0 ? (static_cast<std::size_t>(silhouettes.ivm_.width) + kWordBits - 1) / kWordBits : 0);
}

bool StripRows::next() {
  if (++y_ >= end_) return false;
  while (loaded_ < std::min(y_ + of_->margin_px_, last_)) load(++loaded_);
  if (of_->margin_px_ > 0) unite();
  return true;
}

void StripRows::load(int y) {
  Row& here = row(y);
  here.runs.find(of_->row(y));
  find_faces(y);
  if (of_->margin_px_ == 0) return;
  here.marks.assign(strip_.size(), 0);
  mark_steps_in_row(y);
  if (y > first_) {
    mark_steps_below(y - 1);
    widen(row(y - 1).marks);
  }
  if (y + 1 == of_->ivm_.height) widen(here.marks);
}

/// Most runs continue one of the row above, which spares looking the face up in memory that is far apart.
void StripRows::find_faces(int y) {
  Row& here = row(y);
  const FaceRuns& runs = here.runs;
  here.found.resize(runs.faces.size());
  if (y == first_) {
    find_faces_(runs.faces, here.found);
    return;
  }
  const Row& above = row(y - 1);
  runs_.resize(runs.faces.size() + 1);
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < runs.faces.size(); ++i) {
    const std::uint32_t run_above = above.runs.of_pixel[runs.begins[i]];
    here.found[i] = above.found[run_above];
    runs_[count] = i;
    count += above.runs.faces[run_above] != runs.faces[i] ? 1 : 0;
  }
  faces_.resize(count);
  found_.resize(count);
  for (std::size_t i = 0; i < count; ++i) faces_[i] = runs.faces[runs_[i]];
  find_faces_(faces_, found_);
  for (std::size_t i = 0; i < count; ++i) here.found[runs_[i]] = found_[i];
}

void StripRows::mark_steps_in_row(int y) {
  Row& here = row(y);
  const FaceRuns& runs = here.runs;
  for (std::size_t i = 1; i < runs.faces.size(); ++i) {
    const std::uint32_t x = runs.begins[i];
    if (!of_->is_step({runs.faces[i - 1], here.found[i - 1].plane, x - 1, y},
                      {runs.faces[i], here.found[i].plane, x, y}))
      continue;
    set(here.marks, x - 1);
    set(here.marks, x);
  }
}

/// Between a row and the next one.
void StripRows::mark_steps_below(int y) {
  Row &above = row(y), &below = row(y + 1);
  const std::span<const FaceId> faces_above = of_->row(y), faces_below = of_->row(y + 1);
  for_each_difference(faces_above.data(), faces_below.data(), faces_above.size(), [&](std::uint32_t x) {
    if (!of_->is_step({faces_above[x], above.found[above.runs.of_pixel[x]].plane, x, y},
                      {faces_below[x], below.found[below.runs.of_pixel[x]].plane, x, y + 1}))
      return;
    set(above.marks, x);
    set(below.marks, x);
  });
}

/// Grows the marks by margin_px - 1 pixels to the left and to the right: pixels that touch a step are within one pixel of
/// it. Doubling the length of runs takes few passes.
void StripRows::widen(std::vector<std::uint64_t>& marks) {
  if (std::all_of(marks.begin(), marks.end(), [](std::uint64_t word) { return word == 0; })) return;
  work_ = marks;
  const int length = of_->margin_px_;
  for (int done = 1; done < length;) {
    const int step = std::min({done, length - done, static_cast<int>(kWordBits) - 1});
    spread_up(marks, step);
    spread_down(work_, step);
    done += step;
  }
  for (std::size_t i = 0; i < marks.size(); ++i) marks[i] |= work_[i];
}

/// Grows the marks in the same way up and down.
void StripRows::unite() {
  const int reach = of_->margin_px_ - 1;
  std::fill(strip_.begin(), strip_.end(), std::uint64_t{0});
  for (int y = std::max(first_, y_ - reach); y <= std::min(of_->ivm_.height - 1, y_ + reach); ++y) {
    const std::vector<std::uint64_t>& marks = row(y).marks;
    for (std::size_t i = 0; i < strip_.size(); ++i) strip_[i] |= marks[i];
  }
}

}  // namespace gpvc::labeling
