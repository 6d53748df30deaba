// Which photos of a face show something else than the others do: what moved, or stood in front without being
// in the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gpvc {

/// Mean colour of a face in one photo, in grey levels, gains of the photos removed.
struct ColourSample {
  std::array<float, 3> rgb{};
  bool votes = true;  ///< takes part in finding the consensus; all samples are judged by it
};

/// Below this value of the consensus' Gaussian a sample is an outlier: Waechter, Moehrle, Goesele 2014,
/// section 4.1 (3.2 standard deviations).
inline constexpr float kOutlierBelow = 6e-3f;

/// How well each sample agrees with the consensus, exp(-d^2 / 2) in (0, 1], d its Mahalanobis distance; all 1
/// where there is none (fewer than three votes, or no majority that agrees).
///
/// After Waechter et al.: mean and covariance of the inliers, re-estimated until the inliers stay. Deviation:
/// they start from all samples, but of n samples none can be more than (n - 1) / sqrt(n) standard deviations
/// from the mean of all, so below n = 12 nothing could ever be rejected; we start from the median and the
/// median distance to it. And the covariance has a floor, since photos of one surface differ by noise, angle
/// and vignetting. O(n) for a handful of rounds.
void agreement(std::span<const ColourSample> samples, std::vector<float>& result);

}  // namespace gpvc
