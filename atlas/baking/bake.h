// Filling pages with colour from the photos, view by view.
#pragma once

#include <span>

#include "atlas/baking/atlas_build.h"
#include "atlas/baking/partial_sources.h"

namespace gpvc::atlas {

/// Copies or resamples every texel of the plain charts, and adds to partial charts what each view gives them. Every
/// photo is fetched once; the next is decoded while one is in use. Without padding the rings of charts are left out.
/// Progress is called per view, and ten times a second within one, from any thread, but by one thread at a time; an
/// exception from it ends the work. O(texels + pixels covered by charts with texels of many pixels).
void bake_photos(AtlasBuild& build, std::span<PartialChart> partial, const Progress& progress);

}  // namespace gpvc::atlas
