// A parametrization for a face whose projection into its view is unusable: the face reaches behind the camera, far
// beyond the image or a page, is seen at a grazing angle, or is so large that perspective bends it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "atlas/atlas.h"
#include "atlas/charts/triangle_spans.h"
#include "atlas/sampling/coverage_index.h"
#include "io/scene.h"

namespace gpvc::atlas {

struct ProjectedFace {
  TexelTriangle corners;  ///< px of the frame
  std::array<double, 3> depths{};
};

/// nullopt if the face reaches behind the camera.
std::optional<ProjectedFace> project_face(const Mesh& mesh, std::uint32_t face, const View& view);

/// The face's true shape at one scale; corners in texels of a box of width x height.
struct FlatFace {
  TexelTriangle corners;
  int width = 1, height = 1;
};

/// True if the projection compresses one direction of the face more than ten times as much as another. Other views may
/// show that direction better.
bool is_grazing(const TexelTriangle& frame_corners, const Mesh& mesh, std::size_t face);

/// How far a photo is displaced on an edge of the face at most, in pixels of the frame, if texture coordinates are the
/// projections of its corners: renderers interpolate them linearly over the face, while perspective does not. An edge of
/// length L between depths a and b is displaced by L |sqrt a - sqrt b| / (sqrt a + sqrt b), where the photo shows the point
/// that lies at sqrt a / (sqrt a + sqrt b) of it in the world; the inside of the face by 4/3 of the worst edge at most.
double bend(const TexelTriangle& frame_corners, const std::array<double, 3>& depths);

/// Half a pixel: so well are poses known where photos are sharp (mean reprojection errors are 0.5 to 0.7 px).
inline constexpr double kMostBend = 0.5;

/// True if the face bends by more than kMostBend in its label's view. False for unseen faces, and those behind the camera.
bool is_bent(const AtlasInput& input, std::uint32_t face);

struct FlatLimits {
  int room = 0;           ///< largest edge of the box, texels
  double texel_size = 0;  ///< smallest edge of a texel, world units; 0: no limit
  double reduction = 1;   ///< factor on the scale that results from the other limits
};

/// Texels are as fine as the pixels of the label's view where its coverage shows the face (without coverage: at the nearest
/// corner), but there are at most kTexelsPerSeenPixel for every pixel that sees the face, and no more than the limits allow.
FlatFace flatten(const Mesh& mesh, std::uint32_t face, const Scene& scene, ViewId label, const CoverageIndex& coverage,
                 const FlatLimits& limits);

inline constexpr double kTexelsPerSeenPixel = 16;

}  // namespace gpvc::atlas
