// How far a lens model holds, and how much it can stretch.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "io/lens/lens.h"
#include "io/lens/motion.h"
#include "io/lens/spherical.h"
#include "io/lens_terms.h"

namespace gpvc {

namespace {

/// Coefficients by ascending power.
using Polynomial = std::vector<double>;

double value(const Polynomial& p, double s) {
  double sum = 0;
  for (std::size_t i = p.size(); i > 0; --i) sum = sum * s + p[i - 1];
  return sum;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial out;
  for (std::size_t i = 1; i < p.size(); ++i) out.push_back(static_cast<double>(i) * p[i]);
  return out;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial out(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) out[i + j] += a[i] * b[j];
  return out;
}

/// `p` monotone over [low, high], of different signs there (zero counts as the sign of `high`): the last number that
/// still has the sign of `low`.
double last_before_change(const Polynomial& p, double low, double high) {
  const bool positive = value(p, low) > 0;
  for (;;) {
    const double middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) return low;
    ((value(p, middle) > 0) == positive ? low : high) = middle;
  }
}

/// The positive places where `p` changes sign, ascending. Between those of its derivative it is monotone.
std::vector<double> sign_changes(Polynomial p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
  std::vector<double> changes;
  if (p.size() < 2) return changes;
  std::vector<double> ends = sign_changes(derivative(p));
  // Past the last turn the highest power decides; 1e100 stands for infinity.
  ends.push_back(1e100);
  double low = 0;
  for (const double high : ends) {
    if (high > low && (value(p, low) > 0) != (value(p, high) > 0)) changes.push_back(last_before_change(p, low, high));
    low = high;
  }
  return changes;
}

/// The last s before `p`, positive at 0, first falls to or below zero; infinity where it never does.
double first_fall(const Polynomial& p) {
  std::vector<double> turns = sign_changes(derivative(p));
  turns.push_back(1e100);
  double low = 0;
  for (const double high : turns) {
    if (!(value(p, high) > 0)) return last_before_change(p, low, high);
    low = high;
  }
  return io::kUnbounded;
}

Polynomial above(const Distortion& d) { return {1, d.k1, d.k2, d.k3, d.k4, d.k5, d.k6}; }
Polynomial below(const Distortion& d) { return {1, d.d1, d.d2, d.d3}; }

Polynomial absolute(Polynomial p) {
  for (double& c : p) c = std::abs(c);
  return p;
}

/// The squared radius after LensModel's factor at which the radial terms stop to grow or their divisor vanishes. \pre
/// !is_bare(d.model)
double fold_of_terms(const Distortion& d) {
  // With s = q^2, d/dq of q N(s) / D(s) is ((N + 2 s N') D - 2 s N D') / D^2.
  const Polynomial n = above(d), m = d.model == LensModel::brown ? Polynomial{1} : below(d);
  Polynomial grown = n;
  for (std::size_t i = 0; i < n.size(); ++i) grown[i] *= static_cast<double>(2 * i + 1);
  Polynomial slope = product(grown, m);
  Polynomial turned(m.size());
  for (std::size_t i = 0; i < m.size(); ++i) turned[i] = static_cast<double>(2 * i) * m[i];
  const Polynomial less = product(n, turned);
  for (std::size_t i = 0; i < slope.size(); ++i) slope[i] -= less[i];
  return std::min(first_fall(slope), first_fall(m));
}

/// The angle up to which the radius of LensModel::fisheye_polynomial grows.
double last_bent_angle(const Distortion& d) { return first_fall({1, 2 * d.a1, 3 * d.a2, 4 * d.a3}); }

/// largest_stretch() of a camera that stands still.
double lens_stretch(const Camera& camera, double r2);

/// The place in the photo is F(d, time) with d the point of the plane and time = T(place), so |d place / d d| is at most
/// |dF / dd| / (1 - |dF / dtime| |dT|).
double moving_stretch(const Camera& camera, double r2) {
  const Motion& motion = camera.distortion.motion;
  const io::MotionBounds bounds = io::motion_bounds(motion, r2);
  if (!(bounds.r2 <= camera.distortion.max_r2)) return io::kUnbounded;
  const double lens = lens_stretch(camera, bounds.r2);
  const double pixels_per_time = lens * std::max(camera.fx, camera.fy) * bounds.speed;
  const double feedback = pixels_per_time * std::hypot(motion.across / camera.width, motion.down / camera.height);
  return feedback < 1 ? lens * bounds.stretch / (1 - feedback) : io::kUnbounded;
}

}  // namespace

void limit_distortion(Camera& camera) {
  Distortion& d = camera.distortion;
  d.max_r2 = Distortion{}.max_r2;
  if (d.model == LensModel::perspective && std::all_of(std::begin(kLensTerms) + kBrownTerms, std::end(kLensTerms),
                                                       [&](const LensTerm& further) { return d.*further.term == 0; }))
    d.model = LensModel::brown;
  if (is_spherical(d.model)) {
    d.max_r2 = io::kSphericalReach2;
    return;
  }
  double fold = io::kUnbounded;  // squared radius after the lens model's factor
  if (d.model == LensModel::inverse_radial) {
    // r = q + k1 q^3 grows up to q^2 = -1 / (3 k1).
    if (d.k1 < 0) fold = -1 / (3 * d.k1);
  } else if (d.model == LensModel::division) {
    // r = q / (1 + k1 q^2) grows up to q^2 = 1 / k1.
    if (d.k1 > 0) fold = 1 / d.k1;
  } else if (d.model == LensModel::fisheye_polynomial) {
    // Its radius grows with the angle up to here; at and behind 90 degrees the plane ends.
    const double last = last_bent_angle(d);
    if (last < std::numbers::pi / 2) d.max_r2 = std::min(std::tan(last) * std::tan(last), d.max_r2);
    return;
  } else if (!io::is_bare(d.model)) {
    fold = fold_of_terms(d);
  }
  if (fold < 1e100) d.max_r2 = std::min(io::undo_lens_factor(d, fold), d.max_r2);
}

double io::largest_angle(const Distortion& d) {
  double last = last_bent_angle(d);
  if (d.model != LensModel::fisheye_polynomial)
    last = io::angle_of_radius(d, std::sqrt(fold_of_terms(d)), io::kUnbounded).value_or(io::kUnbounded);
  return std::min(last, std::numbers::pi);
}

double largest_stretch(const Camera& camera, double r2) {
  if (camera.distortion.looks_aside()) return io::kUnbounded;
  return camera.distortion.motion.moves() ? moving_stretch(camera, r2) : lens_stretch(camera, r2);
}

namespace {

double lens_stretch(const Camera& camera, double r2) {
  const Distortion& d = camera.distortion;
  const double pixels = std::max(camera.fx / camera.fy, camera.fy / camera.fx);
  // A step on the plane is longer than on the sphere by 1 / cos(t) across and by 1 / cos(t)^2 outwards, with t the angle
  // from the axis, and in longitude it is longer than on the sphere by 1 / cos(latitude), at most 1 / cos(t). About a
  // pole, there is no bound.
  if (is_spherical(d.model)) return shows_pole(d.model) ? io::kUnbounded : pixels;
  const io::LensFactor lens = io::lens_factor(d, r2);
  const double s = r2 * lens.factor * lens.factor;
  // The factor bends a step across by `factor` and a step outwards by factor + r2 slope. Both are largest at the
  // centre, except for inverse_radial with k1 < 0 and division with k1 > 0, where they are largest at the rim.
  const io::LensFactor centre = io::lens_factor(d, 0);
  double bent = std::max({centre.factor, lens.factor, lens.factor + r2 * lens.slope});
  // Of a polynomial of the angle neither need be: theta / r and d theta / d r are at most 1, the rest is bounded by the
  // polynomial's slope with all its terms positive.
  if (d.model == LensModel::fisheye_polynomial)
    bent = value(absolute({1, 2 * d.a1, 3 * d.a2, 4 * d.a3}), std::atan(std::sqrt(r2)));
  if (io::is_bare(d.model)) return std::isfinite(bent) ? bent * pixels : io::kUnbounded;

  const bool all = d.model != LensModel::brown;
  const Polynomial n = absolute(above(d));
  const double high = value(n, s), high_slope = value(derivative(n), s);
  double low = 1, low_slope = 0;
  if (all) {
    const Polynomial m = absolute(below(d));
    low = 2 - value(m, s);
    low_slope = value(derivative(m), s);
    if (!(low > 0)) return io::kUnbounded;
  }
  const double radial = high / low + 2 * s * (high_slope / low + high * low_slope / (low * low));
  // The point that the tangential and prism terms act on: the undistorted one or, for fisheye_624, the radial one.
  const bool behind = d.model == LensModel::fisheye_624;
  const double fs = behind ? s * high * high : s, fq = std::sqrt(fs);
  // Each entry of the tangential part's derivative is at most 6 (|p1| + |p2|) q, the part itself at most sqrt(10) (|p1|
  // + |p2|) s.
  const double p = std::abs(d.p1) + std::abs(d.p2);
  double further = 12 * p * fq, skew = 0;
  if (all) {
    further = further * (1 + std::abs(d.p3) * fs + std::abs(d.p4) * fs * fs) +
              4 * p * fs * 2 * fq * (std::abs(d.p3) + 2 * std::abs(d.p4) * fs) +
              2 * fq * (std::hypot(d.s1, d.s2) + 2 * fs * std::hypot(d.s3, d.s4));
    skew = std::abs(d.skew);
  }
  const double both = behind ? radial * (1 + further) : radial + further;
  return bent * both * (1 + skew) * pixels;
}

}  // namespace
}  // namespace gpvc
