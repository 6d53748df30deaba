#include "visibility/raster/quick_face.h"

#include <cstring>

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

/// True when the runs hold nothing but `face`.
GPVC_WIDE_CLONES bool runs_hold(const FaceId* entries, std::size_t total, std::size_t width, const Span* spans,
                                std::size_t count, FaceId face) {
  const auto wanted = static_cast<std::uint32_t>(face);
  const EightIds lanes{0, 1, 2, 3, 4, 5, 6, 7};
  EightIds differences{};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = static_cast<std::size_t>(spans[i].y) * width + static_cast<std::size_t>(spans[i].x0);
    const auto length = static_cast<std::uint32_t>(spans[i].x1 - spans[i].x0);
    const FaceId* run = entries + first;
    if (first + length + 8 > total) {  // too near to the end to read eight at a time
      for (std::uint32_t x = 0; x < length; ++x) differences[0] |= static_cast<std::uint32_t>(run[x]) ^ wanted;
      continue;
    }
    for (std::uint32_t x = 0; x < length; x += 8) {
      static_assert(sizeof(FaceId) == sizeof(std::uint32_t));
      EightIds eight;
      std::memcpy(&eight, run + x, sizeof(eight));
      const EightIds in_run = reinterpret_cast<EightIds>(lanes < length - x);
      differences |= (eight ^ wanted) & in_run;
    }
    if (length > 32 && !(differences[0] == 0)) return false;
  }
  std::uint32_t any = 0;
  for (std::size_t lane = 0; lane < 8; ++lane) any |= differences[lane];
  return any == 0;
}

}  // namespace

/// The error of evaluation in floats, with r = 2^-24, X the extent and v the edge's first corner relative to the
/// origin:
///
///     value            a x + b y + c     with c = -(a v.x + b v.y)
///     its error        6 r (|a| + |b|) X + 3 r |c|     and |c| is no more than the sum of its terms' sizes
///     lower bound      -margin_ for a point of the projection, before rounding
///
/// A second margin_ in c covers the rounding of c itself.
HalfPlanes QuickFace::half_planes(double x, double y, double extent) const {
  HalfPlanes planes;
  if (!usable_ || facing_ == Facing::edge_on) return planes;
  const double turn = facing_ == Facing::front ? -1 : 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double a = turn * (y_[i] - y_[j]), b = turn * (x_[j] - x_[i]);
    const double from_x = x_[i] - x, from_y = y_[i] - y;
    planes.a[i] = a;
    planes.b[i] = b;
    planes.c[i] = 2 * margin_ - (a * from_x + b * from_y) +
                  0x1p-21 * (std::abs(a) * (extent + std::abs(from_x)) + std::abs(b) * (extent + std::abs(from_y)));
  }
  return planes;
}

/// Clips each edge to the rows. A corner and a clipped point are off by a few roundings of a coordinate below 2^20 px,
/// far less than the slack of 2^-24 px.
FaceBounds QuickFace::in_rows(std::int32_t y0, std::int32_t y1) const {
  constexpr double kSlack = 0x1p-24;
  const double top = y0 - kSlack, bottom = y1 + kSlack;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double first = std::min(y_[i], y_[j]), last = std::max(y_[i], y_[j]);
    if (last < top || first > bottom) continue;
    double a = x_[i], b = x_[j];
    if (last - first > kSlack) {
      const double slope = (x_[j] - x_[i]) / (y_[j] - y_[i]);
      a = x_[i] + slope * (std::clamp(top, first, last) - y_[i]);
      b = x_[i] + slope * (std::clamp(bottom, first, last) - y_[i]);
    }
    low = std::min(low, std::min(a, b));
    high = std::max(high, std::max(a, b));
  }
  return {std::max(low - kSlack, bounds_.x0),
          std::max(top, bounds_.y0),
          std::min(high + kSlack, bounds_.x1),
          std::min(bottom, bounds_.y1),
          true,
          true};
}

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

bool all_stored(std::span<const FaceId> ivm, std::int32_t width, std::span<const Span> spans, FaceId face) {
  if (spans.empty()) return true;
  const auto stride = static_cast<std::size_t>(width);
  // Most hidden faces fail here already.
  const Span& middle = spans[spans.size() / 2];
  if (ivm[static_cast<std::size_t>(middle.y) * stride + static_cast<std::size_t>(middle.x0)] != face) return false;
  return runs_hold(ivm.data(), ivm.size(), stride, spans.data(), spans.size(), face);
}

}  // namespace gpvc::visibility
