#include "io/lens/motion.h"

#include <array>
#include <cmath>

#include "io/lens/lens.h"

namespace gpvc::io {
namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double norm(const Vector& a) { return std::sqrt(dot(a, a)); }

/// `v` turned by the vector's length about its direction (Rodrigues).
Vector turned(const Vector& by, const Vector& v) {
  const double angle = norm(by);
  // sin(a) / a and (1 - cos(a)) / a^2, which are 1 and 1/2 where a^2 is below the last digit.
  const double sine = angle > 1e-9 ? std::sin(angle) / angle : 1;
  const double half = angle > 1e-9 ? std::sin(angle / 2) / angle : 0.5;
  const double versine = 2 * half * half;
  const Vector once{by[1] * v[2] - by[2] * v[1], by[2] * v[0] - by[0] * v[2], by[0] * v[1] - by[1] * v[0]};
  const double along = dot(by, v), squared = angle * angle;
  Vector out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = v[i] + sine * once[i] + versine * (by[i] * along - squared * v[i]);
  return out;
}

Vector times(const Vector& v, double factor) { return {factor * v[0], factor * v[1], factor * v[2]}; }

CameraPoint point(const Vector& v) { return {v[0], v[1], v[2]}; }

}  // namespace

double time_of(const Camera& camera, const PhotoPoint& p) {
  const Motion& m = camera.distortion.motion;
  return m.across * (p.x / camera.width - 0.5) + m.down * (p.y / camera.height - 0.5);
}

// A point at depth z on the ray d = (x, y, 1) lies at z d and moves to exp(time turn) (z d - time step). Divided by z,
// with 1 / z = nearness . d, that is exp(time turn) (d - time step (nearness . d)).
CameraPoint moved(const Motion& motion, double time, double x, double y) {
  Vector d{x, y, 1};
  const double nearness = dot(motion.nearness, d);
  for (std::size_t i = 0; i < 3; ++i) d[i] -= time * nearness * motion.step[i];
  return point(turned(times(motion.turn, time), d));
}

// (I - time step nearness^T) is undone by the formula of Sherman and Morrison.
CameraPoint moved_back(const Motion& motion, double time, double x, double y) {
  Vector e = turned(times(motion.turn, -time), {x, y, 1});
  const double along = time * dot(motion.nearness, e) / (1 - time * dot(motion.nearness, motion.step));
  for (std::size_t i = 0; i < 3; ++i) e[i] += along * motion.step[i];
  return point(e);
}

MotionBounds motion_bounds(const Motion& motion, double r2) {
  const double longest = 0.5 * (std::abs(motion.across) + std::abs(motion.down));
  const double near = norm(motion.step) * norm(motion.nearness);
  // With M = exp(time turn) (I - time step nearness^T): |dM / d time| <= rate and |M - I| <= off.
  const double rate = norm(motion.turn) * (1 + longest * near) + near, off = longest * rate;
  // Of d = (x, y, 1) and m = M d, which is projected to (m.x, m.y) / m.z: that projection's derivative is at most
  // slant / depth, and 1 / depth for steps across the axis.
  const double ray = std::sqrt(1 + r2), depth = 1 - off * ray;
  if (!(depth > 0)) return {kUnbounded, kUnbounded, kUnbounded};
  const double slant = ray * (1 + off) / depth;
  return {slant * slant - 1, (1 + slant * off) / depth, slant / depth * rate * ray};
}

}  // namespace gpvc::io
