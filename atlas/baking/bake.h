// Filling pages with colour from the photos, view by view.
#pragma once

#include <span>

#include "atlas/atlas.h"
#include "atlas/baking/pages.h"
#include "atlas/baking/partial.h"
#include "atlas/charts/chart_raster.h"
#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

/// Copies or resamples every texel of the plain charts, ring included, and hands partial charts the texels that the
/// view at hand gives them. Every photo is fetched once; the next is decoded while one is in use. `padding` of zero
/// leaves the ring out. Calls progress per view, and ten times a second within one, from any thread, but from one at a
/// time; what it throws ends the work. O(texels + pixels that charts of coarser texels cover).
void bake_photos(const AtlasInput& input, const ChartSet& set, std::span<const ChartPlace> places,
                 const ColorCorrection& correction, int padding, std::span<Page> pages, std::span<PartialChart> partial,
                 const Progress& progress);

}  // namespace gpvc::atlas
