// Finds the photos of a face that show another object than the others do: one that moved, or that stood in front without
// being in the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gpvc::labeling {

/// Mean colour of a face in one photo, in grey levels, with the photo's gain removed.
struct ColorSample {
  std::array<float, 3> rgb{};
  bool votes = true;  ///< takes part in finding the consensus; the distance from it is computed for all samples
};

/// A sample farther than this from the consensus, in standard deviations, is an outlier. There a Gaussian has fallen to
/// 6e-3, the threshold of Waechter, Moehrle, Goesele 2014, section 4.1.
inline constexpr double kOutlierDistance = 3.2;

/// The same threshold for distances averaged over neighbouring faces, which scatter less (faces that agree with the
/// consensus have 1.6 on average). Chosen by the error on held-out photos: 3.2 keeps leaves of trees that are not in the
/// mesh, 2 rejects more views without lowering the error.
inline constexpr double kOutlierMeanDistance = 2.2;

/// Larger distances count as this one, which limits the influence of a single face with a very different colour.
inline constexpr double kMaxDistance = 2 * kOutlierDistance;

/// Distances as FaceRecord stores them: in steps of 1/1024, at most 63.
constexpr std::uint16_t fixed_distance(double distance) {
  return static_cast<std::uint16_t>((distance < 63 ? distance : 63) * 1024 + 0.5);
}
constexpr double distance_from_fixed(std::uint16_t fixed) { return fixed / 1024.0; }

/// Standard deviation of a channel, in grey levels, among photos that all show the same surface of this mean level: 4 levels for
/// noise and JPEG, 4 % for vignetting and sheen.
template <class Level>
constexpr Level natural_deviation(Level level) {
  return 4 + static_cast<Level>(0.04) * level;
}

/// Memory that calls share.
struct ConsensusScratch {
  std::vector<double> values;
  std::vector<std::uint8_t> inlier, before;  ///< per sample
};

/// The Mahalanobis distance of each sample from the consensus; all 0 where there is none (fewer than three votes, or no
/// majority that agrees).
///
/// After Waechter et al.: mean and covariance of the inliers, estimated again until the inliers do not change. Two
/// deviations. They start from all samples, but none of n samples can be more than (n - 1) / sqrt(n) standard deviations
/// from the mean of all, so below n = 12 nothing could ever be rejected; this starts from the median and the median
/// distance to it. And the covariance has a floor, since photos of one surface differ by noise, angle and vignetting.
/// O(n) a round, and a few rounds.
void disagreement(std::span<const ColorSample> samples, ConsensusScratch& scratch, std::vector<double>& result);

}  // namespace gpvc::labeling
