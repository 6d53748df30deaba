// What the two photos on either side of a seam show along it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/sampling.h"
#include "atlas/charts/charts.h"

namespace gpvc::atlas {

/// A mesh edge between two faces of different views, sampled about once a texel.
struct SeamEdge {
  std::array<std::uint32_t, 2> faces{};
  std::array<std::uint32_t, 2> vertices{};
  std::size_t first_sample = 0;  ///< into SeamSamples::colors; sample i lies at (i + 0.5) / samples along the edge
  std::uint32_t samples = 0;
};

inline constexpr float kMisregistration_px = 0.5f;
/// Grey levels by which the same place differs between photos for other reasons (noise, highlights).
inline constexpr float kPhotoNoise = 3;

struct SeamSamples {
  std::vector<SeamEdge> edges;
  std::vector<std::array<Color, 2>> colors;      ///< per sample: as the photos of faces[0] and faces[1] show it
  std::vector<std::array<PixelPoint, 2>> frame;  ///< where, in the views' frames
  /// Per sample, 0 to 1: how much of a difference is one of brightness. Photos and mesh disagree by about
  /// kMisregistration_px, which on a steep gradient alone makes a step; 0 where a photo does not show the place.
  std::vector<float> weight;
};

/// Samples every seam edge between faces that have views. Photos are fetched once each, at most. A partial face counts
/// only where its coverage shows it, so that no occluder's colour enters. O(edges + samples).
SeamSamples sample_seams(const AtlasInput& input, const CoverageIndex& coverage);

}  // namespace gpvc::atlas
