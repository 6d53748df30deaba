// Colour ratios between photos that overlap, wherever they show the same surface.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/blending/coarse_photo.h"
#include "io/grouping.h"

namespace gpvc::atlas {

/// What all candidates of some faces show in the middle of these. Seams run where both photos look from about as far away, at equal
/// distances from their middles, and so tell little of the lens's fall-off; overlaps reach from the middle of one photo to the corners of
/// others, and across several photos of a flight.
class OverlapRatios {
 public:
  /// Borrows. Takes faces that are seen whole, by several photos, not in the border, all over the mesh. O(faces).
  explicit OverlapRatios(const AtlasInput& input);
  OverlapRatios(const OverlapRatios&) = delete;
  OverlapRatios& operator=(const OverlapRatios&) = delete;

  bool needs(ViewId view) const { return !of_view_[index(view)].empty(); }
  void take(ViewId view, const CoarsePhoto& photo);
  /// After all views. Of each face between each photo and the next, and the one halfway around, in the order of their numbers.
  /// \param weight of all together
  std::vector<ColorRatio> ratios(double weight) const;

 private:
  struct Sight {
    std::uint32_t face = 0, view = 0;
    bool is_shown = false;
    Color color;
    PixelPoint frame;
  };

  const AtlasInput* input_;
  std::vector<Sight> sights_;  ///< those of a face beside each other
  Grouped<std::uint32_t> of_view_;
};

}  // namespace gpvc::atlas
