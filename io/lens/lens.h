// The lens models of scene.h with their derivatives; formulas are stated there.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "io/scene.h"

namespace gpvc::io {

/// The bound of a lens model that has none.
inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// A point of the normalized plane after distortion, and how it changes there.
struct Distorted {
  double x, y;
  double dx_dx, dx_dy, dy_dx, dy_dy;
};

/// LensModel::brown. Inline: the inner loop of everything that samples photos.
inline Distorted distort_brown(const Distortion& d, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  const double radial_slope = d.k1 + r2 * (2 * d.k2 + r2 * 3 * d.k3);  // d radial / d r2
  Distorted out;
  out.x = x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x);
  out.y = y * radial + d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y;
  out.dx_dx = radial + 2 * x * x * radial_slope + 2 * d.p1 * y + 6 * d.p2 * x;
  out.dx_dy = 2 * x * y * radial_slope + 2 * d.p1 * x + 2 * d.p2 * y;
  out.dy_dx = out.dx_dy;
  out.dy_dy = radial + 2 * y * y * radial_slope + 6 * d.p1 * y + 2 * d.p2 * x;
  return out;
}

/// Any model.
Distorted distort_any(const Distortion& d, double x, double y);

inline Distorted distort(const Distortion& d, double x, double y) {
  return d.model == LensModel::brown ? distort_brown(d, x, y) : distort_any(d, x, y);
}

/// The radius that LensModel::fisheye_polynomial gives to an angle from the axis, and its derivative.
struct BentAngle {
  double radius, slope;
};
inline BentAngle bend_angle(const Distortion& d, double theta) {
  return {theta * (1 + theta * (d.a1 + theta * (d.a2 + theta * d.a3))),
          1 + theta * (2 * d.a1 + theta * (3 * d.a2 + theta * 4 * d.a3))};
}

/// True for the models that are functions of the angle from the axis, and so go on behind 90 degrees.
constexpr bool is_of_angle(LensModel model) {
  return model == LensModel::equidistant || model == LensModel::equisolid || model == LensModel::fisheye_polynomial ||
         model == LensModel::fisheye_624;
}

/// The radius that such a model gives to an angle from the axis, before the terms that act behind it.
double radius_of_angle(const Distortion& d, double theta);

/// Its inverse up to the angle `most`; nullopt beyond it.
std::optional<double> angle_of_radius(const Distortion& d, double radius, double most);

/// The angle, at most pi, up to which the photo's radius grows. \pre is_of_angle(d.model)
double largest_angle(const Distortion& d);

/// Where the photo shows a direction, given in the lens's axes; nullopt where it is more than `most` from the lens's axis.
/// \pre is_of_angle; most <= largest_angle
std::optional<PhotoPoint> photo_of_ray(const Camera& camera, const CameraPoint& ray, double most);

/// Its inverse: the direction of length 1, in the lens's axes, that the photo shows at a place; nullopt where it is more than `most` from
/// the lens's axis. \pre is_of_angle; most <= largest_angle
std::optional<CameraPoint> ray_of_photo(const Camera& camera, const PhotoPoint& p, double most);

/// The terms that act on what LensModel's factor makes. \pre !is_bare(d.model)
Distorted distort_behind(const Distortion& d, double u, double v);

/// LensModel's factor is all there is: none of the terms that act behind it.
inline bool is_bare(LensModel model) {
  return model == LensModel::fov || model == LensModel::inverse_radial || model == LensModel::division ||
         model == LensModel::unified;
}

/// The factor of LensModel at squared radius r2, and its derivative by r divided by r.
struct LensFactor {
  double factor, slope;
};
LensFactor lens_factor(const Distortion& d, double r2);

/// The squared radius before LensModel's factor that has squared radius `s` after it; infinity where only directions at
/// or behind 90 degrees reach it.
double undo_lens_factor(const Distortion& d, double s);

}  // namespace gpvc::io
