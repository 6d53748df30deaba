// A parametrization of its own for a face whose projection into its view is no use: it reaches behind the camera, far
// beyond the image, or is seen at a grazing angle.
#pragma once

#include "atlas/baking/coverage_index.h"
#include "atlas/charts/triangle_spans.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Isometric up to one scale; corners in texels of a box of width x height.
struct FlatFace {
  TexelTriangle corners;
  int width = 1, height = 1;
};

/// True when the projection squeezes the face to less than a tenth of its width in one direction, which other views may
/// show better.
bool is_grazing(const TexelTriangle& frame_corners, const Mesh& mesh, std::size_t face);

struct FlatLimits {
  int room = 0;           ///< largest edge of the box, texels
  double texel_size = 0;  ///< smallest, world units; 0: none
  double reduction = 1;   ///< of what is left
};

/// Texels are as fine as the label's view is where its coverage shows the face, but no more than kTexelsPerSeenPixel a
/// pixel that view sees, nor than the limits allow.
FlatFace flatten(const Mesh& mesh, std::uint32_t face, const Scene& scene, ViewId label, const CoverageIndex& coverage,
                 const FlatLimits& limits);

inline constexpr double kTexelsPerSeenPixel = 16;

}  // namespace gpvc::atlas
