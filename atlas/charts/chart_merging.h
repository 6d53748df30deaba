// Merging parts of a photo that lie so close together that the margins of their charts would overlap.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "atlas/charts/triangle_spans.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Faces of one view and tile that keep their relative places.
struct FramePart {
  ViewId view{};
  double scale = 1;
  std::uint32_t tile = 0;
  std::vector<std::uint32_t> faces;  ///< ascending
  FrameBox box;
};

enum class TexelSharing { allowed, forbidden };

/// Calls visit(y, first, last) for the texels whose centres lie inside a face. Centres on its border are excluded,
/// because the neighbour covers them too.
template <typename Visit>
void covered_spans(const TexelTriangle& corners, Visit&& visit) {
  constexpr CellBox kEverywhere{-(1 << 28), -(1 << 28), 1 << 28, 1 << 28};
  // Texels. Far above the error of projections, about 1e-9 px.
  constexpr double kStrictlyInside = -1.0 / 4096;
  triangle_spans(corners, kStrictlyInside, kEverywhere, visit);
}

/// When parts may be merged.
struct MergeRule {
  int closeness = 0;                             ///< texels; parts within about twice this distance are merged
  TexelSharing sharing = TexelSharing::allowed;  ///< forbidden: only if no texel centre lies in both
  std::function<bool(const FrameBox&)> fits;     ///< only if it is true for the union's box
};

/// Merges parts of the same view, scale and tile. `corners` are positions in the view's scaled frame. The result is ordered
/// by first face. O(texels / 16), and O(texels) where sharing is forbidden.
std::vector<FramePart> merge_close_parts(std::vector<FramePart> parts, std::span<const TexelTriangle> corners,
                                         const MergeRule& rule);

}  // namespace gpvc::atlas
