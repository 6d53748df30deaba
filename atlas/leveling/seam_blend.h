// What blending adds to the colours on the two sides of seams.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "atlas/blending/blend_weights.h"
#include "atlas/blending/coarse_photo.h"
#include "atlas/leveling/seam_samples.h"

namespace gpvc::atlas {

/// Coarse colours along seams, of all views that have a share on one side of them.
class SeamBlend {
 public:
  /// Borrows input and weights. O(edges x views).
  SeamBlend(const AtlasInput& input, const BlendWeights& weights, std::span<const SeamEdge> edges);

  bool empty() const { return parts_.empty(); }
  /// True if the view's coarse photo is needed.
  bool needs(ViewId view) const { return !empty() && !of_view_[index(view)].empty(); }
  /// Takes what a view gives. TBB.
  void take(ViewId id, const CoarsePhoto& photo, std::span<const SeamEdge> edges);
  /// Adds to the samples' colours on both sides. \param exposure per view, or empty
  void add_to(SeamSamples& seams, std::span<const ViewExposure> exposure) const;

 private:
  /// A view along an edge. Its colours are those of the edge's samples, one after the other.
  struct Part {
    std::uint32_t edge, view;
    std::size_t first;
  };

  const AtlasInput* input_;
  const BlendWeights* weights_;
  std::vector<Part> parts_;                           ///< by edge
  Grouped<std::uint32_t> of_view_;                    ///< by view, its parts
  std::vector<std::array<std::uint16_t, 3>> colors_;  ///< grey levels x 256, as photographed
};

}  // namespace gpvc::atlas
