#include "io/lens.h"

#include <numbers>

namespace gpvc {

namespace {

/// q with q + k q^3 = r. Newton's method from r runs towards the root from one side, for k > 0 because the
/// cubic is convex and r lies beyond its root, for k < 0 because it is concave and r lies short of it.
double cubic_root(double k, double r) {
  double q = r;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double next = q - (q + k * q * q * q - r) / (1 + 3 * k * q * q);
    if (!(std::abs(next - q) > 1e-16 * q)) return next;  // half a unit in the last place: no further progress
    q = next;
  }
  return q;
}

}  // namespace

// The slopes below lose digits by cancellation as r goes to 0, an absolute error of about 1e-16 / r2; they
// are only ever multiplied by x x, x y or y y, so the product stays as exact as the factor.
LensFactor lens_factor(const Distortion& d, double r2) {
  const double r = std::sqrt(r2);
  switch (d.model) {
    case LensModel::brown:
    case LensModel::perspective:
      return {1, 0};
    case LensModel::equidistant: {
      if (r == 0) return {1, 0};
      const double factor = std::atan(r) / r;
      return {factor, (1 / (1 + r2) - factor) / r2};
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
  }
  return {1, 0};
}

double undo_lens_factor(const Distortion& d, double s) {
  const double q = std::sqrt(s);
  const auto squared = [](double v) { return v * v; };
  switch (d.model) {
    case LensModel::equidistant:
      return q < std::numbers::pi / 2 ? squared(std::tan(q)) : kUnbounded;
    case LensModel::equisolid:
      return q < std::numbers::sqrt2 ? squared(std::tan(2 * std::asin(q / 2))) : kUnbounded;
    case LensModel::fov:
      return q * d.omega < std::numbers::pi / 2 ? squared(std::tan(q * d.omega) / (2 * std::tan(d.omega / 2)))
                                                : kUnbounded;
    case LensModel::inverse_radial:
      return squared(q + d.k1 * q * s);
    default:
      return s;
  }
}

Distorted distort_any(const Distortion& d, double x0, double y0) {
  const LensFactor lens = lens_factor(d, x0 * x0 + y0 * y0);
  const double x = x0 * lens.factor, y = y0 * lens.factor;
  const double u_x = lens.factor + x0 * x0 * lens.slope, u_y = x0 * y0 * lens.slope,
               v_y = lens.factor + y0 * y0 * lens.slope;  // d(x, y) / d(x0, y0), symmetric
  if (d.model == LensModel::fov || d.model == LensModel::inverse_radial) return {x, y, u_x, u_y, u_y, v_y};

  const double r2 = x * x + y * y;
  const double above = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * (d.k3 + r2 * d.k4)));
  const double below = 1 + r2 * (d.d1 + r2 * (d.d2 + r2 * d.d3));
  const double above_slope = d.k1 + r2 * (2 * d.k2 + r2 * (3 * d.k3 + r2 * 4 * d.k4));
  const double below_slope = d.d1 + r2 * (2 * d.d2 + r2 * 3 * d.d3);
  const double radial = above / below;
  const double radial_slope = (above_slope - radial * below_slope) / below;  // by r2
  const double more = 1 + r2 * (d.p3 + r2 * d.p4), more_slope = d.p3 + 2 * r2 * d.p4;
  const double tx = 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x),
               ty = d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y;
  const double px = x * radial + tx * more + d.s1 * r2, py = y * radial + ty * more + d.s2 * r2;

  const double cross = 2 * x * y * radial_slope + (2 * d.p1 * x + 2 * d.p2 * y) * more;
  double px_x = radial + 2 * x * x * radial_slope + (2 * d.p1 * y + 6 * d.p2 * x) * more +
                2 * x * (tx * more_slope + d.s1);
  double px_y = cross + 2 * y * (tx * more_slope + d.s1);
  const double py_x = cross + 2 * x * (ty * more_slope + d.s2);
  const double py_y = radial + 2 * y * y * radial_slope + (6 * d.p1 * y + 2 * d.p2 * x) * more +
                      2 * y * (ty * more_slope + d.s2);
  px_x += d.skew * py_x;
  px_y += d.skew * py_y;
  return {px + d.skew * py,        py,
          px_x * u_x + px_y * u_y, px_x * u_y + px_y * v_y,
          py_x * u_x + py_y * u_y, py_x * u_y + py_y * v_y};
}

}  // namespace gpvc
