// The functions of scene.h that go through the lens: between the frame and the photo.
#include "io/scene.h"

#include <algorithm>
#include <cmath>

#include "io/lens/lens.h"
#include "io/lens/motion.h"
#include "io/lens/spherical.h"

namespace gpvc {
namespace {

/// Where the lens shows a point of the plane of a frame that looks aside.
std::optional<PhotoPoint> through_lens_aside(const Camera& camera, double x, double y) {
  const Distortion& d = camera.distortion;
  const auto& m = d.lens_from_frame;
  return io::photo_of_ray(camera, {m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5], m[6] * x + m[7] * y + m[8]},
                          d.max_angle);
}

/// Where the lens shows a point of the undistorted plane.
std::optional<PhotoPoint> through_lens(const Camera& camera, double x, double y) {
  if (camera.distortion.looks_aside()) return through_lens_aside(camera, x, y);
  if (!(x * x + y * y <= camera.distortion.max_r2)) return std::nullopt;
  if (is_spherical(camera.distortion.model)) {
    const io::PlanePoint q = io::sphere_from_plane(camera.distortion.model, x, y);
    return PhotoPoint{camera.fx * q.x + camera.cx, camera.fy * q.y + camera.cy};
  }
  const io::Distorted d = io::distort(camera.distortion, x, y);
  return PhotoPoint{camera.fx * d.x + camera.cx, camera.fy * d.y + camera.cy};
}

/// The place of what was at (x, y) of the plane at time 0 is where it is at the time of that place. It is found step by
/// step, each of which leaves as much of the error as the movement is of the photo's size: a hundredth, as a rule.
std::optional<PhotoPoint> through_moving_lens(const Camera& camera, double x, double y) {
  constexpr int kMostSteps = 40;
  constexpr double kErrorPx = 1e-10;
  double time = 0;
  PhotoPoint last{};
  for (int step = 0; step < kMostSteps; ++step) {
    const CameraPoint ray = io::moved(camera.distortion.motion, time, x, y);
    if (!(ray.z > 0)) return std::nullopt;
    const auto place = through_lens(camera, ray.x / ray.z, ray.y / ray.z);
    if (!place) return std::nullopt;
    if (step > 0 && std::hypot(place->x - last.x, place->y - last.y) < kErrorPx) return place;
    last = *place;
    time = io::time_of(camera, last);
  }
  return std::nullopt;
}

/// The (x, y) that `distort` takes to the target, to 1e-9 px, within the squared radius `most_r2`: Newton's method from
/// the start.
template <class Distort>
std::optional<io::PlanePoint> undistorted(const Camera& camera, io::PlanePoint start, const io::PlanePoint& target,
                                          double most_r2, const Distort& distort) {
  auto [x, y] = start;
  const auto miss_px = [&](const io::Distorted& d) {
    return std::hypot(camera.fx * (d.x - target.x), camera.fy * (d.y - target.y));
  };
  io::Distorted here = distort(x, y);
  double miss = miss_px(here);
  // Converged below 1e-10 px, or where doubles end: a coordinate of 1e4 px carries about 2e-12 px of round-off.
  for (int iteration = 0; iteration < 60 && miss > 1e-11; ++iteration) {
    const double determinant = here.dx_dx * here.dy_dy - here.dx_dy * here.dy_dx;
    if (!(determinant > 0)) break;
    const double ex = target.x - here.x, ey = target.y - here.y;
    const double step_x = (here.dy_dy * ex - here.dx_dy * ey) / determinant;
    const double step_y = (here.dx_dx * ey - here.dy_dx * ex) / determinant;
    bool better = false;
    for (double scale = 1; scale > 1e-6 && !better; scale /= 2) {
      const double next_x = x + scale * step_x, next_y = y + scale * step_y;
      if (!(next_x * next_x + next_y * next_y <= most_r2)) continue;
      const io::Distorted next = distort(next_x, next_y);
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
  return io::PlanePoint{x, y};
}

/// `p` moved towards the middle until its squared radius is `r2`.
io::PlanePoint with_radius(const io::PlanePoint& p, double r2) {
  const double scale = std::sqrt(r2 / (p.x * p.x + p.y * p.y));
  return {scale * p.x, scale * p.y};
}

/// The direction of length 1, in the lens's axes, that the lens shows at the target of the distorted plane.
std::optional<CameraPoint> ray_of_lens(const Camera& camera, const io::PlanePoint& target, double most) {
  const Distortion& d = camera.distortion;
  const double radius = io::radius_of_angle(d, most), most_r2 = radius * radius,
               r2 = target.x * target.x + target.y * target.y;
  if (!std::isfinite(r2)) return std::nullopt;
  const std::optional<io::PlanePoint> q =
      undistorted(camera, r2 > most_r2 ? with_radius(target, 0.81 * most_r2) : target, target, most_r2,
                  [&](double u, double v) { return io::distort_behind(d, u, v); });
  if (!q) return std::nullopt;
  const double across = std::hypot(q->x, q->y);
  const std::optional<double> theta = io::angle_of_radius(d, across, most);
  if (!theta) return std::nullopt;
  const double factor = across > 0 ? std::sin(*theta) / across : 0;
  return CameraPoint{factor * q->x, factor * q->y, std::cos(*theta)};
}

/// The point of the undistorted plane that the lens shows at the target of the distorted one.
std::optional<io::PlanePoint> undo_lens(const Camera& camera, const io::PlanePoint& target) {
  const Distortion& distortion = camera.distortion;
  if (distortion.looks_aside()) {
    const std::optional<CameraPoint> ray = ray_of_lens(camera, target, distortion.max_angle);
    if (!ray) return std::nullopt;
    const auto& m = distortion.lens_from_frame;
    const double z = m[2] * ray->x + m[5] * ray->y + m[8] * ray->z;
    if (!(z > 0)) return std::nullopt;
    return io::PlanePoint{(m[0] * ray->x + m[3] * ray->y + m[6] * ray->z) / z,
                          (m[1] * ray->x + m[4] * ray->y + m[7] * ray->z) / z};
  }
  if (is_spherical(distortion.model)) {
    const auto q = io::plane_from_sphere(distortion.model, target.x, target.y);
    return q && q->x * q->x + q->y * q->y <= distortion.max_r2 ? q : std::nullopt;
  }
  const double start_r2 = target.x * target.x + target.y * target.y;
  if (!std::isfinite(start_r2)) return std::nullopt;
  double guess_r2 = start_r2;
  if (distortion.model != LensModel::brown) {
    // A fisheye's radius says little about that of the plane: undo its factor, not beyond 85 degrees.
    constexpr double kFarthest = 130;  // tan(85 degrees)^2
    guess_r2 = std::min(io::undo_lens_factor(distortion, start_r2), kFarthest);
  }
  // Start inside the part of the plane where the radial profile grows.
  if (guess_r2 > distortion.max_r2) guess_r2 = 0.81 * distortion.max_r2;
  return undistorted(camera, guess_r2 != start_r2 ? with_radius(target, guess_r2) : target, target, distortion.max_r2,
                     [&](double x, double y) { return io::distort(distortion, x, y); });
}

}  // namespace

std::optional<PhotoPoint> io::photo_of_ray(const Camera& camera, const CameraPoint& ray, double most) {
  const Distortion& d = camera.distortion;
  const double across = std::hypot(ray.x, ray.y), theta = std::atan2(across, ray.z);
  if (!(theta <= most)) return std::nullopt;
  const double factor = across > 0 ? radius_of_angle(d, theta) / across : 0;
  const Distorted at = distort_behind(d, factor * ray.x, factor * ray.y);
  return PhotoPoint{camera.fx * at.x + camera.cx, camera.fy * at.y + camera.cy};
}

std::optional<CameraPoint> io::ray_of_photo(const Camera& camera, const PhotoPoint& p, double most) {
  return ray_of_lens(camera, {(p.x - camera.cx) / camera.fx, (p.y - camera.cy) / camera.fy}, most);
}

std::array<double, 2> ShiftField::shift_at(const PixelPoint& p) const {
  const double u = std::clamp(p.x / spacing, 0.0, columns - 1.0), v = std::clamp(p.y / spacing, 0.0, rows - 1.0);
  const int column = std::min(static_cast<int>(u), columns - 2), row = std::min(static_cast<int>(v), rows - 2);
  const double x = u - column, y = v - row;
  const std::array<float, 2>* above = nodes.data() + static_cast<std::ptrdiff_t>(row) * columns + column;
  const std::array<float, 2>* below = above + columns;
  std::array<double, 2> shift{};
  for (std::size_t i = 0; i < 2; ++i) {
    const double upper = std::lerp(double{above[0][i]}, double{above[1][i]}, x);
    const double lower = std::lerp(double{below[0][i]}, double{below[1][i]}, x);
    shift[i] = std::lerp(upper, lower, y);
  }
  return shift;
}

std::optional<PhotoPoint> photo_from_pixel(const Camera& camera, const PixelPoint& frame) {
  const Distortion& distortion = camera.distortion;
  PixelPoint p = frame;
  if (!distortion.aligned.nodes.empty()) {
    const auto [shift_x, shift_y] = distortion.aligned.shift_at(frame);
    p = {p.x + shift_x, p.y + shift_y};
  }
  if (!distortion.has_lens()) return PhotoPoint{p.x, p.y};
  const double x = (p.x - camera.cx) / camera.fx, y = (p.y - camera.cy) / camera.fy;
  return distortion.motion.moves() ? through_moving_lens(camera, x, y) : through_lens(camera, x, y);
}

std::optional<PixelPoint> pixel_from_photo(const Camera& camera, const PhotoPoint& p) {
  if (camera.distortion.is_identity()) return PixelPoint{p.x, p.y};
  std::optional<io::PlanePoint> q = undo_lens(camera, {(p.x - camera.cx) / camera.fx, (p.y - camera.cy) / camera.fy});
  if (!q) return std::nullopt;
  if (const Motion& motion = camera.distortion.motion; motion.moves()) {
    const CameraPoint ray = io::moved_back(motion, io::time_of(camera, p), q->x, q->y);
    if (!(ray.z > 0)) return std::nullopt;
    q = io::PlanePoint{ray.x / ray.z, ray.y / ray.z};
  }
  return PixelPoint{camera.fx * q->x + camera.cx, camera.fy * q->y + camera.cy};
}

bool in_photo(const Camera& camera, const PixelPoint& p) {
  const std::optional<PhotoPoint> q = photo_from_pixel(camera, p);
  return q && q->x >= 0 && q->x <= camera.width && q->y >= 0 && q->y <= camera.height;
}

}  // namespace gpvc
