#include "io/scene.h"

#include <algorithm>
#include <cmath>

namespace gpvc {

namespace {

/// The normalized plane after distortion, and how it changes there.
struct Distorted {
  double x, y;
  double dx_dx, dx_dy, dy_dx, dy_dy;
};

Distorted distort(const Distortion& d, double x, double y) {
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

/// First s in (low, high] with profile(s) <= 0, when profile falls through zero once between them. The answer
/// is the smaller neighbour of the sign change: everything up to it still grows.
template <typename Profile>
double first_zero(const Profile& profile, double low, double high) {
  for (;;) {
    const double middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) return low;
    (profile(middle) > 0 ? low : high) = middle;
  }
}

/// Positive roots of a + b s + c s^2, ascending; cancellation-free.
std::array<double, 2> positive_roots(double a, double b, double c, int& count) {
  count = 0;
  std::array<double, 2> roots{};
  const auto keep = [&](double root) {
    if (std::isfinite(root) && root > 0) roots[static_cast<std::size_t>(count++)] = root;
  };
  const double discriminant = b * b - 4 * a * c;
  if (discriminant < 0) return roots;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  if (c != 0) keep(q / c);
  if (q != 0) keep(a / q);
  if (count == 2 && roots[0] > roots[1]) std::swap(roots[0], roots[1]);
  return roots;
}

}  // namespace

std::optional<PhotoPoint> photo_from_pixel(const Camera& camera, const PixelPoint& p) {
  if (camera.distortion.is_identity()) return PhotoPoint{p.x, p.y};
  const double x = (p.x - camera.cx) / camera.fx, y = (p.y - camera.cy) / camera.fy;
  if (!(x * x + y * y <= camera.distortion.max_r2)) return std::nullopt;
  const Distorted d = distort(camera.distortion, x, y);
  return PhotoPoint{camera.fx * d.x + camera.cx, camera.fy * d.y + camera.cy};
}

std::optional<PixelPoint> pixel_from_photo(const Camera& camera, const PhotoPoint& p) {
  const Distortion& distortion = camera.distortion;
  if (distortion.is_identity()) return PixelPoint{p.x, p.y};
  const double target_x = (p.x - camera.cx) / camera.fx, target_y = (p.y - camera.cy) / camera.fy;
  double x = target_x, y = target_y;
  const double start_r2 = x * x + y * y;
  if (!std::isfinite(start_r2)) return std::nullopt;
  if (start_r2 > distortion.max_r2) {
    // Start inside the part of the plane where the radial profile grows.
    const double shrink = 0.9 * std::sqrt(distortion.max_r2 / start_r2);
    x *= shrink;
    y *= shrink;
  }
  const auto miss_px = [&](const Distorted& d) {
    return std::hypot(camera.fx * (d.x - target_x), camera.fy * (d.y - target_y));
  };
  Distorted here = distort(distortion, x, y);
  double miss = miss_px(here);
  // Converged below 1e-10 px, or where doubles end: a coordinate of 1e4 px carries about 2e-12 px of
  // round-off.
  for (int iteration = 0; iteration < 60 && miss > 1e-11; ++iteration) {
    const double determinant = here.dx_dx * here.dy_dy - here.dx_dy * here.dy_dx;
    if (!(determinant > 0)) break;
    const double ex = target_x - here.x, ey = target_y - here.y;
    const double step_x = (here.dy_dy * ex - here.dx_dy * ey) / determinant;
    const double step_y = (here.dx_dx * ey - here.dy_dx * ex) / determinant;
    bool better = false;
    for (double scale = 1; scale > 1e-6 && !better; scale /= 2) {
      const double next_x = x + scale * step_x, next_y = y + scale * step_y;
      if (!(next_x * next_x + next_y * next_y <= distortion.max_r2)) continue;
      const Distorted next = distort(distortion, next_x, next_y);
      const double next_miss = miss_px(next);
      if (!(next_miss < miss)) continue;
      x = next_x;
      y = next_y;
      here = next;
      miss = next_miss;
      better = true;
    }
    if (!better) break;
  }
  if (!(miss <= 1e-9)) return std::nullopt;
  return PixelPoint{camera.fx * x + camera.cx, camera.fy * y + camera.cy};
}

bool in_photo(const Camera& camera, const PixelPoint& p) {
  const std::optional<PhotoPoint> q = photo_from_pixel(camera, p);
  return q && q->x >= 0 && q->x <= camera.width && q->y >= 0 && q->y <= camera.height;
}

void limit_distortion(Camera& camera) {
  Distortion& d = camera.distortion;
  d.max_r2 = Distortion{}.max_r2;
  // d/dr of r * radial(r2), in s = r2. It is 1 at s = 0 and monotone between the zeros of its own derivative,
  // so the first zero lies in the first of those stretches that ends at or below zero.
  const auto profile = [&](double s) { return 1 + s * (3 * d.k1 + s * (5 * d.k2 + s * 7 * d.k3)); };
  int turns = 0;
  const std::array<double, 2> turn = positive_roots(3 * d.k1, 10 * d.k2, 21 * d.k3, turns);
  double low = 0;
  for (int i = 0; i < turns; ++i) {
    const double high = turn[static_cast<std::size_t>(i)];
    if (profile(high) <= 0) {
      d.max_r2 = first_zero(profile, low, high);
      return;
    }
    low = high;
  }
  // Past the last turn the highest power decides.
  const double leading = d.k3 != 0 ? d.k3 : (d.k2 != 0 ? d.k2 : d.k1);
  if (!(leading < 0)) return;
  double high = std::max(2 * low, 1e-3);
  while (profile(high) > 0 && high < 1e100) high *= 2;
  if (profile(high) <= 0) d.max_r2 = first_zero(profile, low, high);
}

}  // namespace gpvc
