// Baking charts whose texels come from several views.
#pragma once

#include <span>

#include "atlas/baking/atlas_build.h"
#include "atlas/baking/each_photo.h"
#include "atlas/baking/partial_sources.h"

namespace gpvc::atlas {

/// Adds the texels that a view gives.
void take_view(PartialChart& part, const AtlasBuild& build, const ViewPhoto& photo);

/// Writes the charts to their pages. Texels that no view shows are filled smoothly from those around them, on the same
/// chart and, across its border, on the charts beside it. \pre plain charts are baked
void finish_partial(std::span<PartialChart> parts, AtlasBuild& build);

}  // namespace gpvc::atlas
