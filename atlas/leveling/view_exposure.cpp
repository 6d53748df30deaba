// Exposure and vignetting per view, fitted to seams between views and to what overlapping views show.
//
// Neither can tell gains that rise evenly from photo to photo from surfaces that are brighter with the sun behind the camera, as
// fields are: in both cases the next photo shows the same place a little brighter. Taken for gains, a per cent from photo to photo would make
// one end of a flight twice as bright as the other. So the fit has a term for the direction of sight, which takes such a trend and is not
// applied, and photos are held to the brightness that they were made with, corrected by what their EXIF data say of their exposure, over
// more than a few seams.
#include <tbb/parallel_for.h>

#include <Eigen/QR>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "atlas/leveling/seam_leveling.h"
#include "io/order_statistics.h"

namespace gpvc::atlas {

namespace {

using Logs = std::array<double, 3>;  ///< per channel

/// Errors of seams add up over so many photos in a row; beyond, the prior holds gains to the photos' own brightness. kWideReach: for
/// the first rounds, which have no such prior. Of 30, 8, 4 and 3, 4 is best or close to it by the colours of photos held out of three scenes, and by flights whose gains wander. Across a few photos,
/// the square root of their number, little adds up, and the reach is longer.
constexpr double kReach = 4, kWideReach = 32;

ViewExposure neutral_exposure(const Camera& c) {
  ViewExposure e;
  e.centre_x = c.cx;
  e.centre_y = c.cy;
  // A view that is not textured from may have no photo, and so no size.
  const double diagonal2 = double(c.width) * c.width + double(c.height) * c.height;
  e.inverse_radius2 = diagonal2 > 0 ? 4 / diagonal2 : 0;
  return e;
}

/// Unknowns: three log gains for each view, then k1 and k2 for each camera, then a vector of the world whose product with the
/// direction of sight, one unit along the view's axis, is the log by which colours are darker for where they are seen from.
struct Unknowns {
  explicit Unknowns(const Scene& scene) : views(scene.views.size()) {
    std::map<std::tuple<int, int, double, double>, std::size_t> numbers;
    for (const View& view : scene.views) {
      const Camera& c = view.camera;
      camera_of_view.push_back(numbers.try_emplace({c.width, c.height, c.fx, c.fy}, numbers.size()).first->second);
    }
    cameras = numbers.size();
  }
  int gain(std::uint32_t view, std::size_t channel) const { return static_cast<int>(3 * view + channel); }
  int falloff(std::uint32_t view, std::size_t k) const {
    return static_cast<int>(3 * views + 2 * camera_of_view[view] + k);
  }
  int sight(std::size_t axis) const { return static_cast<int>(3 * views + 2 * cameras + axis); }
  Eigen::Index count() const { return static_cast<Eigen::Index>(3 * views + 2 * cameras + 3); }

  std::vector<std::size_t> camera_of_view;
  std::size_t views, cameras = 0;
};

/// How many faces each view has.
std::vector<std::size_t> faces_of_views(const AtlasInput& input) {
  std::vector<std::size_t> faces(input.scene.views.size(), 0);
  for (const ViewId label : input.labels)
    if (label != kNoView) ++faces[index(label)];
  return faces;
}

/// The share of all labelled faces that each view has.
std::vector<double> shares(std::span<const std::size_t> faces) {
  const auto total = static_cast<double>(std::accumulate(faces.begin(), faces.end(), std::size_t{0}));
  std::vector<double> share;
  for (const std::size_t count : faces) share.push_back(total > 0 ? static_cast<double>(count) / total : 0);
  return share;
}

std::vector<ViewExposure> neutral_exposures(const Scene& scene) {
  std::vector<ViewExposure> exposure;
  for (const View& view : scene.views) exposure.push_back(neutral_exposure(view.camera));
  return exposure;
}

/// The nine unknowns, of three for each view and three for all, that a channel's equations of a pair of views have.
using PairVector = Eigen::Matrix<double, 9, 1>;
using PairMatrix = Eigen::Matrix<double, 9, 9>;
using PairUnknowns = std::array<int, 9>;

PairUnknowns unknowns_of(const std::array<std::uint32_t, 2>& views, const Unknowns& u, std::size_t channel) {
  return {u.gain(views[0], channel),
          u.falloff(views[0], 0),
          u.falloff(views[0], 1),
          u.gain(views[1], channel),
          u.falloff(views[1], 0),
          u.falloff(views[1], 1),
          u.sight(0),
          u.sight(1),
          u.sight(2)};
}

/// The view's axes, as rows.
Eigen::Matrix3d camera_from_world(const View& view) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(view.pose.rotation.data());
}

/// What a pair's unknowns contribute to the difference of the corrections on the two sides, in logarithms.
PairVector factors_of(const Scene& scene, const ColorRatio& ratio) {
  PairVector factors = PairVector::Zero();
  for (std::size_t s = 0; s < 2; ++s) {
    const View& view = scene.views[ratio.views[s]];
    const Camera& c = view.camera;
    const double dx = ratio.at[s][0] - c.cx, dy = ratio.at[s][1] - c.cy, sign = s == 0 ? 1 : -1;
    const double r2 = (dx * dx + dy * dy) * neutral_exposure(c).inverse_radius2;
    factors.segment<3>(static_cast<Eigen::Index>(3 * s)) << sign, sign * r2, sign * r2 * r2;
    factors.tail<3>() += sign * (camera_from_world(view).transpose() * Eigen::Vector3d(dx / c.fx, dy / c.fy, 1));
  }
  return factors;
}

/// The normal equations of weighted rows; the matrix by its lower triangle.
class NormalEquations {
 public:
  explicit NormalEquations(Eigen::Index unknowns) : right_(Eigen::VectorXd::Zero(unknowns)) {}

  /// Draws an unknown towards a value.
  void add_anchor(int unknown, double weight, double value = 0) {
    entries_.emplace_back(unknown, unknown, weight);
    right_[unknown] += weight * value;
  }

  /// Adds the sums over the rows of a pair: weight factors factors^T, and weight factors rest.
  void add(const PairUnknowns& at, const PairMatrix& matrix, const PairVector& rest) {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      right_[at[i]] -= rest[row];
      for (std::size_t j = 0; j < at.size(); ++j)
        if (at[j] <= at[i]) entries_.emplace_back(at[i], at[j], matrix(row, static_cast<Eigen::Index>(j)));
    }
  }

  std::optional<Eigen::VectorXd> solve() const {
    Eigen::SparseMatrix<double> matrix(right_.size(), right_.size());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(matrix);
    if (solver.info() != Eigen::Success) return std::nullopt;
    return solver.solve(right_);
  }

 private:
  Eigen::VectorXd right_;
  std::vector<Eigen::Triplet<double>> entries_;
};

/// The gains that are expected without any seam: none, so that photos keep their own brightness, except for what
/// expected_gains() finds to be exposure.
struct Prior {
  double reach = kWideReach;   ///< photos in a line, over which seams hold against the prior
  std::vector<double> weight;  ///< per view, of the ratios across its seams
  std::vector<Logs> expected;  ///< per view, the logarithms of its gains
};

/// Anchors draw each gain to the expected one, with a share of the weight of the view's seams. Errors of seams then add up over
/// `reach` photos and not over the whole flight: in a line of photos with a seam between each two, a disturbance fades to 1 / e over
/// 1 / sqrt(2 share) photos. A view without seams has the least weight that keeps the matrix regular. The anchor of the fall-off decides
/// where all seams lie at equal radii.
void add_anchors(NormalEquations& equations, const Unknowns& u, const Prior& prior, double total) {
  const double share = 1 / (2 * prior.reach * prior.reach);
  for (std::uint32_t v = 0; v < u.views; ++v)
    for (std::size_t c = 0; c < 3; ++c)
      equations.add_anchor(u.gain(v, c), std::max(1e-7 * total, share * prior.weight[v]), prior.expected[v][c]);
  for (int i = static_cast<int>(3 * u.views); i < u.sight(0); ++i) equations.add_anchor(i, 1e-3 * total);
  // As heavy as a single view's seams, so that many photos whose gains rise from one to the next are explained by the direction of
  // sight, and a few are not.
  for (std::size_t axis = 0; axis < 3; ++axis)
    equations.add_anchor(u.sight(axis), 2 * total / static_cast<double>(std::max<std::size_t>(u.views, 1)));
}

/// What a weight is divided by in iteratively reweighted least squares. Ratios that are off by more than 10 % come from
/// parallax, highlights or moving objects. Cauchy weights, except in the first round: its residuals are the exposures
/// themselves, so its weights fall more slowly.
double robust_divisor(double error, int round) {
  constexpr double kOutlyingRatio = 0.1;
  const double r = error / kOutlyingRatio;
  return 1 + (round == 0 ? std::abs(r) : r * r);
}

/// The equations of the ratios between a pair of views, per channel: the corrected logs of both sides are equal.
struct PairSums {
  PairVector rest = PairVector::Zero();
  PairMatrix matrix = PairMatrix::Zero();
};

/// Their weights follow from the residuals that x leaves.
std::array<PairSums, 3> sum_pair(const Scene& scene, std::span<const ColorRatio> ratios, const Unknowns& u,
                                 const Eigen::VectorXd& x, int round) {
  std::array<PairSums, 3> channels;
  std::array<PairVector, 3> before;
  for (std::size_t c = 0; c < 3; ++c) {
    const PairUnknowns at = unknowns_of(ratios.front().views, u, c);
    for (std::size_t i = 0; i < at.size(); ++i) before[c][static_cast<Eigen::Index>(i)] = x[at[i]];
  }
  for (const ColorRatio& ratio : ratios) {
    const PairVector factors = factors_of(scene, ratio);
    for (std::size_t c = 0; c < 3; ++c) {
      const double rest = ratio.logs[0][c] - ratio.logs[1][c];
      const PairVector weighted = ratio.weight / robust_divisor(rest + factors.dot(before[c]), round) * factors;
      channels[c].matrix += weighted * factors.transpose();
      channels[c].rest += rest * weighted;
    }
  }
  return channels;
}

/// The ratios of each pair of views. \pre those of a pair are beside each other
std::vector<std::span<const ColorRatio>> pairs_of(std::span<const ColorRatio> ratios) {
  std::vector<std::span<const ColorRatio>> pairs;
  for (auto begin = ratios.begin(); begin != ratios.end();) {
    const auto end = std::upper_bound(begin, ratios.end(), *begin,
                                      [](const ColorRatio& a, const ColorRatio& b) { return a.views < b.views; });
    pairs.emplace_back(begin, end);
    begin = end;
  }
  return pairs;
}

/// How bright each view is along its seams, as logarithms, less the median view's.
std::vector<Logs> brightness(std::span<const ColorRatio> ratios, std::size_t views) {
  std::vector<Logs> sum(views, Logs{});
  std::vector<double> weight(views, 0);
  for (const ColorRatio& ratio : ratios)
    for (std::size_t s = 0; s < 2; ++s) {
      weight[ratio.views[s]] += ratio.weight;
      for (std::size_t c = 0; c < 3; ++c) sum[ratio.views[s]][c] += ratio.weight * ratio.logs[s][c];
    }
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> known;
    for (std::size_t v = 0; v < views; ++v)
      if (weight[v] > 0) known.push_back(sum[v][c] /= weight[v]);
    if (known.empty()) continue;
    const double middle = upper_median(std::span(known));
    for (std::size_t v = 0; v < views; ++v) sum[v][c] = weight[v] > 0 ? sum[v][c] - middle : 0;
  }
  return sum;
}

/// How much less light each photo was taken with than their mean, as a logarithm, by their EXIF data; empty unless all photos with
/// seams have them.
std::vector<double> missing_light(const Scene& scene, std::span<const double> weight) {
  std::vector<double> light(weight.size(), 0);
  double sum = 0, total = 0;
  for (std::size_t v = 0; v < weight.size(); ++v) {
    if (!(weight[v] > 0)) continue;
    if (!scene.views[v].exposure_value) return {};
    light[v] = std::log(2.0) * static_cast<double>(*scene.views[v].exposure_value);
    sum += weight[v] * light[v];
    total += weight[v];
  }
  for (std::size_t v = 0; v < weight.size(); ++v)
    if (weight[v] > 0) light[v] -= sum / total;
  return light;
}

/// What is expected of the slope by which gains rise with something known of the photos, before gains are looked at; it counts as much
/// as photos would in which the known has this mean square.
struct ExpectedSlope {
  double slope = 0, mean_square = 0;
};
/// A photo that is brighter by itself may show bright things, or not.
constexpr ExpectedSlope kOfBrightness{};
/// Grey levels are about the 2.2th root of light, and cameras' curves are steeper in the middle. Differences of a fifth of a stop tell
/// for themselves.
constexpr ExpectedSlope kOfLight{1 / 2.2, 0.15 * 0.15};

/// Slope in [0, 1] by which gains rise with `known`, per view. A linear trend over the scene is removed from both first, as seams do
/// not tell whether it is a gain or the direction of sight.
double gain_slope(const Scene& scene, std::span<const double> weight, std::span<const double> known,
                  std::span<const double> gains, const ExpectedSlope& expected) {
  const auto views = static_cast<Eigen::Index>(weight.size());
  Eigen::MatrixXd even(views, 4), values(views, 2);
  for (Eigen::Index v = 0; v < views; ++v) {
    const auto view = static_cast<std::size_t>(v);
    const double root = std::sqrt(weight[view]);
    const WorldPoint& at = scene.views[view].pose.centre;
    even.row(v) = root * Eigen::RowVector4d(1, at.x - scene.views[0].pose.centre.x, at.y - scene.views[0].pose.centre.y,
                                            at.z - scene.views[0].pose.centre.z);
    values.row(v) = root * Eigen::RowVector2d(gains[view], known[view]);
  }
  // Of few photos nothing is left but rounding.
  constexpr double kRounding = 1e-9;
  const double all = values.col(1).squaredNorm();
  values -= even * even.completeOrthogonalDecomposition().solve(values);
  const double found = values.col(1).squaredNorm(), squares = found > kRounding * all ? found : 0;
  const double prior = expected.mean_square * std::accumulate(weight.begin(), weight.end(), 0.0);
  if (!(squares + prior > 0)) return 0;
  const double product = squares > 0 ? values.col(0).dot(values.col(1)) : 0;
  return std::clamp((product + prior * expected.slope) / (squares + prior), 0.0, 1.0);
}

/// The gains that the photos' EXIF data and their own brightness make likely, as far as gains that seams have found rise with them.
std::vector<Logs> expected_gains(const Scene& scene, std::span<const ColorRatio> ratios, std::span<const double> weight,
                                 const Unknowns& u, const Eigen::VectorXd& x) {
  std::vector<Logs> expected(u.views, Logs{});
  const std::vector<double> light = missing_light(scene, weight);
  const std::vector<Logs> bright = brightness(ratios, u.views);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> gains(u.views), dark(u.views);
    for (std::size_t v = 0; v < u.views; ++v) {
      gains[v] = x[u.gain(static_cast<std::uint32_t>(v), c)];
      dark[v] = -bright[v][c];
    }
    const auto explain = [&](std::span<const double> known, const ExpectedSlope& slope_before) {
      const double slope = gain_slope(scene, weight, known, gains, slope_before);
      for (std::size_t v = 0; v < u.views; ++v) {
        expected[v][c] += slope * known[v];
        gains[v] -= slope * known[v];
      }
      return slope;
    };
    if (!light.empty()) {
      const double slope = explain(light, kOfLight);
      for (std::size_t v = 0; v < u.views; ++v) dark[v] -= slope * light[v];
    }
    explain(dark, kOfBrightness);
  }
  return expected;
}

/// Iteratively reweighted least squares from `x` on.
void improve(const Scene& scene, std::span<const ColorRatio> ratios, const Unknowns& u, const Prior& prior,
             double total, int first_round, int end_round, Eigen::VectorXd& x) {
  const std::vector<std::span<const ColorRatio>> pairs = pairs_of(ratios);
  std::vector<std::array<PairSums, 3>> sums(pairs.size());
  for (int round = first_round; round < end_round; ++round) {
    NormalEquations equations(u.count());
    add_anchors(equations, u, prior, total);
    tbb::parallel_for(std::size_t{0}, pairs.size(),
                      [&](std::size_t p) { sums[p] = sum_pair(scene, pairs[p], u, x, round); });
    for (std::size_t p = 0; p < pairs.size(); ++p)
      for (std::size_t c = 0; c < 3; ++c)
        equations.add(unknowns_of(pairs[p].front().views, u, c), sums[p][c].matrix, sums[p][c].rest);
    std::optional<Eigen::VectorXd> solution = equations.solve();
    if (!solution) return;
    x = std::move(*solution);
  }
}

Eigen::VectorXd solve(const Scene& scene, std::vector<ColorRatio> ratios, const Unknowns& u) {
  // The first rounds have a weak prior: their gains tell how much of the photos' brightness is exposure.
  constexpr int kRounds = 10, kFirstRounds = 5;
  double total = 0;
  Prior prior;
  prior.weight.assign(u.views, 0);
  prior.expected.assign(u.views, Logs{});
  for (const auto& r : ratios) {
    total += r.weight;
    for (const std::uint32_t view : r.views) prior.weight[view] += r.weight;
  }
  // Thousands of ratios of a pair of views add up in the same places of the matrix.
  std::ranges::stable_sort(ratios, {}, &ColorRatio::views);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(u.count());
  improve(scene, ratios, u, prior, total, 0, kFirstRounds, x);
  prior.expected = expected_gains(scene, ratios, prior.weight, u, x);
  prior.reach = std::max(kReach, kWideReach / std::sqrt(static_cast<double>(u.views)));
  improve(scene, ratios, u, prior, total, kFirstRounds, kRounds, x);
  return x;
}

/// Adds to all gains of a channel so that their mean, weighed by the views' shares of the faces, is zero.
void centre_gains(const Unknowns& u, std::span<const double> share, Eigen::VectorXd& x) {
  for (std::size_t c = 0; c < 3; ++c) {
    double mean = 0;
    for (std::uint32_t v = 0; v < u.views; ++v) mean += share[v] * x[u.gain(v, c)];
    for (std::uint32_t v = 0; v < u.views; ++v) x[u.gain(v, c)] -= mean;
  }
}

}  // namespace

std::vector<ViewExposure> fit_exposure(const AtlasInput& input) {
  OverlapRatios overlaps(input);
  const SeamSamples seams =
      sample_seams(input, CoverageIndex(input.coverage), find_seams(input), {.overlaps = &overlaps});
  return fit_exposure(input, seams, overlaps);
}

std::vector<ViewExposure> fit_exposure(const AtlasInput& input, const SeamSamples& seams,
                                       const OverlapRatios& overlaps) {
  return fit_exposure(input.scene, color_ratios(input, seams, overlaps), faces_of_views(input));
}

std::vector<ViewExposure> fit_exposure(const Scene& scene, std::vector<ColorRatio> ratios,
                                       std::span<const std::size_t> faces) {
  std::vector<ViewExposure> exposure = neutral_exposures(scene);
  if (ratios.empty()) return exposure;
  const Unknowns u(scene);
  Eigen::VectorXd x = solve(scene, std::move(ratios), u);
  centre_gains(u, shares(faces), x);
  const double most = std::log(kMostGain);
  for (std::uint32_t v = 0; v < exposure.size(); ++v) {
    const auto gain = [&](std::size_t c) {
      return static_cast<float>(std::exp(std::clamp(x[u.gain(v, c)], -most, most)));
    };
    exposure[v].gain = {gain(0), gain(1), gain(2)};
    exposure[v].k1 = x[u.falloff(v, 0)];
    exposure[v].k2 = x[u.falloff(v, 1)];
  }
  return exposure;
}

bool is_sound(const ViewExposure& exposure) {
  return std::ranges::all_of(exposure.gain, [](float gain) { return gain > 0 && double{gain} <= kMostGain; }) &&
         std::isfinite(exposure.centre_x + exposure.centre_y + exposure.k1 + exposure.k2) &&
         std::isfinite(exposure.inverse_radius2) && exposure.inverse_radius2 >= 0;
}

}  // namespace gpvc::atlas
