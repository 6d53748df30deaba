// What plain doubles decide for certain about most faces, at a fraction of the cost of the exact predicates. Whatever
// they cannot decide is left to those, so results are the same with and without.
//
// The margin. All tests here are signs of the cross product of two differences of points in a face's bounding box,
// computed from rounded pixel positions. With
//
//     M  the largest coordinate allowed (QuickLimits),     r = 2^-53,
//     w  width plus height of the bounding box,            d = r M, the rounding of a position's quotient,
//
//     error of the inputs      4 d w + 8 d^2
//     error of evaluation      32 r w (w + 1), however the product is arranged below
//     margin(w)                2^-48 w (M + w + 1) + 2^-100 M^2     (2^-48 = 32 r), above the sum of both.
//
// A cross product further from zero than margin(w) has the sign of its real value. Rows that an edge crosses follow
// from it: a crossing is off by the margin over the edge's height (cross()).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "visibility/raster/raster.h"
#include "visibility/raster/row_crossings.h"

namespace gpvc::visibility {

/// The bounds of a view within which the margins hold.
class QuickLimits {
 public:
  QuickLimits() = default;
  /// `moderate`: see ProjectedMesh; without it nothing is certain.
  QuickLimits(int width, int height, const ProjectionRounding& rounding, bool moderate)
      : reach_(moderate ? 2.0 * std::max(width, height) : -1.0),
        whole_x_(width * (1 - 0x1p-50)),
        whole_y_(height * (1 - 0x1p-50)) {
    // raster_face() finds a face edge-on when its determinant, that is depths za zb zc times the cross product A of its
    // edges, lies below a margin of at most za zb zc 16 r (3 L w (1 + L q) + 16 L^2): L is the sum of a vertex's |x| +
    // |y| and u_per_z, q is z_per_u; cofactors are no larger than w (1 + L q), and with the nearest vertex first no
    // difference of u, v or z is larger than twice the farther depth times L. Twice that for the rounding of the
    // determinant itself.
    const double l = 2 * reach_ + rounding.u_per_z;
    flat_ = 0x1p-48 * 16 * l * l;
    flat_per_w_ = 0x1p-48 * 3 * l * (1 + l * rounding.z_per_u);
  }

  /// True if the margins are valid for this bounding box.
  bool hold_for(const FaceBounds& b) const {
    return b.bounded && b.x0 >= -reach_ && b.y0 >= -reach_ && b.x1 <= reach_ && b.y1 <= reach_;
  }
  /// True only if inside_frame() holds for the face: u <= W z whatever the rounding of the product.
  bool inside_frame(const FaceBounds& b) const {
    return b.bounded && b.x0 >= 0 && b.y0 >= 0 && b.x1 <= whole_x_ && b.y1 <= whole_y_;
  }
  double margin(double w) const { return 0x1p-48 * w * (reach_ + w + 1) + 0x1p-100 * reach_ * reach_; }
  double edge_on_margin(double w) const { return flat_ + flat_per_w_ * w; }

 private:
  double reach_ = -1;  ///< M
  double whole_x_ = 0, whole_y_ = 0;
  double flat_ = 0, flat_per_w_ = 0;
};

class QuickFace {
 public:
  QuickFace() = default;
  QuickFace(const QuickLimits& limits, const RoundedPosition& a, const RoundedPosition& b, const RoundedPosition& c,
            const FaceBounds& bounds)
      : bounds_(bounds), x_{a.x, b.x, c.x}, y_{a.y, b.y, c.y} {
    if (!limits.hold_for(bounds)) return;
    const double w = (bounds.x1 - bounds.x0) + (bounds.y1 - bounds.y0);
    margin_ = limits.margin(w);
    const double area = (x_[1] - x_[0]) * (y_[2] - y_[0]) - (y_[1] - y_[0]) * (x_[2] - x_[0]);
    if (std::abs(area) > margin_ + limits.edge_on_margin(w)) facing_ = area < 0 ? Facing::front : Facing::back;
  }

  /// Certain, unless edge_on, which here means that nothing is known about the face.
  Facing facing() const { return facing_; }

  /// True when the point certainly lies strictly inside the projection.
  bool contains(double px, double py) const {
    if (facing_ == Facing::edge_on || !in_rectangle(px, py)) return false;
    const auto [low, high] = sides(px, py);
    return facing_ == Facing::front ? high < -margin_ : low > margin_;
  }
  /// From the inverse depths of the three vertices, in the order of their positions. Its error is infinite where
  /// nothing is known.
  InverseDepth inverse_depth(double wa, double wb, double wc) const;

  /// Where the edges cross the rows of the box; false when that is not certain. \pre the box is not empty and, for
  /// find_four_runs(), lies in the face's bounding box
  bool cross(const PixelBox& box, RowCrossings& edges) const;
  /// The runs of the box's pixels whose centres are covered; false when some row is not certain. Four rows at a time.
  bool spans(const PixelBox& box, std::vector<Span>& found) const;

 private:
  struct Range {
    double low, high;
  };

  bool level_edge_clears(std::size_t i, std::size_t j, double turn, const PixelBox& box) const;
  bool in_rectangle(double px, double py) const {
    return px >= bounds_.x0 && px <= bounds_.x1 && py >= bounds_.y0 && py <= bounds_.y1;
  }
  /// Range of the cross products of each edge and the way from its start to the point.
  Range sides(double px, double py) const {
    const double a = (x_[1] - x_[0]) * (py - y_[0]) - (y_[1] - y_[0]) * (px - x_[0]);
    const double b = (x_[2] - x_[1]) * (py - y_[1]) - (y_[2] - y_[1]) * (px - x_[1]);
    const double c = (x_[0] - x_[2]) * (py - y_[2]) - (y_[0] - y_[2]) * (px - x_[2]);
    return {std::min(a, std::min(b, c)), std::max(a, std::max(b, c))};
  }

  FaceBounds bounds_;
  std::array<double, 3> x_{}, y_{};
  double margin_ = 0;
  Facing facing_ = Facing::edge_on;
};

}  // namespace gpvc::visibility
