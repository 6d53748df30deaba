// A parametrization for a face whose projection into its view is unusable: the face reaches behind the camera, far
// beyond the image or a page, or is seen at a grazing angle.
#pragma once

#include "atlas/baking/coverage_index.h"
#include "atlas/charts/triangle_spans.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// The face's true shape at one scale; corners in texels of a box of width x height.
struct FlatFace {
  TexelTriangle corners;
  int width = 1, height = 1;
};

/// True if the projection compresses one direction of the face more than ten times as much as another. Other views may
/// show that direction better.
bool is_grazing(const TexelTriangle& frame_corners, const Mesh& mesh, std::size_t face);

struct FlatLimits {
  int room = 0;           ///< largest edge of the box, texels
  double texel_size = 0;  ///< smallest edge of a texel, world units; 0: no limit
  double reduction = 1;   ///< factor on the scale that results from the other limits
};

/// Texels are as fine as the pixels of the label's view where its coverage shows the face, but there are at most
/// kTexelsPerSeenPixel for every pixel that sees the face, and no more than the limits allow.
FlatFace flatten(const Mesh& mesh, std::uint32_t face, const Scene& scene, ViewId label, const CoverageIndex& coverage,
                 const FlatLimits& limits);

inline constexpr double kTexelsPerSeenPixel = 16;

}  // namespace gpvc::atlas
