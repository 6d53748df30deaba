#include "labeling/costs/photo_consistency.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "io/order_statistics.h"

namespace gpvc::labeling {
namespace {

using Vector = std::array<double, 3>;

/// Symmetric 3 x 3: xx, xy, xz, yy, yz, zz.
using Symmetric = std::array<double, 6>;

struct Gaussian {
  Vector mean{};
  Symmetric inverse_covariance{};

  double squared_distance(const ColorSample& sample) const {
    const double x = static_cast<double>(sample.rgb[0]) - mean[0], y = static_cast<double>(sample.rgb[1]) - mean[1],
                 z = static_cast<double>(sample.rgb[2]) - mean[2];
    const Symmetric& m = inverse_covariance;
    return x * (m[0] * x + 2 * (m[1] * y + m[2] * z)) + y * (m[3] * y + 2 * m[4] * z) + m[5] * z * z;
  }
};

double natural_deviation_of(const Vector& color) { return natural_deviation((color[0] + color[1] + color[2]) / 3); }

Symmetric inverse(const Symmetric& m) {
  const double a = m[3] * m[5] - m[4] * m[4], b = m[2] * m[4] - m[1] * m[5], c = m[1] * m[4] - m[2] * m[3];
  const double determinant = m[0] * a + m[1] * b + m[2] * c;  // > 0: the floor makes the matrix positive definite
  return {a / determinant,
          b / determinant,
          c / determinant,
          (m[0] * m[5] - m[2] * m[2]) / determinant,
          (m[1] * m[2] - m[0] * m[4]) / determinant,
          (m[0] * m[3] - m[1] * m[1]) / determinant};
}

double median(std::vector<double>& values) {
  const double upper = upper_median(std::span(values));
  if (values.size() % 2 == 1) return upper;
  return (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2))) /
         2;
}

/// Median colour of the voting samples, and an isotropic deviation derived from the median distance to it.
Gaussian robust_estimate(std::span<const ColorSample> samples, std::size_t votes, std::vector<double>& values) {
  Gaussian result;
  for (std::size_t c = 0; c < 3; ++c) {
    values.clear();
    for (const ColorSample& sample : samples)
      if (sample.votes) values.push_back(static_cast<double>(sample.rgb[c]));
    result.mean[c] = median(values);
  }
  result.inverse_covariance = {1, 0, 0, 1, 0, 1};
  values.clear();
  for (const ColorSample& sample : samples)
    if (sample.votes) values.push_back(std::sqrt(result.squared_distance(sample)));
  // The median length of a normal vector in three dimensions is 1.538 standard deviations. Of three votes the median
  // distance is that of the second, which says nothing about the spread of two that agree.
  const double spread = votes > 3 ? median(values) / 1.538 : 0;
  const double deviation = std::max(spread, natural_deviation_of(result.mean));
  const double weight = 1 / (deviation * deviation);
  result.inverse_covariance = {weight, 0, 0, weight, 0, weight};
  return result;
}

Gaussian fit(std::span<const ColorSample> samples, const std::vector<std::uint8_t>& inlier, std::size_t inliers) {
  Gaussian result;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (inlier[i] != 0)
      for (std::size_t c = 0; c < 3; ++c) result.mean[c] += static_cast<double>(samples[i].rgb[c]);
  for (double& value : result.mean) value /= static_cast<double>(inliers);
  Symmetric covariance{};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (inlier[i] == 0) continue;
    Vector d;
    for (std::size_t c = 0; c < 3; ++c) d[c] = static_cast<double>(samples[i].rgb[c]) - result.mean[c];
    const Symmetric products{d[0] * d[0], d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]};
    for (std::size_t k = 0; k < 6; ++k) covariance[k] += products[k] / static_cast<double>(inliers);
  }
  const double floor = natural_deviation_of(result.mean) * natural_deviation_of(result.mean);
  for (const std::size_t diagonal : {0u, 3u, 5u}) covariance[diagonal] += floor;
  result.inverse_covariance = inverse(covariance);
  return result;
}

}  // namespace

void disagreement(std::span<const ColorSample> samples, ConsensusScratch& scratch, std::vector<double>& result) {
  result.assign(samples.size(), 0.0);
  const auto votes = static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(), [](const ColorSample& sample) { return sample.votes; }));
  if (votes < 3) return;

  constexpr int kConsensusRounds = 10;  // as published; two or three are usually enough
  Gaussian consensus = robust_estimate(samples, votes, scratch.values);
  auto& [values, inlier, before] = scratch;
  inlier.assign(samples.size(), 0);
  for (int round = 0; round < kConsensusRounds; ++round) {
    std::size_t inliers = 0;
    before = inlier;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      result[i] = std::sqrt(consensus.squared_distance(samples[i]));
      inlier[i] = samples[i].votes && result[i] <= kOutlierDistance;
      inliers += inlier[i];
    }
    if (2 * inliers <= votes) {
      result.assign(samples.size(), 0.0);
      return;
    }
    if (inlier == before) return;
    consensus = fit(samples, inlier, inliers);
  }
}

}  // namespace gpvc::labeling
