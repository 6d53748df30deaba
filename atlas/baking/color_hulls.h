// Whether a texture has colours that no photo of the place has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "atlas/baking/baking.h"
#include "atlas/blending/coarse_photo.h"

namespace gpvc::atlas {

/// Looks at a vertex of every kSampled-th face of a part of a plain chart. There it tests whether the coarse colour that the texture
/// gets from leveling and blending lies in the range of the coarse colours of all photos that are blended, their exposure corrected. Fine
/// detail is left out on both sides: it comes from one photo as it is.
class ColorHulls {
 public:
  static constexpr std::size_t kSampled = 4;

  ColorHulls() = default;
  /// Borrows none. \param faces of the chart, in one of its bands
  ColorHulls(const AtlasBuild& build, const Chart& chart, std::span<const std::uint32_t> faces);
  /// Takes what a view shows. \param coarse its photo. Each view once, those of a place in any one order. O(samples x views there).
  void add(const AtlasBuild& build, ViewId id, const CoarseRows& coarse);
  /// After all views. O(samples). \param strip the chart's
  InventedColor count(const AtlasBuild& build, const ChartStrip* strip) const;

 private:
  struct Sample {
    std::uint32_t face = 0;
    Color least{255, 255, 255}, most{}, own;  ///< of all photos, of the main one
    Color blended;                            ///< what all views add
    bool has_own = false;
  };
  std::uint32_t vertex_of(const AtlasBuild& build, const Sample& sample) const {
    return build.input.mesh.faces[sample.face][0];
  }

  ViewId main_ = kNoView;
  std::vector<Sample> samples_;
};

}  // namespace gpvc::atlas
