#include "visibility/classify/subpixel_tile.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "visibility/raster/exact.h"
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

/// The samples as the kernels read them. Positions are relative to the corner of the samples' bounding box.
struct SubpixelTile::Grid {
  const float *x, *y;
  const FaceId* faces;
  const std::uint32_t* first;
  std::int32_t columns, rows;
  float columns_per_px, rows_per_px;
  float width, height, origin;  ///< of the bounding box; origin: the larger coordinate of its corner
  double row_height;
};

/// Eight faces, a lane each, and which samples each may cover.
struct SubpixelTile::Batch {
  float x[3][kLanes], y[3][kLanes];  ///< corners, relative to the corner of the bounding box; NaN behind the camera

  float a[3][kLanes], b[3][kLanes], c[3][kLanes];  ///< a x + b y + c >= 0 for every sample that the face covers
  float left[kLanes], right[kLanes];               ///< and left <= x <= right
  std::int32_t first_row[kLanes], last_row[kLanes], first_column[kLanes], last_column[kLanes];
  std::int32_t sure[kLanes];  ///< 0: prepare_lane() has to set all of that

  void prepare(const Grid& grid);
  std::size_t find(const Grid& grid, std::size_t lane, FaceId face, std::uint32_t* found) const;
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
/// The area, which is the value at the third corner, is off by less.
GPVC_WIDE_CLONES void SubpixelTile::Batch::prepare(const Grid& grid) {
  const EightFloats zero{};
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
  EightFloats reach = zero + std::max(grid.width, grid.height);
  raise(reach, high_x);
  raise(reach, high_y);
  raise(reach, -low_x);
  raise(reach, -low_y);
  const EightFloats off = 0x1p-23F * reach + 0x1p-51F * grid.origin;
  const EightFloats slack = 16 * off * ((high_x - low_x) + (high_y - low_y) + 4 * off);

  const EightFloats area = (px[1] - px[0]) * (py[2] - py[0]) - (py[1] - py[0]) * (px[2] - px[0]);
  // No product overflows; a corner that is NaN makes the area NaN.
  const EightInts certain = (reach < 0x1p40F) & ((area > slack) | (area < -slack));
  const EightFloats turn = area < 0 ? zero - 1 : zero + 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = i == 2 ? 0 : i + 1;
    const EightFloats of_a = turn * (py[i] - py[j]), of_b = turn * (px[j] - px[i]);
    store(of_a, a[i]);
    store(of_b, b[i]);
    store(slack - (of_a * px[i] + of_b * py[i]), c[i]);
  }
  low_x -= 3 * off;
  low_y -= 3 * off;
  high_x += 3 * off;
  high_y += 3 * off;
  const EightInts missed = (high_x < 0) | (high_y < 0) | (low_x > grid.width) | (low_y > grid.height);
  EightInts columns[2], rows[2];
  find_cells(low_x, grid.columns_per_px, grid.columns, columns[0]);
  find_cells(high_x, grid.columns_per_px, grid.columns, columns[1]);
  find_cells(low_y, grid.rows_per_px, grid.rows, rows[0]);
  find_cells(high_y, grid.rows_per_px, grid.rows, rows[1]);
  store(low_x, left);
  store(high_x, right);
  store(columns[0], first_column);
  store(columns[1], last_column);
  store(rows[0], first_row);
  store(missed ? rows[0] - 1 : rows[1], last_row);
  store(certain, sure);
}

namespace {

/// Bounds on x from the lines of the half-planes: the least and the greatest x in the first row of cells, and how both
/// change from row to row. A line that does not bound a side has an infinity there; one that overflows becomes NaN,
/// which no comparison in find() selects. The half-planes already include the slack, and the same monotone cell_at()
/// places samples and bounds, so no tolerance is needed here.
struct RowEnds {
  std::array<double, 3> low, high, step;

  RowEnds(const HalfPlanes& planes, double top, double height) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
      const double per_a = 1 / planes.a[k], slope = -planes.b[k] * per_a;
      step[k] = slope * height;
      const double here = slope * top - planes.c[k] * per_a;
      low[k] = planes.a[k] > 0 ? here + std::min(step[k], 0.0) : -kNever;
      high[k] = planes.a[k] < 0 ? here + std::max(step[k], 0.0) : kNever;
    }
  }
};

}  // namespace

/// Writes the numbers of the samples of other faces that lie in the half-planes of one lane; returns how many. Reads
/// whole runs of cells: scalar code would be
///
///     for each row of cells that the face touches
///       for each sample of its cells from left to right
///         if (id != face && e0 >= 0 && e1 >= 0 && e2 >= 0) found[count++] = sample
GPVC_WIDE_CLONES std::size_t SubpixelTile::Batch::find(const Grid& grid, std::size_t lane, FaceId face,
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
      std::memcpy(&px, grid.x + i, sizeof(px));
      std::memcpy(&py, grid.y + i, sizeof(py));
      std::memcpy(&id, grid.faces + i, sizeof(id));
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
  const std::uint32_t* cells = grid.first + static_cast<std::ptrdiff_t>(from) * grid.columns;
  const std::int32_t low_column = first_column[lane], high_column = last_column[lane];
  if (high_column - low_column < kManyColumns) {
    for (std::int32_t row = from; row <= to; ++row, cells += grid.columns)
      look(cells[low_column], cells[high_column + 1]);
    return count;
  }
  const RowEnds ends({{a[0][lane], a[1][lane], a[2][lane]},
                      {b[0][lane], b[1][lane], b[2][lane]},
                      {c[0][lane], c[1][lane], c[2][lane]}},
                     from * grid.row_height, grid.row_height);
  for (std::int32_t row = from; row <= to; ++row, cells += grid.columns) {
    const double rows = row - from;
    double low = left[lane], high = right[lane];
    for (std::size_t k = 0; k < 3; ++k) {
      low = std::max(low, ends.low[k] + rows * ends.step[k]);
      high = std::min(high, ends.high[k] + rows * ends.step[k]);
    }
    if (!(low <= high)) continue;
    look(cells[cell_at(low, grid.columns_per_px, grid.columns)],
         cells[cell_at(high, grid.columns_per_px, grid.columns) + 1]);
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
    return order < 0 || (order == 0 && face < sampled);
  }

  const PreparedView& view;
  FaceId face;
  QuickFace quick;
  DepthRange depths;
  bool exact = false;  ///< raster is set
  RasterFace raster;
};

void SubpixelTile::grow() {
  const std::size_t most = std::max<std::size_t>(2 * x_.size(), 4096);
  x_.resize(most);
  y_.resize(most);
  faces_.resize(most);
}

void SubpixelTile::lay_grid() {
  left_ = x_[0];
  top_ = y_[0];
  double right = left_, bottom = top_;
  for (std::size_t i = 1; i < count_; ++i) {
    left_ = std::min(left_, x_[i]);
    right = std::max(right, x_[i]);
    top_ = std::min(top_, y_[i]);
    bottom = std::max(bottom, y_[i]);
  }
  width_ = right - left_;
  height_ = bottom - top_;
  // Even a narrow rectangle gets no more cells than samples.
  const double per_cell = kSamplesPerCell / static_cast<double>(count_);
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
  visible_.assign(count_, 1);
  if (count_ == 0) return;
  lay_grid();
  cells_.resize(count_);
  first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (std::size_t i = 0; i < count_; ++i) {
    cells_[i] = static_cast<std::uint32_t>(cell_at(y_[i] - top_, rows_per_px_, rows_) * columns_ +
                                           cell_at(x_[i] - left_, columns_per_px_, columns_));
    ++first_[cells_[i]];
  }
  // Prefix sums are the ends of the cells; they become the beginnings as samples are inserted backwards.
  for (std::size_t cell = 1; cell < first_.size(); ++cell) first_[cell] += first_[cell - 1];
  local_x_.resize(count_ + kLanes);
  local_y_.resize(count_ + kLanes);
  by_cell_.resize(count_ + kLanes);
  added_.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::uint32_t at = --first_[cells_[i]];
    local_x_[at] = static_cast<float>(x_[i] - left_);
    local_y_[at] = static_cast<float>(y_[i] - top_);
    by_cell_[at] = faces_[i];
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

/// What prepare() does, in doubles, for a face that floats are not sure about.
void SubpixelTile::prepare_lane(const PreparedView& view, FaceId face, std::size_t lane, Batch& batch) const {
  const FaceBounds bounds = view.bounds(face);
  double x0 = 0, x1 = width_, y0 = 0, y1 = height_;
  if (bounds.bounded) {
    x0 = bounds.x0 - left_;
    x1 = bounds.x1 - left_;
    y0 = bounds.y0 - top_;
    y1 = bounds.y1 - top_;
  }
  const HalfPlanes planes = view.quick(face, bounds).half_planes(left_, top_, std::max(width_, height_));
  for (std::size_t k = 0; k < 3; ++k) {
    batch.a[k][lane] = static_cast<float>(planes.a[k]);
    batch.b[k][lane] = static_cast<float>(planes.b[k]);
    batch.c[k][lane] = static_cast<float>(planes.c[k]);
  }
  batch.left[lane] = static_cast<float>(x0);
  batch.right[lane] = static_cast<float>(x1);
  batch.first_row[lane] = cell_at(y0, rows_per_px_, rows_);
  batch.last_row[lane] = cell_at(y1, rows_per_px_, rows_);
  batch.first_column[lane] = cell_at(x0, columns_per_px_, columns_);
  batch.last_column[lane] = cell_at(x1, columns_per_px_, columns_);
  if (x1 < 0 || y1 < 0 || x0 > width_ || y0 > height_) batch.last_row[lane] = batch.first_row[lane] - 1;
}

void SubpixelTile::hide_found(const PreparedView& view, FaceId face, std::span<const std::uint32_t> found) {
  Occluder occluder{view, face, view.quick(face, view.bounds(face)), view.depths(face), false, {}};
  for (const std::uint32_t i : found) {
    const std::uint32_t sample = added_[i];
    std::atomic_ref visible(visible_[sample]);
    if (visible.load(std::memory_order_relaxed) == 0) continue;
    if (occluder.hides(x_[sample], y_[sample], faces_[sample])) visible.store(0, std::memory_order_relaxed);
  }
}

void SubpixelTile::hide_behind(const PreparedView& view, std::span<const FaceId> faces, Found& found) {
  if (count_ == 0) return;
  if (found.size() < count_ + kLanes) found.resize(count_ + kLanes);
  const Grid grid{local_x_.data(),
                  local_y_.data(),
                  by_cell_.data(),
                  first_.data(),
                  columns_,
                  rows_,
                  columns_per_px_,
                  rows_per_px_,
                  static_cast<float>(width_),
                  static_cast<float>(height_),
                  static_cast<float>(std::max(left_, top_)),
                  height_ / rows_};
  Batch batch;
  for (; !faces.empty(); faces = faces.subspan(std::min<std::size_t>(kLanes, faces.size()))) {
    gather(view, faces, batch);
    batch.prepare(grid);
    for (std::size_t lane = 0; lane < std::min<std::size_t>(kLanes, faces.size()); ++lane) {
      if (batch.sure[lane] == 0) prepare_lane(view, faces[lane], lane, batch);
      if (batch.first_row[lane] > batch.last_row[lane]) continue;
      const std::size_t count = batch.find(grid, lane, faces[lane], found.data());
      if (count != 0) hide_found(view, faces[lane], std::span(found).first(count));
    }
  }
}

}  // namespace gpvc::visibility
