// Exposure and vignetting per view, fitted to the seams between views.
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "atlas/leveling/seam_leveling.h"

namespace gpvc::atlas {

namespace {

/// The colour ratio across a seam edge.
struct Ratio {
  std::array<std::uint32_t, 2> views{};
  std::array<std::array<double, 3>, 2> logs{};  ///< of the mean colour on each side, per channel
  std::array<double, 2> r2{};                   ///< squared radius of the edge's middle in each frame
  double weight = 0;
};

ViewExposure neutral_exposure(const Camera& c) {
  ViewExposure e;
  e.centre_x = c.cx;
  e.centre_y = c.cy;
  e.inverse_radius2 = 4 / (double(c.width) * c.width + double(c.height) * c.height);
  return e;
}

/// nullopt if no sample of the edge counts, or if a channel is too dark or too bright.
std::optional<Ratio> ratio_across(const AtlasInput& input, const SeamSamples& seams, const SeamEdge& edge,
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
  Ratio ratio;
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

/// The share of labelled faces that each view has.
std::vector<double> shares(const AtlasInput& input) {
  std::vector<double> share(input.scene.views.size(), 0.0);
  double total = 0;
  for (const auto label : input.labels) {
    if (label == kNoView) continue;
    share[index(label)] += 1;
    total += 1;
  }
  for (auto& s : share) s = total > 0 ? s / total : 0;
  return share;
}

/// One equation of the least-squares problem: that the logs of both sides agree once corrected.
struct Row {
  Row(const Ratio& ratio, const Unknowns& u, std::size_t channel) {
    std::size_t n = 0;
    for (std::size_t s = 0; s < 2; ++s) {
      const double sign = s ? -1 : 1, r2 = ratio.r2[s];
      entries[n++] = {u.gain(ratio.views[s], channel), sign};
      entries[n++] = {u.falloff(ratio.views[s], 0), sign * r2};
      entries[n++] = {u.falloff(ratio.views[s], 1), sign * r2 * r2};
      rest += sign * ratio.logs[s][channel];
    }
  }
  double residual(const Eigen::VectorXd& x) const {
    double r = rest;
    for (const auto& [i, a] : entries) r += a * x[i];
    return r;
  }

  std::array<std::pair<int, double>, 6> entries;
  double rest = 0;
};

/// The normal equations of weighted rows; the matrix by its lower triangle.
class NormalEquations {
 public:
  explicit NormalEquations(Eigen::Index unknowns) : matrix_(unknowns, unknowns), right_(unknowns) { right_.setZero(); }

  /// Draws an unknown towards zero.
  void add_anchor(int unknown, double weight) { entries_.emplace_back(unknown, unknown, weight); }

  void add(const Row& row, double weight) {
    for (const auto& [i, a] : row.entries) {
      right_[i] -= weight * a * row.rest;
      for (const auto& [j, b] : row.entries)
        if (j <= i) entries_.emplace_back(i, j, weight * a * b);
    }
  }

  /// To be called now and then: some sixty entries per seam edge add up to few places of the matrix.
  void compact_if_long() {
    constexpr std::size_t kLong = std::size_t{1} << 20;
    if (entries_.size() >= kLong) compact();
  }

  std::optional<Eigen::VectorXd> solve() {
    compact();
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(matrix_);
    if (solver.info() != Eigen::Success) return std::nullopt;
    return solver.solve(right_);
  }

 private:
  void compact() {
    Eigen::SparseMatrix<double> part(matrix_.rows(), matrix_.cols());
    part.setFromTriplets(entries_.begin(), entries_.end());
    matrix_ += part;
    entries_.clear();
  }

  Eigen::SparseMatrix<double> matrix_;
  Eigen::VectorXd right_;
  std::vector<Eigen::Triplet<double>> entries_;  ///< not in the matrix yet
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

Eigen::VectorXd solve(const std::vector<Ratio>& ratios, const Unknowns& u, std::span<const double> share) {
  constexpr int kRounds = 10;
  double total = 0;
  for (const auto& r : ratios) total += r.weight;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(u.count());
  for (int round = 0; round < kRounds; ++round) {
    NormalEquations equations(u.count());
    add_anchors(equations, u, share, 1e-3 * total);
    for (const Ratio& ratio : ratios) {
      equations.compact_if_long();
      for (std::size_t c = 0; c < 3; ++c) {
        const Row row(ratio, u, c);
        equations.add(row, ratio.weight / robust_divisor(row.residual(x), round));
      }
    }
    std::optional<Eigen::VectorXd> solution = equations.solve();
    if (!solution) return x;
    x = std::move(*solution);
  }
  return x;
}

}  // namespace

std::vector<ViewExposure> fit_exposure(const AtlasInput& input) {
  return fit_exposure(input, sample_seams(input, CoverageIndex(input.coverage)));
}

std::vector<ViewExposure> fit_exposure(const AtlasInput& input, const SeamSamples& seams) {
  std::vector<ViewExposure> exposure;
  for (const View& view : input.scene.views) exposure.push_back(neutral_exposure(view.camera));
  std::vector<Ratio> ratios;
  for (const SeamEdge& edge : seams.edges)
    if (const auto ratio = ratio_across(input, seams, edge, exposure)) ratios.push_back(*ratio);
  if (ratios.empty()) return exposure;
  const Unknowns u(input.scene);
  const Eigen::VectorXd x = solve(ratios, u, shares(input));
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

}  // namespace gpvc::atlas
