// Filling pages with colour from the photos, view by view.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/chart_raster.h"
#include "atlas/pages.h"
#include "atlas/partial.h"

namespace gpvc {

/// What seam leveling adds to the photos' colours.
struct ColorCorrection {
  std::vector<Color> gain;                    ///< per view, multiplied first
  std::vector<std::array<Color, 3>> offsets;  ///< per face and corner, added; empty: none

  /// Offset of a face at a position in its chart's texels; outside the face that of its nearest corner or
  /// edge.
  Color offset(std::uint32_t face, const TexelTriangle& corners, double x, double y) const;
};

/// Copies or resamples every texel of the plain charts, ring included, and hands partial charts the texels
/// that the view at hand gives them. Every photo is fetched once; the next is decoded while one is in use.
/// `padding` of zero leaves the ring out. Calls progress per view.
void bake_photos(const AtlasInput& input, const ChartSet& set, std::span<const ChartPlace> places,
                 const ColorCorrection& correction, int padding, std::span<Page> pages,
                 std::span<PartialChart> partial, const Progress& progress);

}  // namespace gpvc
