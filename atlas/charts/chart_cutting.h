// Cutting sets of faces that would fill a page badly.
#pragma once

#include <span>
#include <vector>

#include "atlas/charts/chart_merging.h"
#include "atlas/charts/triangle_spans.h"

namespace gpvc::atlas {

/// The longer axis of a box; its middle tells the faces of the two halves apart.
class LongAxis {
 public:
  explicit LongAxis(const FrameBox& box) : x_(box.x1 - box.x0 >= box.y1 - box.y0) {
    middle_ = 1.5 * (x_ ? box.x0 + box.x1 : box.y0 + box.y1);
  }
  /// Three times the position of a face's centroid.
  double place(const TexelTriangle& t) const { return x_ ? t[0].x + t[1].x + t[2].x : t[0].y + t[1].y + t[2].y; }
  bool in_first_half(const TexelTriangle& t) const { return place(t) < middle_; }

 private:
  bool x_;
  double middle_;
};

/// Large charts that leave much of their box empty make holes on pages, and there are too few small charts to fill
/// them. Halves across the longer axis pack better, at the price of a margin on both sides of the cut. The parts in their order.
/// \param corners of all faces, where the part's box is
std::vector<FramePart> cut_ragged(FramePart part, std::span<const TexelTriangle> corners);

}  // namespace gpvc::atlas
