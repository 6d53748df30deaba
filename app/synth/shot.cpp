#include "app/synth/shot.h"

#include <algorithm>

#include "app/synth/synth_scene.h"

namespace gpvc::synth {
namespace {

CameraPoint cross(const CameraPoint& a, const CameraPoint& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Rotation by the vector 2 a of Rodrigues' formula: by twice the arc tangent of its length.
CameraPoint turned(const CameraPoint& v, const CameraPoint& a) {
  const double s = 2 / (1 + a.x * a.x + a.y * a.y + a.z * a.z);
  const CameraPoint once = cross(a, v), twice = cross(a, once);
  return {v.x + s * (once.x + twice.x), v.y + s * (once.y + twice.y), v.z + s * (once.z + twice.z)};
}

// To the unit disc from the square [-1, 1]^2, squares around the middle becoming circles.
void to_disc(double& x, double& y) {
  const bool wide = std::abs(x) > std::abs(y);
  const double radius = wide ? x : y;
  if (radius == 0) return;
  constexpr double kQuarterOfPi = 0.78539816339744831;
  const double angle = kQuarterOfPi * (wide ? y / x : x / y), a2 = angle * angle;
  // Taylor series; at a quarter of pi the next terms are below 4e-7.
  const double sin = angle * (1 - a2 / 6 * (1 - a2 / 20 * (1 - a2 / 42)));
  const double cos = 1 - a2 / 2 * (1 - a2 / 12 * (1 - a2 / 30 * (1 - a2 / 56)));
  x = radius * (wide ? cos : sin);
  y = radius * (wide ? sin : cos);
}

}  // namespace

LensSample lens_sample(std::uint32_t x, std::uint32_t y, std::uint32_t n) {
  // Powers of the inverse of the root of r^4 = r + 1.
  constexpr double kSteps[3] = {0.81917251339616443970, 0.67104360670378920842, 0.54970047790197026696};
  const auto part = [&](std::uint32_t i) {
    const double v = synth_chance(x, y, 9100 + i) + n * kSteps[i];
    return v - std::floor(v);
  };
  LensSample sample{2 * part(0) - 1, 2 * part(1) - 1, part(2) - 0.5};
  to_disc(sample.x, sample.y);
  return sample;
}

CameraRay shot_ray(const Shot& shot, double x, double y, const LensSample& sample) {
  const double radius = shot.lens.aperture_m / 2, focus = shot.lens.focus_m;
  CameraRay ray{{radius * sample.x, radius * sample.y, 0}, {x, y, 1}};
  // All rays of a pixel meet in the plane in focus.
  ray.direction.x -= ray.origin.x / focus;
  ray.direction.y -= ray.origin.y / focus;
  const CameraPoint &w = shot.shake.turn_rad, &way = shot.shake.travel_m;
  const double half = sample.time / 2;
  const CameraPoint turn{w.x * half, w.y * half, w.z * half};
  ray.origin = turned(ray.origin, turn);
  ray.direction = turned(ray.direction, turn);
  ray.origin = {ray.origin.x + way.x * sample.time, ray.origin.y + way.y * sample.time,
                ray.origin.z + way.z * sample.time};
  return ray;
}

double haze_transmission(double distance_m, double visibility_m) {
  if (visibility_m == 0) return 1;
  constexpr double kVisible = 3.9120230054281461;  // -ln 0.02
  // exp(-x) as the 1024th power of exp(-x / 1024), whose Taylor series is cut after the cube: off by 4e-7 at x = 10.
  // Beyond 30 nothing is left that 8 bits could show.
  const double x = std::min(kVisible * distance_m / visibility_m, 30.0) / 1024;
  double kept = 1 - x * (1 - x / 2 * (1 - x / 3));
  for (int i = 0; i < 10; ++i) kept *= kept;
  return kept;
}

}  // namespace gpvc::synth
