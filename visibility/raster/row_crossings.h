// Where the edges of a face cross rows, of pixels or of other cells, and two ways to read that: bounds over a range of
// rows, and the runs of four rows of pixels. For sources that compile a function twice, see io/wide_clones.h.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "visibility/raster/wide.h"

namespace gpvc::visibility {

/// As QuickFace::cross() sets it: in pixels from the centre of the first pixel of a box.
struct RowCrossings {
  std::array<double, 3> at, slope;            ///< of each edge: in the first row, and from row to row
  std::array<double, 3> not_left, not_right;  ///< -infinity or infinity where an edge does not bound that end
  double width;                               ///< of the box
  double tolerance;                           ///< upper bound of the error of a crossing
};

struct RowRange {
  double low, high;
};

/// The part of the rows first .. last, or fractions of rows, outside of which the face has no point: the crossings are
/// linear, so each is least and greatest at an end. Leaves the tolerance to the caller; for a bound within the box it is
/// valid in any row, because extrapolating an edge there moves its crossing by no more than the width of the box. A
/// crossing that overflows is NaN, which no comparison here selects.
inline RowRange range_of_rows(const RowCrossings& edges, double first, double last) {
  RowRange range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < 3; ++k) {
    const double one = edges.at[k] + edges.slope[k] * first, other = edges.at[k] + edges.slope[k] * last;
    range.low = std::max(range.low, std::min(one, other) + edges.not_left[k]);
    range.high = std::min(range.high, std::max(one, other) + edges.not_right[k]);
  }
  return range;
}

/// The runs of four rows, or of fewer where the box ends: pixels begin .. end - 1 of the box, none where end <= begin.
struct FourRuns {
  FourInts begins, ends;
  bool sure;  ///< no end is within the tolerance of a pixel centre
};

/// One lane a row. A run begins at the first pixel centre right of the rightmost left edge (low) and ends with the last
/// one left of the leftmost right edge (high):
///
///       0     1     2     3     4     5        pixel centres of the row, in pixels from the first
///       .     .   / x     x     x  \  .        low = 1.6, high = 4.4
///                /                  \          begin = int(low + 1) = 2, end = int(high + 1) = 5: pixels 2, 3, 4
///
/// Crossings left of the box become -1/2 and those right of it width +- 1/2, which keeps them away from the centres and
/// makes truncation the floor. The row is sure when both crossings are further than the tolerance from the centres on
/// either side of them.
[[gnu::always_inline]] inline void find_four_runs(const RowCrossings& edges, std::int32_t first_row, std::int32_t rows,
                                                  FourRuns& runs) {
  const FourDoubles zero{};
  const FourDoubles row = FourDoubles{0, 1, 2, 3} + static_cast<double>(first_row);
  const FourDoubles least = zero - 0.5, most_low = zero + (edges.width + 0.5), most_high = zero + (edges.width - 0.5);
  FourDoubles low = least, high = most_high;
  for (std::size_t k = 0; k < 3; ++k) {
    const FourDoubles crossing = edges.at[k] + edges.slope[k] * row;
    const FourDoubles left = crossing + edges.not_left[k], right = crossing + edges.not_right[k];
    low = low < left ? left : low;
    high = right < high ? right : high;
  }
  low = most_low < low ? most_low : low;
  high = high < least ? least : high;
  runs.begins = __builtin_convertvector(low + 1.0, FourInts);
  runs.ends = __builtin_convertvector(high + 1.0, FourInts);
  const FourDoubles to_begin = __builtin_convertvector(runs.begins, FourDoubles) - low;
  const FourDoubles to_end = __builtin_convertvector(runs.ends, FourDoubles) - high;
  const FourFlags sure = (to_begin > edges.tolerance) & (1.0 - to_begin > edges.tolerance) &
                         (to_end > edges.tolerance) & (1.0 - to_end > edges.tolerance);
  const FourFlags unsure = ~sure & (row < static_cast<double>(rows));
  runs.sure = (unsure[0] | unsure[1] | unsure[2] | unsure[3]) == 0;
}

}  // namespace gpvc::visibility
