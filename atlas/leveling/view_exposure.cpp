// Exposure and vignetting per view, fitted to the seams between views.
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

namespace gpvc::atlas {

namespace {

ViewExposure neutral_exposure(const Camera& c) {
  ViewExposure e;
  e.centre_x = c.cx;
  e.centre_y = c.cy;
  // A view that is not textured from may have no photo, and so no size.
  const double diagonal2 = double(c.width) * c.width + double(c.height) * c.height;
  e.inverse_radius2 = diagonal2 > 0 ? 4 / diagonal2 : 0;
  return e;
}

/// nullopt if no sample of the edge counts, or if a channel is too dark or too bright.
std::optional<SeamRatio> ratio_across(const AtlasInput& input, const SeamSamples& seams, const SeamEdge& edge,
                                      std::span<const ViewExposure> neutral) {
  // Sensors quantize and clip: below kDarkest a level is several per cent, and above kBrightest values are unreliable.
  constexpr float kDarkest = 8, kBrightest = 250, kMostWeight = 64;
  std::array<Color, 2> sum;
  std::array<PixelPoint, 2> middle;
  float total = 0;
  for (std::size_t i = edge.first_sample; i < edge.first_sample + edge.samples; ++i) {
    const float w = seams.weight[i];
    for (std::size_t s = 0; s < 2; ++s) {
      sum[s] = sum[s] + w * seams.colors[i][s];
      middle[s].x += double{w} * seams.frame[i][s].x;
      middle[s].y += double{w} * seams.frame[i][s].y;
    }
    total += w;
  }
  if (!(total > 0)) return std::nullopt;
  SeamRatio ratio;
  ratio.weight = double{std::min(total, kMostWeight)};
  for (std::size_t s = 0; s < 2; ++s) {
    const Color c = (1.0f / total) * sum[s];
    ratio.views[s] = static_cast<std::uint32_t>(input.labels[edge.faces[s]]);
    const ViewExposure& e = neutral[ratio.views[s]];
    const double dx = middle[s].x / double{total} - e.centre_x, dy = middle[s].y / double{total} - e.centre_y;
    ratio.r2[s] = (dx * dx + dy * dy) * e.inverse_radius2;
    std::size_t k = 0;
    for (const float value : {c.r, c.g, c.b}) {
      if (!(value >= kDarkest && value <= kBrightest)) return std::nullopt;
      ratio.logs[s][k++] = std::log(value);
    }
  }
  return ratio;
}

/// Unknowns: three log gains for each view, then k1 and k2 for each camera.
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
  Eigen::Index count() const { return static_cast<Eigen::Index>(3 * views + 2 * cameras); }

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

/// \param counts tells which edges count
template <typename Counts>
std::vector<SeamRatio> ratios_across(const AtlasInput& input, const SeamSamples& seams, const Counts& counts) {
  const std::vector<ViewExposure> neutral = neutral_exposures(input.scene);
  std::vector<SeamRatio> ratios;
  for (const SeamEdge& edge : seams.edges)
    if (counts(edge))
      if (const auto ratio = ratio_across(input, seams, edge, neutral)) ratios.push_back(*ratio);
  return ratios;
}

SeamSamples samples_of(const AtlasInput& input) {
  return sample_seams(input, CoverageIndex(input.coverage), find_seams(input));
}

/// The six unknowns, of three for each view, that a channel's equations of a pair of views have.
using PairVector = Eigen::Matrix<double, 6, 1>;
using PairMatrix = Eigen::Matrix<double, 6, 6>;
using PairUnknowns = std::array<int, 6>;

PairUnknowns unknowns_of(const std::array<std::uint32_t, 2>& views, const Unknowns& u, std::size_t channel) {
  return {u.gain(views[0], channel), u.falloff(views[0], 0), u.falloff(views[0], 1),
          u.gain(views[1], channel), u.falloff(views[1], 0), u.falloff(views[1], 1)};
}

/// One equation of the least-squares problem: that the logs of both sides agree once corrected.
struct Row {
  Row(const SeamRatio& ratio, std::size_t channel) : rest(ratio.logs[0][channel] - ratio.logs[1][channel]) {
    const auto [r2, s2] = ratio.r2;
    factors << 1, r2, r2 * r2, -1, -s2, -s2 * s2;
  }
  double residual(const PairVector& x) const { return rest + factors.dot(x); }

  PairVector factors;
  double rest;
};

/// The normal equations of weighted rows; the matrix by its lower triangle.
class NormalEquations {
 public:
  explicit NormalEquations(Eigen::Index unknowns) : right_(Eigen::VectorXd::Zero(unknowns)) {}

  /// Draws an unknown towards zero.
  void add_anchor(int unknown, double weight) { entries_.emplace_back(unknown, unknown, weight); }

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

/// Anchors decide only what seams leave open: the brightness of all views together, and the fall-off where seams lie at
/// equal radii. With a thousandth of the data's weight they bias the rest by as much. No view has a smaller share than
/// a face in ten thousand, so that none is free.
void add_anchors(NormalEquations& equations, const Unknowns& u, std::span<const double> share, double weight) {
  for (std::uint32_t v = 0; v < u.views; ++v)
    for (std::size_t c = 0; c < 3; ++c) equations.add_anchor(u.gain(v, c), weight * std::max(1e-4, share[v]));
  for (Eigen::Index i = static_cast<Eigen::Index>(3 * u.views); i < u.count(); ++i)
    equations.add_anchor(static_cast<int>(i), weight);
}

/// What a weight is divided by in iteratively reweighted least squares. Ratios that are off by more than 10 % come from
/// parallax, highlights or moving objects. Cauchy weights, except in the first round: its residuals are the exposures
/// themselves, so its weights fall more slowly.
double robust_divisor(double error, int round) {
  constexpr double kOutlyingRatio = 0.1;
  const double r = error / kOutlyingRatio;
  return 1 + (round == 0 ? std::abs(r) : r * r);
}

/// Adds the equations of the ratios between a pair of views, weighted by what x leaves of them.
void add_pair(NormalEquations& equations, std::span<const SeamRatio> ratios, const Unknowns& u,
              const Eigen::VectorXd& x, int round) {
  for (std::size_t c = 0; c < 3; ++c) {
    const PairUnknowns at = unknowns_of(ratios.front().views, u, c);
    PairVector before, rest = PairVector::Zero();
    PairMatrix matrix = PairMatrix::Zero();
    for (std::size_t i = 0; i < at.size(); ++i) before[static_cast<Eigen::Index>(i)] = x[at[i]];
    for (const SeamRatio& ratio : ratios) {
      const Row row(ratio, c);
      const PairVector weighted = ratio.weight / robust_divisor(row.residual(before), round) * row.factors;
      matrix += weighted * row.factors.transpose();
      rest += row.rest * weighted;
    }
    equations.add(at, matrix, rest);
  }
}

Eigen::VectorXd solve(std::vector<SeamRatio> ratios, const Unknowns& u, std::span<const double> share) {
  constexpr int kRounds = 10;
  double total = 0;
  for (const auto& r : ratios) total += r.weight;
  // Thousands of ratios of a pair of views add up in the same places of the matrix.
  std::ranges::stable_sort(ratios, {}, &SeamRatio::views);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(u.count());
  for (int round = 0; round < kRounds; ++round) {
    NormalEquations equations(u.count());
    add_anchors(equations, u, share, 1e-3 * total);
    for (auto begin = ratios.begin(); begin != ratios.end();) {
      const auto end = std::ranges::upper_bound(begin, ratios.end(), begin->views, {}, &SeamRatio::views);
      add_pair(equations, {begin, end}, u, x, round);
      begin = end;
    }
    std::optional<Eigen::VectorXd> solution = equations.solve();
    if (!solution) return x;
    x = std::move(*solution);
  }
  return x;
}

}  // namespace

std::vector<ViewExposure> fit_exposure(const AtlasInput& input) { return fit_exposure(input, samples_of(input)); }

std::vector<ViewExposure> fit_exposure(const AtlasInput& input, const SeamSamples& seams) {
  return fit_exposure(input.scene, ratios_across(input, seams, [](const SeamEdge&) { return true; }),
                      faces_of_views(input));
}

std::vector<SeamRatio> seam_ratios(const AtlasInput& input) {
  return ratios_across(input, samples_of(input), [&](const SeamEdge& edge) {
    return input.border.empty() || input.border[std::min(edge.faces[0], edge.faces[1])] == 0;
  });
}

std::vector<ViewExposure> fit_exposure(const Scene& scene, std::vector<SeamRatio> ratios,
                                       std::span<const std::size_t> faces) {
  std::vector<ViewExposure> exposure = neutral_exposures(scene);
  if (ratios.empty()) return exposure;
  const Unknowns u(scene);
  const Eigen::VectorXd x = solve(std::move(ratios), u, shares(faces));
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
