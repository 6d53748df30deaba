#include "visibility/classify/subpixel_tile.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/wide_clones.h"
#include "visibility/raster/exact.h"
#include "visibility/raster/row_crossings.h"
#include "visibility/raster/wide.h"

namespace gpvc::visibility {
namespace {

/// Fewer samples a cell make more runs a face, more make longer runs; between 1 and 4 the time is much the same.
constexpr double kSamplesPerCell = 3;
/// Faces that are prepared at once, and samples that find() reads at once; it may read that many beyond the last.
constexpr std::uint32_t kLanes = 8;
/// For a face over at least this many columns of cells find() computes where its edges cross the rows; over fewer it is
/// faster to read whole rows.
constexpr std::int32_t kManyColumns = 8;

/// The column or row of cells of a position. Monotone in the position, whatever the rounding.
std::int32_t cell_at(double position, float per_px, std::int32_t cells) {
  const float cell = static_cast<float>(position) * per_px;
  return static_cast<std::int32_t>(std::clamp(cell, 0.0F, static_cast<float>(cells - 1)));
}

}  // namespace

/// Eight faces, a lane each, and which samples each may cover.
struct SubpixelTile::Batch {
  float x[3][kLanes], y[3][kLanes];  ///< corners, relative to the corner of the bounding box; NaN behind the camera

  float a[3][kLanes], b[3][kLanes], c[3][kLanes];  ///< a x + b y + c >= 0 for every sample that the face covers
  float left[kLanes], right[kLanes];               ///< and left <= x <= right
  std::int32_t first_row[kLanes], last_row[kLanes], first_column[kLanes], last_column[kLanes];

  void prepare(const SubpixelTile& tile);
  std::size_t find(const SubpixelTile& tile, std::size_t lane, FaceId face, std::uint32_t* found) const;
};

namespace {

// Vectors go in and out by reference: returned by value they would depend on the processor that a caller is compiled
// for.

/// Eight floats of a batch, one a face.
[[gnu::always_inline]] inline void load(const float (&from)[kLanes], EightFloats& lanes) {
  std::memcpy(&lanes, from, sizeof(lanes));
}
[[gnu::always_inline]] inline void store(const EightFloats& lanes, float (&to)[kLanes]) {
  std::memcpy(to, &lanes, sizeof(lanes));
}
[[gnu::always_inline]] inline void store(const EightInts& lanes, std::int32_t (&to)[kLanes]) {
  std::memcpy(to, &lanes, sizeof(lanes));
}
[[gnu::always_inline]] inline void lower(EightFloats& least, const EightFloats& value) {
  least = value < least ? value : least;
}
[[gnu::always_inline]] inline void raise(EightFloats& greatest, const EightFloats& value) {
  greatest = greatest < value ? value : greatest;
}
/// The cells along one axis of positions, clamped to the grid.
[[gnu::always_inline]] inline void find_cells(const EightFloats& position, float cells_per_px, std::int32_t cells,
                                              EightInts& found) {
  const EightFloats zero{};
  EightFloats cell = position * cells_per_px;
  lower(cell, zero + static_cast<float>(cells - 1));
  found = __builtin_convertvector(cell > 0 ? cell : zero, EightInts);
}

}  // namespace

/// The half-planes of each face, in floats. Per lane, with the corners X[k], Y[k]:
///
///     area = (X1 - X0) (Y2 - Y0) - (Y1 - Y0) (X2 - X0),      turn = its sign
///     edge i -> j:    a = turn (Yi - Yj),   b = turn (Xj - Xi),   c = slack - (a Xi + b Yi)
///
/// The slack. With r = 2^-24, R the largest size of a coordinate of the corners and of the samples here, O that of the
/// bounding box's corner, and w the width plus the height of a face:
///
///     d = 2 r R + 2^-51 O     rounding of a coordinate to float, and before that of quotient and difference in double
///     |a| + |b|               <= w + 2 d
///     3 d (w + 4 d)           error of a (x - X) + b (y - Y) from a and b
///     2 d (w + 2 d)           error of it from x and y
///     7 r R (|a| + |b|)       evaluating it as a x + b y + c in floats
///     3 r R |b|               samples that rounding has put into the next row of cells
///     11 d (w + 4 d)          above the sum; the slack is 16 d (w + 4 d)
///
/// The area, which is the value at the third corner, is off by less. Where it does not exceed the slack the half-planes
/// hold everywhere, and all samples in the bounding box are found; all samples of the tile, where a corner behind the
/// camera leaves no bounding box.
GPVC_WIDE_CLONES void SubpixelTile::Batch::prepare(const SubpixelTile& tile) {
  const EightFloats zero{};
  const auto width = static_cast<float>(tile.width_), height = static_cast<float>(tile.height_);
  EightFloats px[3], py[3];
  for (std::size_t k = 0; k < 3; ++k) {
    load(x[k], px[k]);
    load(y[k], py[k]);
  }
  EightFloats low_x = px[0], high_x = px[0], low_y = py[0], high_y = py[0];
  for (std::size_t k = 1; k < 3; ++k) {
    lower(low_x, px[k]);
    raise(high_x, px[k]);
    lower(low_y, py[k]);
    raise(high_y, py[k]);
  }
  EightFloats reach = zero + std::max(width, height);
  raise(reach, high_x);
  raise(reach, high_y);
  raise(reach, -low_x);
  raise(reach, -low_y);
  const EightFloats off = 0x1p-23F * reach + 0x1p-51F * static_cast<float>(std::max(tile.left_, tile.top_));
  const EightFloats slack = 16 * off * ((high_x - low_x) + (high_y - low_y) + 4 * off);

  const EightFloats area = (px[1] - px[0]) * (py[2] - py[0]) - (py[1] - py[0]) * (px[2] - px[0]);
  // No product overflows; a corner that is NaN makes the area NaN.
  const EightInts certain = (reach < 0x1p40F) & ((area > slack) | (area < -slack));
  const EightFloats turn = area < 0 ? zero - 1 : zero + 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = i == 2 ? 0 : i + 1;
    const EightFloats of_a = turn * (py[i] - py[j]), of_b = turn * (px[j] - px[i]);
    store(certain ? of_a : zero, a[i]);
    store(certain ? of_b : zero, b[i]);
    store(certain ? slack - (of_a * px[i] + of_b * py[i]) : zero, c[i]);
  }
  const EightInts bounded = area == area;
  low_x = bounded ? low_x - 3 * off : zero;
  low_y = bounded ? low_y - 3 * off : zero;
  high_x = bounded ? high_x + 3 * off : zero + width;
  high_y = bounded ? high_y + 3 * off : zero + height;
  const EightInts missed = (high_x < 0) | (high_y < 0) | (low_x > width) | (low_y > height);
  EightInts columns[2], rows[2];
  find_cells(low_x, tile.columns_per_px_, tile.columns_, columns[0]);
  find_cells(high_x, tile.columns_per_px_, tile.columns_, columns[1]);
  find_cells(low_y, tile.rows_per_px_, tile.rows_, rows[0]);
  find_cells(high_y, tile.rows_per_px_, tile.rows_, rows[1]);
  store(low_x, left);
  store(high_x, right);
  store(columns[0], first_column);
  store(columns[1], last_column);
  store(rows[0], first_row);
  store(missed ? rows[0] - 1 : rows[1], last_row);
}

/// Writes the numbers of the samples of other faces that lie in the half-planes of one lane; returns how many. Reads
/// whole runs of cells: scalar code would be
///
///     for each row of cells that the face touches
///       for each sample of its cells from left to right
///         if (id != face && e0 >= 0 && e1 >= 0 && e2 >= 0) found[count++] = sample
GPVC_WIDE_CLONES std::size_t SubpixelTile::Batch::find(const SubpixelTile& tile, std::size_t lane, FaceId face,
                                                       std::uint32_t* found) const {
  const EightFloats zero{};
  const EightFloats a0 = zero + a[0][lane], b0 = zero + b[0][lane], c0 = zero + c[0][lane], a1 = zero + a[1][lane],
                    b1 = zero + b[1][lane], c1 = zero + c[1][lane], a2 = zero + a[2][lane], b2 = zero + b[2][lane],
                    c2 = zero + c[2][lane];
  const EightInts lanes{0, 1, 2, 3, 4, 5, 6, 7};
  std::size_t count = 0;
  const auto look = [&](std::uint32_t i, std::uint32_t end) {
    for (; i < end; i += kLanes) {
      EightFloats px, py;
      EightIds id;
      std::memcpy(&px, tile.local_x_.data() + i, sizeof(px));
      std::memcpy(&py, tile.local_y_.data() + i, sizeof(py));
      std::memcpy(&id, tile.by_cell_.data() + i, sizeof(id));
      const EightFloats e0 = a0 * px + b0 * py + c0, e1 = a1 * px + b1 * py + c1, e2 = a2 * px + b2 * py + c2;
      const EightInts in = (e0 >= 0) & (e1 >= 0) & (e2 >= 0) & (lanes < static_cast<std::int32_t>(end - i)) &
                           reinterpret_cast<EightInts>(id != static_cast<std::uint32_t>(face));
      const auto pairs = reinterpret_cast<FourFlags>(in);
      if (((pairs[0] | pairs[1]) | (pairs[2] | pairs[3])) == 0) continue;
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        found[count] = i + k;
        count += in[k] != 0;
      }
    }
  };
  const std::int32_t from = first_row[lane], to = last_row[lane];
  const std::uint32_t* cells = tile.first_.data() + static_cast<std::ptrdiff_t>(from) * tile.columns_;
  const std::int32_t low_column = first_column[lane], high_column = last_column[lane];
  if (high_column - low_column < kManyColumns) {
    for (std::int32_t row = from; row <= to; ++row, cells += tile.columns_)
      look(cells[low_column], cells[high_column + 1]);
    return count;
  }
  // The half-planes include the slack, and the same monotone cell_at() places samples and bounds: no tolerance is needed.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double row_height = tile.height_ / tile.rows_;
  RowCrossings edges{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double of_a = a[k][lane], per_a = 1 / of_a, slope = -b[k][lane] * per_a;
    edges.at[k] = slope * (from * row_height) - c[k][lane] * per_a;
    edges.slope[k] = slope * row_height;
    edges.not_left[k] = of_a > 0 ? 0 : -kNever;
    edges.not_right[k] = of_a < 0 ? 0 : kNever;
  }
  for (std::int32_t row = from; row <= to; ++row, cells += tile.columns_) {
    const RowRange range = range_of_rows(edges, row - from, row - from + 1);
    const double low = std::max<double>(left[lane], range.low), high = std::min<double>(right[lane], range.high);
    if (!(low <= high)) continue;
    look(cells[cell_at(low, tile.columns_per_px_, tile.columns_)],
         cells[cell_at(high, tile.columns_per_px_, tile.columns_) + 1]);
  }
  return count;
}

/// A face that may hide samples; its raster face is computed when an exact predicate first needs it.
struct SubpixelTile::Occluder {
  /// True when it covers the sample of another face and is nearer there.
  bool hides(double x, double y, FaceId sampled) {
    const DepthRange other = view.depths(sampled);
    if (depths.nearest > other.farthest) return false;
    if (depths.farthest < other.nearest && quick.contains(x, y)) return true;
    if (!exact) raster = view.raster(face);
    exact = true;
    if (raster.facing == Facing::edge_on) return false;
    const FacePoint here = face_point(raster, x, y);
    if (!covers_exactly(here)) return false;
    const int order = compare_depth_exactly(here, face_point(view.raster(sampled), x, y));
    return order < 0 ||
           (order == 0 && precedes_at_equal_depth(raster.facing, face, view.raster(sampled).facing, sampled));
  }

  const PreparedView& view;
  FaceId face;
  QuickFace quick;
  DepthRange depths;
  bool exact = false;  ///< raster is set
  RasterFace raster;
};

void SubpixelTile::lay_grid() {
  left_ = samples_[0].x;
  top_ = samples_[0].y;
  double right = left_, bottom = top_;
  for (const Sample& sample : samples_) {
    left_ = std::min(left_, sample.x);
    right = std::max(right, sample.x);
    top_ = std::min(top_, sample.y);
    bottom = std::max(bottom, sample.y);
  }
  width_ = right - left_;
  height_ = bottom - top_;
  // Even a narrow rectangle gets no more cells than samples.
  const double per_cell = kSamplesPerCell / static_cast<double>(samples_.size());
  const double side = std::max(std::sqrt(width_ * height_ * per_cell), std::max(width_, height_) * per_cell);
  const auto cells = [side](double length) { return side > 0 ? 1 + static_cast<std::int32_t>(length / side) : 1; };
  columns_ = cells(width_);
  rows_ = cells(height_);
  const auto per_px = [](std::int32_t all, double length) {
    return length > 0 ? std::min(static_cast<float>(all / length), std::numeric_limits<float>::max()) : 0.0F;
  };
  columns_per_px_ = per_px(columns_, width_);
  rows_per_px_ = per_px(rows_, height_);
}

void SubpixelTile::sort() {
  const std::size_t count = samples_.size();
  visible_.assign(count, 1);
  if (count == 0) return;
  lay_grid();
  cells_.resize(count);
  first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    cells_[i] = static_cast<std::uint32_t>(cell_at(samples_[i].y - top_, rows_per_px_, rows_) * columns_ +
                                           cell_at(samples_[i].x - left_, columns_per_px_, columns_));
    ++first_[cells_[i]];
  }
  // Prefix sums are the ends of the cells; they become the beginnings as samples are inserted backwards.
  for (std::size_t cell = 1; cell < first_.size(); ++cell) first_[cell] += first_[cell - 1];
  local_x_.resize(count + kLanes);
  local_y_.resize(count + kLanes);
  by_cell_.resize(count + kLanes);
  added_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t at = --first_[cells_[i]];
    local_x_[at] = static_cast<float>(samples_[i].x - left_);
    local_y_[at] = static_cast<float>(samples_[i].y - top_);
    by_cell_[at] = samples_[i].face;
    added_[at] = static_cast<std::uint32_t>(i);
  }
}

/// The corners of up to kLanes faces; lanes beyond repeat the last face.
void SubpixelTile::gather(const PreparedView& view, std::span<const FaceId> faces, Batch& batch) const {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const Triangle& t = view.mesh.faces[index(faces[std::min(lane, faces.size() - 1)])];
    for (std::size_t k = 0; k < 3; ++k) {
      const RoundedPosition& p = view.projected.positions[t[k]];
      batch.x[k][lane] = static_cast<float>(p.x - left_);
      batch.y[k][lane] = static_cast<float>(p.y - top_);
    }
  }
}

void SubpixelTile::hide_found(const PreparedView& view, FaceId face, std::span<const std::uint32_t> found) {
  Occluder occluder{view, face, view.quick(face, view.bounds(face)), view.depths(face), false, {}};
  for (const std::uint32_t i : found) {
    const Sample& sample = samples_[added_[i]];
    std::atomic_ref visible(visible_[added_[i]]);
    if (visible.load(std::memory_order_relaxed) == 0) continue;
    if (occluder.hides(sample.x, sample.y, sample.face)) visible.store(0, std::memory_order_relaxed);
  }
}

void SubpixelTile::hide_behind(const PreparedView& view, std::span<const FaceId> faces, Found& found) {
  if (samples_.empty()) return;
  if (found.size() < samples_.size() + kLanes) found.resize(samples_.size() + kLanes);
  Batch batch;
  for (; !faces.empty(); faces = faces.subspan(std::min<std::size_t>(kLanes, faces.size()))) {
    gather(view, faces, batch);
    batch.prepare(*this);
    for (std::size_t lane = 0; lane < std::min<std::size_t>(kLanes, faces.size()); ++lane) {
      if (batch.first_row[lane] > batch.last_row[lane]) continue;
      const std::size_t count = batch.find(*this, lane, faces[lane], found.data());
      if (count != 0) hide_found(view, faces[lane], std::span(found).first(count));
    }
  }
}

}  // namespace gpvc::visibility
