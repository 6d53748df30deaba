// Which photos of a face show something else than the others do: what moved, or stood in front without being in the
// mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gpvc::labeling {

/// Mean colour of a face in one photo, in grey levels, gains of the photos removed.
struct ColorSample {
  std::array<float, 3> rgb{};
  bool votes = true;  ///< takes part in finding the consensus; all samples are judged by it
};

/// Farther than this from the consensus, in standard deviations, a sample is an outlier: there a Gaussian falls to
/// 6e-3, the threshold of Waechter, Moehrle, Goesele 2014, section 4.1.
inline constexpr double kOutlierDistance = 3.2;

/// The same for distances averaged over the faces around, which scatter less (a face of the consensus has 1.6 on
/// average). Chosen by held-out error: 3.2 keeps leaves of trees that are not in the mesh, 2 rejects more for no better
/// error.
inline constexpr double kOutlierMeanDistance = 2.2;

/// Distances as records keep them: steps of 1/1024, at most 63.
constexpr std::uint16_t fixed_distance(double distance) {
  return static_cast<std::uint16_t>((distance < 63 ? distance : 63) * 1024 + 0.5);
}
constexpr double distance_from_fixed(std::uint16_t fixed) { return fixed / 1024.0; }

/// The Mahalanobis distance of each sample from the consensus; all 0 where there is none (fewer than three votes, or no
/// majority that agrees).
///
/// After Waechter et al.: mean and covariance of the inliers, re-estimated until the inliers stay. Deviation: they
/// start from all samples, but of n samples none can be more than (n - 1) / sqrt(n) standard deviations from the mean
/// of all, so below n = 12 nothing could ever be rejected; we start from the median and the median distance to it. And
/// the covariance has a floor, since photos of one surface differ by noise, angle and vignetting. O(n) for a handful of
/// rounds.
void disagreement(std::span<const ColorSample> samples, std::vector<double>& result);

}  // namespace gpvc::labeling
