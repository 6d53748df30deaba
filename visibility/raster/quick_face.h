// What plain doubles can tell for certain about most faces, at a fraction of the cost of the exact predicates; whatever
// they cannot tell is left to those, so that answers are the same with and without.
//
// Works on rounded pixel positions. With M the largest coordinate allowed here, w the width plus the height of a face's
// rectangle and r = 2^-53: a position is off by d = r M, the quotient's rounding. The cross product of two differences
// of points of the rectangle is off by 4 d w + 8 d^2 from its inputs and, however it is arranged below, by less than 32
// r w (w + 1) from its evaluation. margin() is above the sum of both.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "visibility/raster/raster.h"
#include "visibility/raster/row_crossings.h"

namespace gpvc::visibility {

/// A run of covered pixels.
struct Span {
  std::int32_t y, x0, x1;
};

/// What quick answers need to know of a view.
class QuickLimits {
 public:
  QuickLimits() = default;
  /// `moderate`: see ProjectedMesh; without it nothing is certain.
  QuickLimits(int width, int height, const ProjectionRounding& rounding, bool moderate)
      : width_(width),
        height_(height),
        reach_(moderate ? 2.0 * std::max(width, height) : -1.0),
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

  /// Whether the rectangle is one that quick answers can be had for.
  bool holds(const FaceBounds& b) const {
    return b.bounded && b.x0 >= -reach_ && b.y0 >= -reach_ && b.x1 <= reach_ && b.y1 <= reach_;
  }
  /// Certainly inside_frame(): u <= W z whatever the rounding of the product.
  bool inside(const FaceBounds& b) const {
    return b.bounded && b.x0 >= 0 && b.y0 >= 0 && b.x1 <= whole_x_ && b.y1 <= whole_y_;
  }
  double margin(double w) const { return 0x1p-48 * w * (reach_ + w + 1) + 0x1p-100 * reach_ * reach_; }
  double edge_on_margin(double w) const { return flat_ + flat_per_w_ * w; }
  PixelBox frame() const { return {0, 0, width_, height_}; }

 private:
  std::int32_t width_ = 0, height_ = 0;
  double reach_ = -1;  ///< M
  double whole_x_ = 0, whole_y_ = 0;
  double flat_ = 0, flat_per_w_ = 0;
};

/// 1 / z of a face's plane over its rectangle: linear, and known to within error.
struct QuickDepth {
  double x = 0, y = 0, first = 0, per_x = 0, per_y = 0;
  double error = std::numeric_limits<double>::infinity();

  double at(double px, double py) const { return first + per_x * (px - x) + per_y * (py - y); }
  /// Whether its face certainly lies in front of the other's at a point of both projections.
  bool before(const QuickDepth& other, double px, double py) const {
    return at(px, py) - other.at(px, py) > error + other.error;
  }
};

/// Where a x + b y + c >= 0 three times over.
struct HalfPlanes {
  std::array<double, 3> a{}, b{}, c{1, 1, 1};  ///< everywhere, to begin with
};

class QuickFace {
 public:
  QuickFace() = default;
  QuickFace(const QuickLimits& limits, const RoundedPosition& a, const RoundedPosition& b, const RoundedPosition& c,
            const FaceBounds& bounds)
      : bounds_(bounds), x_{a.x, b.x, c.x}, y_{a.y, b.y, c.y}, usable_(limits.holds(bounds)) {
    if (!usable_) return;
    const double w = (bounds.x1 - bounds.x0) + (bounds.y1 - bounds.y0);
    margin_ = limits.margin(w);
    const double area = (x_[1] - x_[0]) * (y_[2] - y_[0]) - (y_[1] - y_[0]) * (x_[2] - x_[0]);
    if (std::abs(area) > margin_ + limits.edge_on_margin(w)) facing_ = area < 0 ? Facing::front : Facing::back;
  }

  /// False: nothing is known.
  bool usable() const { return usable_; }
  /// Certain, unless edge_on: that means not known.
  Facing facing() const { return facing_; }

  /// True when the point certainly lies strictly inside the projection.
  bool contains(double px, double py) const {
    if (facing_ == Facing::edge_on || !in_rectangle(px, py)) return false;
    const auto [low, high] = sides(px, py);
    return facing_ == Facing::front ? high < -margin_ : low > margin_;
  }
  /// For positions less (x, y), neither further than `extent` from there along either axis: all that the projection
  /// holds satisfies them, also when they and positions are rounded to floats and the sums of products computed in
  /// floats. They hold everywhere where nothing is known.
  HalfPlanes half_planes(double x, double y, double extent) const;

  /// From the inverse depths of the three vertices, in the order of their positions. Its error is infinite where
  /// nothing is known.
  QuickDepth depth(double wa, double wb, double wc) const;

  /// The rectangle around the part of the projection that lies in the rows of pixels y0 .. y1 - 1: x0 and x1 may be out
  /// of order when there is none. \pre usable()
  FaceBounds in_rows(std::int32_t y0, std::int32_t y1) const;

  /// Where the edges cross the rows of the box; false when they are not known to do so. \pre the box is not empty and
  /// lies in the rectangle.
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
  /// Of the cross products of each edge and the way from its start to the point.
  Range sides(double px, double py) const {
    const double a = (x_[1] - x_[0]) * (py - y_[0]) - (y_[1] - y_[0]) * (px - x_[0]);
    const double b = (x_[2] - x_[1]) * (py - y_[1]) - (y_[2] - y_[1]) * (px - x_[1]);
    const double c = (x_[0] - x_[2]) * (py - y_[2]) - (y_[0] - y_[2]) * (px - x_[2]);
    return {std::min(a, std::min(b, c)), std::max(a, std::max(b, c))};
  }

  FaceBounds bounds_;
  std::array<double, 3> x_{}, y_{};
  double margin_ = 0;
  bool usable_ = false;
  Facing facing_ = Facing::edge_on;
};

/// Whether all entries that the spans name, in rows of `width` entries, are `face`. Eight at a time.
bool all_stored(std::span<const FaceId> ivm, std::int32_t width, std::span<const Span> spans, FaceId face);

}  // namespace gpvc::visibility
