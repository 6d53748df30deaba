#include "visibility/subpixel_tile.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "visibility/exact.h"
#include "visibility/wide.h"

namespace gpvc {
namespace {

/// Fewer make more runs a face, more make longer runs; between 1 and 4 the time is much the same.
constexpr double kSamplesPerCell = 3;
/// Samples that the kernel reads at once, and how many it may read beyond the last.
constexpr std::uint32_t kLanes = 8;

/// Column or row of cells. Grows with the position, whatever the rounding.
std::int32_t cell_at(double position, float per_px, std::int32_t cells) {
  const float cell = static_cast<float>(position) * per_px;
  return static_cast<std::int32_t>(std::clamp(cell, 0.0F, static_cast<float>(cells - 1)));
}

}  // namespace

/// What the kernel looks through: all but the rows are positions from the corner of the rectangle.
struct SubpixelTile::Run {
  const float *x, *y;
  const FaceId* faces;
  const std::uint32_t* first;
  std::int32_t columns, first_row, last_row;
  float columns_per_px;
  double row_height;
  double x0, x1;  ///< of the face
  HalfPlanes planes;
  FaceId own;  ///< the face

  std::size_t find(std::uint32_t* found) const;
};

namespace {

/// Where the lines of the half-planes bound the rows of cells: by a least and a greatest x in the first row,
/// and how both change from row to row. A line that does not bound a side has an infinity there; those that
/// overflow become NaN, which no comparison below lets through.
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
GPVC_WIDE_CLONES std::size_t SubpixelTile::Run::find(std::uint32_t* found) const {
  const RowEnds ends(planes, first_row * row_height, row_height);
  const EightFloats zero{};
  const EightFloats a0 = zero + static_cast<float>(planes.a[0]), b0 = zero + static_cast<float>(planes.b[0]),
                    c0 = zero + static_cast<float>(planes.c[0]), a1 = zero + static_cast<float>(planes.a[1]),
                    b1 = zero + static_cast<float>(planes.b[1]), c1 = zero + static_cast<float>(planes.c[1]),
                    a2 = zero + static_cast<float>(planes.a[2]), b2 = zero + static_cast<float>(planes.b[2]),
                    c2 = zero + static_cast<float>(planes.c[2]);
  const EightInts lanes{0, 1, 2, 3, 4, 5, 6, 7};
  std::size_t count = 0;
  for (std::int32_t row = first_row; row <= last_row; ++row) {
    const double rows = row - first_row;
    double low = x0, high = x1;
    for (std::size_t k = 0; k < 3; ++k) {
      low = std::max(low, ends.low[k] + rows * ends.step[k]);
      high = std::min(high, ends.high[k] + rows * ends.step[k]);
    }
    if (!(low <= high)) continue;
    const std::uint32_t* cells = first + static_cast<std::ptrdiff_t>(row) * columns;
    const std::uint32_t end = cells[cell_at(high, columns_per_px, columns) + 1];
    for (std::uint32_t i = cells[cell_at(low, columns_per_px, columns)]; i < end; i += kLanes) {
      EightFloats px, py;
      EightIds id;
      std::memcpy(&px, x + i, sizeof(px));
      std::memcpy(&py, y + i, sizeof(py));
      std::memcpy(&id, faces + i, sizeof(id));
      const EightFloats e0 = a0 * px + b0 * py + c0, e1 = a1 * px + b1 * py + c1, e2 = a2 * px + b2 * py + c2;
      const EightInts in = (e0 >= 0) & (e1 >= 0) & (e2 >= 0) & (lanes < static_cast<std::int32_t>(end - i)) &
                           reinterpret_cast<EightInts>(id != static_cast<std::uint32_t>(own));
      const auto pairs = reinterpret_cast<FourFlags>(in);
      if (((pairs[0] | pairs[1]) | (pairs[2] | pairs[3])) == 0) continue;
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        found[count] = i + lane;
        count += in[lane] != 0;
      }
    }
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
  const QuickFace& quick;
  DepthRange depths;
  bool exact = false;  ///< raster is set
  RasterFace raster;
};

void SubpixelTile::start(std::size_t most) {
  count_ = 0;
  if (x_.size() >= most) return;
  x_.resize(most);
  y_.resize(most);
  faces_.resize(most);
  owners_.resize(most);
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
  const auto cells = [side](double length) {
    return side > 0 ? 1 + static_cast<std::int32_t>(length / side) : 1;
  };
  columns_ = cells(width_);
  rows_ = cells(height_);
  row_height_ = height_ / rows_;
  const auto per_px = [](std::int32_t all, double length) {
    return length > 0 ? std::min(static_cast<float>(all / length), std::numeric_limits<float>::max()) : 0.0F;
  };
  columns_per_px_ = per_px(columns_, width_);
  rows_per_px_ = per_px(rows_, height_);
}

void SubpixelTile::sort() {
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
  visible_.assign(count_, 1);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::uint32_t at = --first_[cells_[i]];
    local_x_[at] = static_cast<float>(x_[i] - left_);
    local_y_[at] = static_cast<float>(y_[i] - top_);
    by_cell_[at] = faces_[i];
    added_[at] = static_cast<std::uint32_t>(i);
  }
}

void SubpixelTile::hide_behind(const ClassifyView& view, const QuickLimits& limits, FaceId face,
                               std::vector<std::uint32_t>& found) {
  const FaceBounds bounds = view.bounds(face);
  double x0 = 0, x1 = width_, y0 = 0, y1 = height_;
  if (bounds.bounded) {
    x0 = bounds.x0 - left_;
    x1 = bounds.x1 - left_;
    y0 = bounds.y0 - top_;
    y1 = bounds.y1 - top_;
    if (x1 < 0 || y1 < 0 || x0 > width_ || y0 > height_) return;
  }
  const QuickFace quick = view.quick(limits, face, bounds);
  if (found.size() < count_ + kLanes) found.resize(count_ + kLanes);
  const Run run{local_x_.data(),
                local_y_.data(),
                by_cell_.data(),
                first_.data(),
                columns_,
                cell_at(y0, rows_per_px_, rows_),
                cell_at(y1, rows_per_px_, rows_),
                columns_per_px_,
                row_height_,
                x0,
                x1,
                quick.half_planes(left_, top_, std::max(width_, height_)),
                face};
  const std::size_t count = run.find(found.data());
  if (count == 0) return;
  Occluder occluder{view, face, quick, view.depths(face), false, {}};
  for (std::size_t i = 0; i < count; ++i) {
    std::atomic_ref visible(visible_[found[i]]);
    if (visible.load(std::memory_order_relaxed) == 0) continue;
    const std::uint32_t sample = added_[found[i]];
    if (occluder.hides(x_[sample], y_[sample], faces_[sample])) visible.store(0, std::memory_order_relaxed);
  }
}

}  // namespace gpvc
