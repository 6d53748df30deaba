// How much each view adds to the texture around a vertex, where coarse colours are the mean of several views.
//
// A texel is the main photo's colour plus the difference between two coarse colours of its place: the mean over the views
// that see it whole, and the main photo's own (two bands, as in Burt and Adelson: A Multiresolution Spline with Application
// to Image Mosaics, 1983). So fine detail comes from one photo and is as sharp as that, while brightness, shading and what
// is a little out of place are those that the photos agree on. Coarse colours of both sides of a seam are equal then.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "io/grouping.h"

namespace gpvc::atlas {

/// The part of the difference from the views' mean that is added. The mean alone would flatten what photos show in
/// different places, such as leaves, while detail that is finer keeps its contrast. Of 0.5, 0.6 and 1 this has the least
/// error on photos held out of three scenes (benchmarks/README.md).
inline constexpr float kBlendedPart = 0.6f;

/// A view at a vertex.
struct BlendView {
  std::uint32_t view = 0;
  float share = 0;     ///< its part of all weights, > 0
  float x = 0, y = 0;  ///< where its photo shows the vertex, px
};

class BlendWeights {
 public:
  /// Without any view: nothing is blended.
  BlendWeights() = default;
  /// A view of no cost weighs 1 in a face, one of `full_cost` or more 0. At a vertex it has the least weight of the faces
  /// around, so that weights are continuous over the mesh, and coarse colours, which reach over a few pixels, come from
  /// where the view shows this surface alone. Vertices of faces that are not seen whole, or that perspective bends
  /// (charts/flat_chart.h), have no views. O(candidates x 3), TBB; 16 bytes for each vertex and view.
  BlendWeights(const AtlasInput& input, double full_cost);

  /// What a view adds at a vertex.
  struct Share {
    float factor = 0;               ///< on its coarse colour
    const BlendView* at = nullptr;  ///< null where the view has no weight
  };

  bool empty() const { return views_.items.empty(); }
  std::size_t vertices() const { return views_.groups(); }
  /// Views in ascending order; none where only one view weighs anything.
  std::span<const BlendView> at(std::uint32_t vertex) const {
    return empty() ? std::span<const BlendView>{} : views_[vertex];
  }
  /// What a view adds at a vertex, for a texture whose main view is `main`. The factors of all views add up to 0, those of
  /// all but the main one to kBlendedPart at most. They fade to 0 where the main view's weight does: there its coarse
  /// colour cannot be trusted either.
  Share share(std::uint32_t vertex, std::uint32_t view, std::uint32_t main) const;
  /// The weight of an item of at(vertex): at most 1.
  float weight(std::uint32_t vertex, const BlendView& item) const { return item.share * sums_[vertex]; }

 private:
  Grouped<BlendView> views_;  ///< by vertex
  std::vector<float> sums_;   ///< of weights, by vertex
};

}  // namespace gpvc::atlas
