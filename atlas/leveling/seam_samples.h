// The colours that the photos on the two sides of a seam show along it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/charts/charts.h"
#include "atlas/sampling/sampling.h"

namespace gpvc::atlas {

class PlacePatches;   // alignment/place_patches.h
class OverlapRatios;  // overlap_ratios.h
class SeamBlend;      // leveling/seam_blend.h

/// A mesh edge between two faces of different views, or between a finished and a new one (AtlasInput::finished), sampled about
/// once a texel.
struct SeamEdge {
  std::array<std::uint32_t, 2> faces{};
  std::array<std::uint32_t, 2> vertices{};
  std::size_t first_sample = 0;  ///< into the lists of SeamSamples; sample i is at (i + 0.5) / samples along the edge
  std::uint32_t samples = 0;
};

/// Standard deviation, in x and in y, of the distance between the projection of a place and where a photo shows it, next to
/// the edges of objects. Along silhouettes and creases errors of the mesh move whole edges by pixels: the strip in which
/// view selection distrusts photos is 5 px wide (labeling::CostOptions::margin_px), 2.5 standard deviations.
inline constexpr float kMisregistrationPx = 2;

struct SeamSamples {
  std::vector<SeamEdge> edges;
  std::vector<std::array<Color, 2>> colors;      ///< per sample, in the photos of faces[0] and faces[1], or as finished
  std::vector<std::array<PixelPoint, 2>> frame;  ///< per sample, in the frames of these views
  /// Per sample, 0 to 1: the expected share of brightness in a difference, the rest being misregistration near an edge
  /// in the photo. 0 if one of the photos does not show the place.
  std::vector<float> weight;
};

/// Where samples have low weights, a part of a step is taken for misregistration rather than brightness: half of it if their mean
/// weight is this.
inline constexpr float kDoubt = 0.05f;

/// Others that need the same coarse photos, and are given them in the same pass.
struct AlsoSampled {
  SeamBlend* blend = nullptr;  ///< null, or made from the same edges
  PlacePatches* cuts = nullptr;
  OverlapRatios* overlaps = nullptr;
};

/// Every edge between faces of different views, or between a finished face and a new one. O(pairs of faces).
std::vector<SeamEdge> find_seams(const AtlasInput& input);

/// Samples the edges that find_seams() finds. Fetches coarse photos, each at most once: strips and offsets need no fine detail,
/// and its noise would count as a difference. A partial face is sampled only where its
/// coverage shows it, so that no occluder's colour enters. O(edges + samples).
SeamSamples sample_seams(const AtlasInput& input, const CoverageIndex& coverage, std::vector<SeamEdge> edges,
                         const AlsoSampled& others = {});

}  // namespace gpvc::atlas
