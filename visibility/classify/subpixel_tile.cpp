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

/// Fewer make more runs a face, more make longer runs; between 1 and 4 the time is much the same.
constexpr double kSamplesPerCell = 3;
/// Samples that the kernel reads at once, and how many it may read beyond the last; faces that are made ready at once.
constexpr std::uint32_t kLanes = 8;
/// Of a face over so many columns of cells the kernel looks where its edges cross the rows; over fewer all of a row
/// takes it less time.
constexpr std::int32_t kManyColumns = 8;

/// Column or row of cells. Grows with the position, whatever the rounding.
std::int32_t cell_at(double position, float per_px, std::int32_t cells) {
  const float cell = static_cast<float>(position) * per_px;
  return static_cast<std::int32_t>(std::clamp(cell, 0.0F, static_cast<float>(cells - 1)));
}

GPVC_WIDE_CLONES void place_samples(const std::array<ProjectedVertex, 3>& v, double* x, double* y) {
  const FourDoubles all{1, 1, 1, 1};
  const FourDoubles u = all * (v[0].u + v[1].u + v[2].u) + 3 * FourDoubles{v[0].u, v[1].u, v[2].u, 0};
  const FourDoubles w = all * (v[0].v + v[1].v + v[2].v) + 3 * FourDoubles{v[0].v, v[1].v, v[2].v, 0};
  const FourDoubles z = all * (v[0].z + v[1].z + v[2].z) + 3 * FourDoubles{v[0].z, v[1].z, v[2].z, 0};
  const FourDoubles nowhere = FourDoubles{} + std::numeric_limits<double>::quiet_NaN();
  const FourDoubles px = z > 0 ? u / z : nowhere, py = w / z;
  std::memcpy(x, &px, sizeof(px));
  std::memcpy(y, &py, sizeof(py));
}

}  // namespace

SubpixelPositions subpixel_positions(const ClassifyView& view, FaceId face) {
  const Triangle& t = view.mesh.faces[index(face)];
  const auto& v = view.projected.vertices;
  SubpixelPositions samples;
  place_samples(nearest_first(v[t[0]], v[t[1]], v[t[2]]), samples.x.data(), samples.y.data());
  return samples;
}

/// What the kernels look through: positions are from the corner of the rectangle.
struct SubpixelTile::Grid {
  const float *x, *y;
  const FaceId* faces;
  const std::uint32_t* first;
  std::int32_t columns, rows;
  float columns_per_px, rows_per_px;
  float width, height, origin;  ///< of the rectangle; the larger coordinate of its corner
  double row_height;
};

/// Faces on their way to the samples that they may hide.
struct SubpixelTile::Batch {
  float x[3][kLanes], y[3][kLanes];  ///< corners, from the corner of the rectangle; NaN behind the camera

  float a[3][kLanes], b[3][kLanes], c[3][kLanes];  ///< half-planes that hold all samples they cover
  float left[kLanes], right[kLanes];               ///< like these
  std::int32_t first_row[kLanes], last_row[kLanes], first_column[kLanes], last_column[kLanes];
  std::int32_t sure[kLanes];  ///< 0: all of that is to be found otherwise

  void prepare(const Grid& grid);
  std::size_t find(const Grid& grid, std::size_t lane, FaceId face, std::uint32_t* found) const;
};

/// With r = 2^-24, R the largest size of a coordinate of the corners and of the samples here and O that of the
/// rectangle's corner, all of these are off by less than d = 2 r R + 2^-51 O: rounded to floats, and before that as
/// quotients and differences of doubles. Let w be the width plus the height of a face, which has |a| + |b| <= w + 2 d
/// for each edge. At a sample that the face covers, a (x - X) + b (y - Y) with a corner (X, Y) of the edge is off by 3
/// d (w + 4 d) because a and b are, and by 2 d (w + 2 d) because x and y are. Taken as a x + b y + c in floats, with c
/// = -(a X + b Y), it is off by another 7 r R (|a| + |b|), and samples that rounding has put into the next row of cells
/// are off by as much as 3 r R |b| more: all in all by less than 11 d (w + 4 d). The area, the value at the third
/// corner, is off by less.
GPVC_WIDE_CLONES void SubpixelTile::Batch::prepare(const Grid& grid) {
  const EightFloats zero{};
  EightFloats px[3], py[3];
  std::memcpy(px, x, sizeof(px));
  std::memcpy(py, y, sizeof(py));
  EightFloats low_x = px[0] < px[1] ? px[0] : px[1], high_x = px[0] < px[1] ? px[1] : px[0];
  EightFloats low_y = py[0] < py[1] ? py[0] : py[1], high_y = py[0] < py[1] ? py[1] : py[0];
  low_x = low_x < px[2] ? low_x : px[2];
  high_x = high_x < px[2] ? px[2] : high_x;
  low_y = low_y < py[2] ? low_y : py[2];
  high_y = high_y < py[2] ? py[2] : high_y;
  EightFloats reach = zero + (grid.width < grid.height ? grid.height : grid.width);
  reach = reach < high_x ? high_x : reach;
  reach = reach < high_y ? high_y : reach;
  reach = reach < -low_x ? -low_x : reach;
  reach = reach < -low_y ? -low_y : reach;
  const EightFloats off = 0x1p-23F * reach + 0x1p-51F * grid.origin;
  const EightFloats slack = 16 * off * ((high_x - low_x) + (high_y - low_y) + 4 * off);

  const EightFloats area = (px[1] - px[0]) * (py[2] - py[0]) - (py[1] - py[0]) * (px[2] - px[0]);
  // No product overflows; corners that are NaN make the area NaN.
  const EightInts certain = (reach < 0x1p40F) & ((area > slack) | (area < -slack));
  const EightFloats turn = area < 0 ? zero - 1 : zero + 1;
  EightFloats of_a[3], of_b[3], of_c[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = i == 2 ? 0 : i + 1;
    of_a[i] = turn * (py[i] - py[j]);
    of_b[i] = turn * (px[j] - px[i]);
    of_c[i] = slack - (of_a[i] * px[i] + of_b[i] * py[i]);
  }
  low_x -= 3 * off;
  low_y -= 3 * off;
  high_x += 3 * off;
  high_y += 3 * off;
  const EightInts missed = (high_x < 0) | (high_y < 0) | (low_x > grid.width) | (low_y > grid.height);
  const EightFloats scaled[4] = {low_x * grid.columns_per_px, high_x * grid.columns_per_px, low_y * grid.rows_per_px,
                                 high_y * grid.rows_per_px};
  const float most[4] = {static_cast<float>(grid.columns - 1), static_cast<float>(grid.columns - 1),
                         static_cast<float>(grid.rows - 1), static_cast<float>(grid.rows - 1)};
  EightInts cells[4];
  for (std::size_t k = 0; k < 4; ++k) {
    EightFloats cell = scaled[k] < most[k] ? scaled[k] : zero + most[k];
    cell = cell > 0 ? cell : zero;
    cells[k] = __builtin_convertvector(cell, EightInts);
  }
  cells[3] = missed ? cells[2] - 1 : cells[3];
  std::memcpy(a, of_a, sizeof(a));
  std::memcpy(b, of_b, sizeof(b));
  std::memcpy(c, of_c, sizeof(c));
  std::memcpy(left, &low_x, sizeof(left));
  std::memcpy(right, &high_x, sizeof(right));
  std::memcpy(first_column, &cells[0], sizeof(first_column));
  std::memcpy(last_column, &cells[1], sizeof(last_column));
  std::memcpy(first_row, &cells[2], sizeof(first_row));
  std::memcpy(last_row, &cells[3], sizeof(last_row));
  std::memcpy(sure, &certain, sizeof(sure));
}

namespace {

/// Where the lines of the half-planes bound the rows of cells: by a least and a greatest x in the first row, and how
/// both change from row to row. A line that does not bound a side has an infinity there; those that overflow become
/// NaN, which no comparison below lets through.
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

/// The samples of other faces that satisfy the half-planes; how many.
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

/// A face that may hide samples; made ready for the exact predicates when they are first needed.
struct SubpixelTile::Occluder {
  /// Whether it covers the sample of another face and is nearer there.
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

  const ClassifyView& view;
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
  // Of a narrow rectangle too no more cells than samples.
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
  // Ends, which become beginnings as samples are put before them.
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

/// The corners of up to kLanes faces; lanes without one are NaN.
void SubpixelTile::gather(const ClassifyView& view, std::span<const FaceId> faces, Batch& batch) const {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    // Some lanes have the last face again.
    const Triangle& t = view.mesh.faces[index(faces[std::min(lane, faces.size() - 1)])];
    for (std::size_t k = 0; k < 3; ++k) {
      const RoundedPosition& p = view.projected.positions[t[k]];
      batch.x[k][lane] = static_cast<float>(p.x - left_);
      batch.y[k][lane] = static_cast<float>(p.y - top_);
    }
  }
}

/// The same as prepare() for a face that it is not sure about, in doubles.
void SubpixelTile::look_up(const ClassifyView& view, const QuickLimits& limits, FaceId face, std::size_t lane,
                           Batch& batch) const {
  const FaceBounds bounds = view.bounds(face);
  double x0 = 0, x1 = width_, y0 = 0, y1 = height_;
  if (bounds.bounded) {
    x0 = bounds.x0 - left_;
    x1 = bounds.x1 - left_;
    y0 = bounds.y0 - top_;
    y1 = bounds.y1 - top_;
  }
  const HalfPlanes planes = view.quick(limits, face, bounds).half_planes(left_, top_, std::max(width_, height_));
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

void SubpixelTile::hide_found(const ClassifyView& view, const QuickLimits& limits, FaceId face,
                              std::span<const std::uint32_t> found) {
  Occluder occluder{view, face, view.quick(limits, face, view.bounds(face)), view.depths(face), false, {}};
  for (const std::uint32_t i : found) {
    const std::uint32_t sample = added_[i];
    std::atomic_ref visible(visible_[sample]);
    if (visible.load(std::memory_order_relaxed) == 0) continue;
    if (occluder.hides(x_[sample], y_[sample], faces_[sample])) visible.store(0, std::memory_order_relaxed);
  }
}

void SubpixelTile::hide_behind(const ClassifyView& view, const QuickLimits& limits, std::span<const FaceId> faces,
                               Found& found) {
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
      if (batch.sure[lane] == 0) look_up(view, limits, faces[lane], lane, batch);
      if (batch.first_row[lane] > batch.last_row[lane]) continue;
      const std::size_t count = batch.find(grid, lane, faces[lane], found.data());
      if (count != 0) hide_found(view, limits, faces[lane], std::span(found).first(count));
    }
  }
}

}  // namespace gpvc::visibility
