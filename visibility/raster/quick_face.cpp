#include "visibility/raster/quick_face.h"

#include "io/wide_clones.h"
#include "visibility/raster/wide.h"

namespace gpvc::visibility {
namespace {

/// Fills `found`, one span a row at most. Returns how many, or -1 when some row is not certain.
GPVC_WIDE_CLONES std::ptrdiff_t find_spans(const RowCrossings& edges, const PixelBox& box, Span* found) {
  const std::int32_t rows = box.y1 - box.y0;
  std::ptrdiff_t count = 0;
  for (std::int32_t first = 0; first < rows; first += 4) {
    FourRuns runs;
    find_four_runs(edges, first, rows, runs);
    if (!runs.sure) return -1;
    const std::int32_t last = std::min(rows - first, 4);
    for (std::int32_t lane = 0; lane < last; ++lane) {
      found[count] = {box.y0 + first + lane, box.x0 + runs.begins[lane], box.x0 + runs.ends[lane]};
      count += runs.begins[lane] < runs.ends[lane];
    }
  }
  return count;
}

}  // namespace

/// The error of 1 / z at a point of the projection. With m the margin, r, d, w and M as at the top of the header, D the
/// largest 1 / z of a vertex and A the cross product of two edges (twice the area):
///
///     m                               >  32 d w + 32 r w^2
///     numerator of a gradient         <= 2 D w,  off by D (4 d + 14 r w)
///     times the way to the point      off by D (6 d w + 16 r w^2), since the way is at most w; both of them: 2 D m
///     divided by A, itself off by m   off by 3 D m / |A|
///     rounding of gradients, products and sums                2 D m / |A| + 8 r D
///     total                           5 D m / |A| + 8 r D
///
/// The error that is stored, 16 D m / |A| + 2^-48 D, is more than twice that: it also covers rounding the difference of
/// two such values.
InverseDepth QuickFace::inverse_depth(double wa, double wb, double wc) const {
  InverseDepth plane;
  if (facing_ == Facing::edge_on) return plane;
  const double dx1 = x_[1] - x_[0], dy1 = y_[1] - y_[0], dx2 = x_[2] - x_[0], dy2 = y_[2] - y_[0];
  const double per_area = 1 / (dx1 * dy2 - dy1 * dx2);
  plane.x = x_[0];
  plane.y = y_[0];
  plane.first = wa;
  plane.per_x = ((wb - wa) * dy2 - (wc - wa) * dy1) * per_area;
  plane.per_y = ((wc - wa) * dx1 - (wb - wa) * dx2) * per_area;
  plane.error = std::max(wa, std::max(wb, wc)) * (16 * margin_ * std::abs(per_area) + 0x1p-48);
  return plane;
}

/// For an edge from vertex i to vertex j that is too level for its crossings to be computed: true when all rows of the
/// box are certainly inside it, so that it bounds no run. Along a row the cross product of the edge and the way to a
/// point varies by no more than |height| times the width of the bounding box; evaluation is off by far less than a
/// second margin_.
bool QuickFace::level_edge_clears(std::size_t i, std::size_t j, double turn, const PixelBox& box) const {
  const double along = turn * (x_[j] - x_[i]), height = std::abs(y_[j] - y_[i]);
  const double top = along * (box.y0 + 0.5 - y_[i]), bottom = along * (box.y1 - 0.5 - y_[i]);
  return std::min(top, bottom) - height * (bounds_.x1 - bounds_.x0) > 2 * margin_;
}

/// A crossing is off by margin_ / |height of the edge|, and by twice that with the rounding of the division. Edges that
/// have the face on their right bound the run from the left.
bool QuickFace::cross(const PixelBox& box, RowCrossings& edges) const {
  if (facing_ == Facing::edge_on) return false;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double turn = facing_ == Facing::front ? -1 : 1;
  const double first_x = box.x0 + 0.5, first_y = box.y0 + 0.5;
  double least = kNever;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double height = y_[j] - y_[i];
    if (!(std::abs(height) > 8 * margin_)) {
      if (!level_edge_clears(i, j, turn, box)) return false;
      edges.slope[i] = edges.at[i] = 0;
      edges.not_left[i] = -kNever;
      edges.not_right[i] = kNever;
      continue;
    }
    least = std::min(least, std::abs(height));
    edges.slope[i] = (x_[j] - x_[i]) / height;
    edges.at[i] = (x_[i] - first_x) + edges.slope[i] * (first_y - y_[i]);
    const bool left = turn * height < 0;
    edges.not_left[i] = left ? 0 : -kNever;
    edges.not_right[i] = left ? kNever : 0;
  }
  edges.tolerance = 2 * margin_ / least;
  edges.width = box.x1 - box.x0;
  return true;
}

bool QuickFace::spans(const PixelBox& box, std::vector<Span>& found) const {
  found.clear();
  if (facing_ == Facing::edge_on) return false;
  if (box.empty()) return true;
  RowCrossings edges;
  if (!cross(box, edges)) return false;
  found.resize(static_cast<std::size_t>(box.y1 - box.y0));
  const std::ptrdiff_t count = find_spans(edges, box, found.data());
  if (count < 0) return false;
  found.resize(static_cast<std::size_t>(count));
  return true;
}

}  // namespace gpvc::visibility
