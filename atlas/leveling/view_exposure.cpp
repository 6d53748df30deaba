#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "atlas/leveling/seam_leveling.h"

namespace gpvc::atlas {

namespace {

/// One seam edge: logarithms of the mean colours on both sides.
struct Ratio {
  std::array<std::uint32_t, 2> views{};
  std::array<std::array<double, 3>, 2> logs{};
  std::array<double, 2> r2{};  ///< squared radius of the edge's middle in each frame
  double weight = 0;
};

ViewExposure neutral_exposure(const Camera& c) {
  ViewExposure e;
  e.centre_x = c.cx, e.centre_y = c.cy;
  e.inverse_radius2 = 4 / (double(c.width) * c.width + double(c.height) * c.height);
  return e;
}

std::vector<Ratio> ratios_across(const AtlasInput& input, const SeamSamples& seams,
                                 const std::vector<ViewExposure>& neutral) {
  // Sensors clip and quantize: below the one a level is several per cent, above the other it may be anything.
  constexpr float kDarkest = 8, kBrightest = 250;
  std::vector<Ratio> ratios;
  for (const SeamEdge& edge : seams.edges) {
    std::array<Color, 2> sum;
    std::array<PixelPoint, 2> middle;
    float total = 0;
    for (std::size_t i = edge.first_sample; i < edge.first_sample + edge.samples; ++i) {
      const float w = seams.weight[i];
      for (std::size_t s = 0; s < 2; ++s) {
        sum[s] = sum[s] + w * seams.colors[i][s];
        middle[s].x += double{w} * seams.frame[i][s].x, middle[s].y += double{w} * seams.frame[i][s].y;
      }
      total += w;
    }
    if (!(total > 0)) continue;
    Ratio ratio;
    ratio.weight = double{std::min(total, 64.0f)};
    bool usable = true;
    for (std::size_t s = 0; s < 2; ++s) {
      const Color c = (1.0f / total) * sum[s];
      ratio.views[s] = static_cast<std::uint32_t>(input.labels[edge.faces[s]]);
      const ViewExposure& e = neutral[ratio.views[s]];
      const double dx = middle[s].x / double{total} - e.centre_x, dy = middle[s].y / double{total} - e.centre_y;
      ratio.r2[s] = (dx * dx + dy * dy) * e.inverse_radius2;
      std::size_t k = 0;
      for (const float value : {c.r, c.g, c.b}) {
        usable = usable && value >= kDarkest && value <= kBrightest;
        ratio.logs[s][k++] = std::log(std::max(1.0f, value));
      }
    }
    if (usable) ratios.push_back(ratio);
  }
  return ratios;
}

/// Unknowns: three log gains a view, then k1 and k2 a camera.
struct Unknowns {
  std::vector<std::size_t> camera_of_view;
  std::size_t views = 0, cameras = 0;
  int gain(std::uint32_t view, std::size_t channel) const { return static_cast<int>(3 * view + channel); }
  int falloff(std::uint32_t view, std::size_t k) const {
    return static_cast<int>(3 * views + 2 * camera_of_view[view] + k);
  }
  Eigen::Index count() const { return static_cast<Eigen::Index>(3 * views + 2 * cameras); }
};

Unknowns unknowns_of(const Scene& scene) {
  Unknowns u;
  u.views = scene.views.size();
  std::vector<const Camera*> distinct;
  std::map<std::tuple<int, int, double, double>, std::size_t> known;
  for (const View& view : scene.views) {
    const Camera& c = view.camera;
    const auto [at, fresh] = known.try_emplace({c.width, c.height, c.fx, c.fy}, known.size());
    u.camera_of_view.push_back(at->second);
  }
  u.cameras = known.size();
  return u;
}

/// Share of the labelled faces that each view has.
std::vector<double> shares(const AtlasInput& input) {
  std::vector<double> share(input.scene.views.size(), 0.0);
  double total = 0;
  for (const auto label : input.labels)
    if (label != kNoView) share[index(label)] += 1, total += 1;
  for (auto& s : share) s = total > 0 ? s / total : 0;
  return share;
}

/// The row of a ratio's channel: its residual is row . x + rest.
struct Row {
  std::array<std::pair<int, double>, 6> entries;
  double rest = 0;
};

Row row_of(const Ratio& ratio, const Unknowns& u, std::size_t channel) {
  Row row;
  std::size_t n = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    const double sign = s ? -1 : 1, r2 = ratio.r2[s];
    row.entries[n++] = {u.gain(ratio.views[s], channel), sign};
    row.entries[n++] = {u.falloff(ratio.views[s], 0), sign * r2};
    row.entries[n++] = {u.falloff(ratio.views[s], 1), sign * r2 * r2};
    row.rest += sign * ratio.logs[s][channel];
  }
  return row;
}

double residual(const Row& row, const Eigen::VectorXd& x) {
  double r = row.rest;
  for (const auto& [i, a] : row.entries) r += a * x[i];
  return r;
}

Eigen::VectorXd solve(const std::vector<Ratio>& ratios, const Unknowns& u, const std::vector<double>& share) {
  double total = 0;
  for (const auto& r : ratios) total += r.weight;
  // The anchor decides only what seams leave open: the brightness of all views together, and fall-off where seams lie
  // at equal radii. A thousandth of the data's weight biases the rest by as much. A face in ten thousand is the least
  // share, so that no view is free.
  const double anchor = 1e-3 * total;
  // Cauchy weights: ratios off by more than 10 % are parallax, highlights or moving things.
  constexpr double kOutlyingRatio = 0.1;
  constexpr int kRounds = 10;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(u.count());
  for (int round = 0; round < kRounds; ++round) {
    // Some sixty entries a seam edge add up to few places: not kept until the end.
    constexpr std::size_t kAtOnce = std::size_t{1} << 20;
    Eigen::SparseMatrix<double> matrix(u.count(), u.count());
    std::vector<Eigen::Triplet<double>> entries;
    const auto add_entries = [&] {
      Eigen::SparseMatrix<double> part(u.count(), u.count());
      part.setFromTriplets(entries.begin(), entries.end());
      matrix += part;
      entries.clear();
    };
    Eigen::VectorXd right = Eigen::VectorXd::Zero(u.count());
    for (std::uint32_t v = 0; v < u.views; ++v)
      for (std::size_t c = 0; c < 3; ++c)
        entries.emplace_back(u.gain(v, c), u.gain(v, c), anchor * std::max(1e-4, share[v]));
    for (Eigen::Index i = static_cast<Eigen::Index>(3 * u.views); i < u.count(); ++i)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(i), anchor);
    for (const Ratio& ratio : ratios) {
      if (entries.size() >= kAtOnce) add_entries();
      for (std::size_t c = 0; c < 3; ++c) {
        const Row row = row_of(ratio, u, c);
        const double r = residual(row, x) / kOutlyingRatio;
        const double w = round == 0 ? ratio.weight / (1 + std::abs(r)) : ratio.weight / (1 + r * r);
        for (const auto& [i, a] : row.entries) {
          right[i] -= w * a * row.rest;
          for (const auto& [j, b] : row.entries)
            if (j <= i) entries.emplace_back(i, j, w * a * b);
        }
      }
    }
    add_entries();
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(matrix);
    if (solver.info() != Eigen::Success) return x;
    x = solver.solve(right);
  }
  return x;
}

}  // namespace

std::vector<ViewExposure> fit_exposure(const AtlasInput& input, const SeamSamples& seams) {
  std::vector<ViewExposure> exposure;
  for (const View& view : input.scene.views) exposure.push_back(neutral_exposure(view.camera));
  const std::vector<Ratio> ratios = ratios_across(input, seams, exposure);
  if (ratios.empty()) return exposure;
  const Unknowns u = unknowns_of(input.scene);
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
