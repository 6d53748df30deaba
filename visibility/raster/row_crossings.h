// Where the edges of a face cross the rows of a box of pixels, four rows at a time; for sources that compile a function
// twice, see wide.h.
#pragma once

#include <array>
#include <cstdint>

#include "visibility/raster/wide.h"

namespace gpvc::visibility {

/// In pixels from the centre of the first pixel of a box, see QuickFace::cross().
struct RowCrossings {
  std::array<double, 3> at, slope;            ///< of each edge: in the first row, and from row to row
  std::array<double, 3> not_left, not_right;  ///< -infinity or infinity where an edge does not bound that end
  double width;                               ///< of the box
  double tolerance;                           ///< what a crossing may be off
};

/// The runs of four rows, or of fewer where the box ends: pixels begin .. end - 1 of the box, none where end <= begin.
struct FourRuns {
  FourInts begins, ends;
  bool sure;  ///< no end is too near to a pixel centre
};

[[gnu::always_inline]] inline void find_four_runs(const RowCrossings& edges, std::int32_t first_row, std::int32_t rows,
                                                  FourRuns& runs) {
  const FourDoubles zero{};
  const FourDoubles row = FourDoubles{0, 1, 2, 3} + static_cast<double>(first_row);
  const FourDoubles a = edges.at[0] + edges.slope[0] * row, b = edges.at[1] + edges.slope[1] * row,
                    c = edges.at[2] + edges.slope[2] * row;
  // Half a pixel beyond the box is as good as any further.
  const FourDoubles least = zero - 0.5, most_low = zero + (edges.width + 0.5), most_high = zero + (edges.width - 0.5);
  FourDoubles low = a + edges.not_left[0], high = a + edges.not_right[0];
  const FourDoubles low_b = b + edges.not_left[1], high_b = b + edges.not_right[1];
  const FourDoubles low_c = c + edges.not_left[2], high_c = c + edges.not_right[2];
  low = low < low_b ? low_b : low;
  low = low < low_c ? low_c : low;
  low = low < least ? least : low;
  low = most_low < low ? most_low : low;
  high = high_b < high ? high_b : high;
  high = high_c < high ? high_c : high;
  high = high < least ? least : high;
  high = most_high < high ? most_high : high;
  runs.begins = __builtin_convertvector(low + 1.0, FourInts);
  runs.ends = __builtin_convertvector(high + 1.0, FourInts);
  // How far the crossings are from the pixel centres on either side of them.
  const FourDoubles begin = __builtin_convertvector(runs.begins, FourDoubles) - low;
  const FourDoubles end = __builtin_convertvector(runs.ends, FourDoubles) - high;
  const FourFlags sure = (begin > edges.tolerance) & (1.0 - begin > edges.tolerance) & (end > edges.tolerance) &
                         (1.0 - end > edges.tolerance);
  const FourFlags unsure = ~sure & (row < static_cast<double>(rows));
  runs.sure = (unsure[0] | unsure[1] | unsure[2] | unsure[3]) == 0;
}

}  // namespace gpvc::visibility
