// Does a triangle contain a pixel centre, anywhere on the unbounded grid?
#pragma once

#include <array>
#include <vector>

#include "visibility/oracle/oracle_faces.h"

namespace gpvc::visibility::truth {

struct GridPosition {
  double x = 0, y = 0;  ///< a pixel centre
};

/// `yes`: one lies inside, more than kTiePx from every edge. `maybe`: at best those in `near_edges` do, which lie
/// within kTiePx of an edge; where the triangle reaches further than doubles resolve pixels it is `maybe` without any.
/// O(1), for a triangle of any size. \pre all corners have z > 0
Answer contains_a_centre(const Corners& corners, std::vector<GridPosition>& near_edges);

}  // namespace gpvc::visibility::truth
