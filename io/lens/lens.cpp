#include "io/lens/lens.h"

#include <algorithm>
#include <numbers>

namespace gpvc::io {

namespace {

/// q with q + k q^3 = r. Newton's method from r runs towards the root from one side, for k > 0 because the cubic is
/// convex and r lies beyond its root, for k < 0 because it is concave and r lies short of it.
double cubic_root(double k, double r) {
  double q = r;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double next = q - (q + k * q * q * q - r) / (1 + 3 * k * q * q);
    if (!(std::abs(next - q) > 1e-16 * q)) return next;  // half a unit in the last place: no further progress
    q = next;
  }
  return q;
}

/// The angle that LensModel::fisheye_polynomial bends to a radius, where it grows up to `most`; nullopt if that falls
/// short. Newton's method, or halves where it leaves what is left of the interval.
std::optional<double> unbent_angle(const Distortion& d, double radius, double most) {
  double low = 0, high = most;
  if (!(bend_angle(d, high).radius > radius)) return std::nullopt;
  double theta = std::min(radius, high);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const BentAngle bent = bend_angle(d, theta);
    (bent.radius < radius ? low : high) = theta;
    double next = theta - (bent.radius - radius) / bent.slope;
    if (!(next > low && next < high)) next = low + (high - low) / 2;
    if (!(std::abs(next - theta) > 1e-16 * theta)) return next;  // half a unit in the last place: no further progress
    theta = next;
  }
  return theta;
}

/// The point times `radial`.
Distorted radial_part(const Distortion& d, double x, double y) {
  const double r2 = x * x + y * y;
  const double above = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * (d.k3 + r2 * (d.k4 + r2 * (d.k5 + r2 * d.k6)))));
  const double below = 1 + r2 * (d.d1 + r2 * (d.d2 + r2 * d.d3));
  const double above_slope =
      d.k1 + r2 * (2 * d.k2 + r2 * (3 * d.k3 + r2 * (4 * d.k4 + r2 * (5 * d.k5 + r2 * 6 * d.k6))));
  const double below_slope = d.d1 + r2 * (2 * d.d2 + r2 * 3 * d.d3);
  const double radial = above / below;
  const double slope = (above_slope - radial * below_slope) / below;  // by r2
  const double cross = 2 * x * y * slope;
  return {x * radial, y * radial, radial + 2 * x * x * slope, cross, cross, radial + 2 * y * y * slope};
}

/// The tangential terms and the prism's, to be added.
Distorted further_part(const Distortion& d, double x, double y) {
  const double r2 = x * x + y * y;
  const double more = 1 + r2 * (d.p3 + r2 * d.p4), more_slope = d.p3 + 2 * r2 * d.p4;
  const double tx = 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x), ty = d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y;
  const double by_r2_x = tx * more_slope + d.s1 + 2 * d.s3 * r2, by_r2_y = ty * more_slope + d.s2 + 2 * d.s4 * r2;
  const double cross = (2 * d.p1 * x + 2 * d.p2 * y) * more;
  return {tx * more + r2 * (d.s1 + d.s3 * r2),
          ty * more + r2 * (d.s2 + d.s4 * r2),
          (2 * d.p1 * y + 6 * d.p2 * x) * more + 2 * x * by_r2_x,
          cross + 2 * y * by_r2_x,
          cross + 2 * x * by_r2_y,
          (6 * d.p1 * y + 2 * d.p2 * x) * more + 2 * y * by_r2_y};
}

}  // namespace

// The slopes below lose digits by cancellation as r goes to 0, an absolute error of about 1e-16 / r2; they are only
// ever multiplied by x x, x y or y y, so the product stays as exact as the factor.
LensFactor lens_factor(const Distortion& d, double r2) {
  const double r = std::sqrt(r2);
  switch (d.model) {
    case LensModel::brown:
    case LensModel::perspective:
    case LensModel::spherical:  // has functions of its own
    case LensModel::spherical_up:
    case LensModel::spherical_down:
      return {1, 0};
    case LensModel::equidistant:
    case LensModel::fisheye_624: {
      if (r == 0) return {1, 0};
      const double factor = std::atan(r) / r;
      return {factor, (1 / (1 + r2) - factor) / r2};
    }
    case LensModel::fisheye_polynomial: {
      if (r == 0) return {1, 0};
      const BentAngle bent = bend_angle(d, std::atan(r));
      const double factor = bent.radius / r;
      return {factor, (bent.slope / (1 + r2) - factor) / r2};
    }
    case LensModel::equisolid: {
      if (r == 0) return {1, 0};
      const double half = std::atan(r) / 2, factor = 2 * std::sin(half) / r;
      return {factor, (std::cos(half) / (1 + r2) - factor) / r2};
    }
    case LensModel::fov: {
      const double c = 2 * std::tan(d.omega / 2);
      if (r == 0) return {c / d.omega, 0};
      const double factor = std::atan(c * r) / (d.omega * r);
      return {factor, (c / (d.omega * (1 + c * c * r2)) - factor) / r2};
    }
    case LensModel::inverse_radial: {
      if (r == 0) return {1, 0};
      const double q = cubic_root(d.k1, r), factor = q / r;
      return {factor, (1 / (1 + 3 * d.k1 * q * q) - factor) / r2};
    }
    case LensModel::division: {
      // At the limit, 1 / (4 k1), the root is 0 up to rounding.
      const double root = std::sqrt(std::max(1 - 4 * d.k1 * r2, 0.0)), factor = 2 / (1 + root);
      return {factor, factor * factor * 2 * d.k1 / root};
    }
    case LensModel::unified: {
      const double root = std::sqrt(d.beta * r2 + 1), factor = 1 / (d.alpha * root + 1 - d.alpha);
      return {factor, -factor * factor * d.alpha * d.beta / root};
    }
  }
  return {1, 0};
}

double radius_of_angle(const Distortion& d, double theta) {
  if (d.model == LensModel::fisheye_polynomial) return bend_angle(d, theta).radius;
  return d.model == LensModel::equisolid ? 2 * std::sin(theta / 2) : theta;
}

std::optional<double> angle_of_radius(const Distortion& d, double radius, double most) {
  if (d.model == LensModel::fisheye_polynomial) return unbent_angle(d, radius, most);
  const double theta = d.model != LensModel::equisolid ? radius : radius <= 2 ? 2 * std::asin(radius / 2) : kUnbounded;
  return theta <= most ? std::optional(theta) : std::nullopt;
}

double undo_lens_factor(const Distortion& d, double s) {
  const double q = std::sqrt(s);
  const auto squared = [](double v) { return v * v; };
  switch (d.model) {
    case LensModel::equidistant:
    case LensModel::fisheye_624:
      return q < std::numbers::pi / 2 ? squared(std::tan(q)) : kUnbounded;
    case LensModel::fisheye_polynomial: {
      const std::optional<double> theta = unbent_angle(d, q, std::atan(std::sqrt(d.max_r2)));
      return theta ? squared(std::tan(*theta)) : kUnbounded;
    }
    case LensModel::equisolid:
      return q < std::numbers::sqrt2 ? squared(std::tan(2 * std::asin(q / 2))) : kUnbounded;
    case LensModel::fov:
      return q * d.omega < std::numbers::pi / 2 ? squared(std::tan(q * d.omega) / (2 * std::tan(d.omega / 2)))
                                                : kUnbounded;
    case LensModel::inverse_radial:
      return squared(q + d.k1 * q * s);
    case LensModel::division:
      return 1 + d.k1 * s > 0 ? squared(q / (1 + d.k1 * s)) : kUnbounded;
    case LensModel::unified: {
      // The depth component of a ray of radius q; rays at and behind 90 degrees have none.
      const double under = 1 - (2 * d.alpha - 1) * d.beta * s, left = 1 - d.alpha * d.alpha * d.beta * s;
      if (!(under >= 0 && left > 0)) return kUnbounded;
      return squared(q * (d.alpha * std::sqrt(under) + 1 - d.alpha) / left);
    }
    default:
      return s;
  }
}

Distorted distort_any(const Distortion& d, double x0, double y0) {
  const LensFactor lens = lens_factor(d, x0 * x0 + y0 * y0);
  const double u = x0 * lens.factor, v = y0 * lens.factor;
  const double u_x = lens.factor + x0 * x0 * lens.slope, u_y = x0 * y0 * lens.slope,
               v_y = lens.factor + y0 * y0 * lens.slope;  // d(u, v) / d(x0, y0), symmetric
  if (is_bare(d.model)) return {u, v, u_x, u_y, u_y, v_y};
  const Distorted out = distort_behind(d, u, v);
  return {out.x,
          out.y,
          out.dx_dx * u_x + out.dx_dy * u_y,
          out.dx_dx * u_y + out.dx_dy * v_y,
          out.dy_dx * u_x + out.dy_dy * u_y,
          out.dy_dx * u_y + out.dy_dy * v_y};
}

Distorted distort_behind(const Distortion& d, double u, double v) {
  Distorted out = radial_part(d, u, v);
  if (d.model == LensModel::fisheye_624) {
    const Distorted more = further_part(d, out.x, out.y);
    out = {out.x + more.x,
           out.y + more.y,
           out.dx_dx + more.dx_dx * out.dx_dx + more.dx_dy * out.dy_dx,
           out.dx_dy + more.dx_dx * out.dx_dy + more.dx_dy * out.dy_dy,
           out.dy_dx + more.dy_dx * out.dx_dx + more.dy_dy * out.dy_dx,
           out.dy_dy + more.dy_dx * out.dx_dy + more.dy_dy * out.dy_dy};
  } else {
    const Distorted more = further_part(d, u, v);
    out = {out.x + more.x,         out.y + more.y,         out.dx_dx + more.dx_dx,
           out.dx_dy + more.dx_dy, out.dy_dx + more.dy_dx, out.dy_dy + more.dy_dy};
  }
  out.x += d.skew * out.y;
  out.dx_dx += d.skew * out.dy_dx;
  out.dx_dy += d.skew * out.dy_dy;
  return out;
}

}  // namespace gpvc::io
