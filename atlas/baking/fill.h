// Colours for unseen faces.
#pragma once

#include "atlas/baking/atlas_build.h"

namespace gpvc::atlas {

/// Writes the charts of unseen faces. In each hole, vertex colours are the harmonic function (uniform edge weights)
/// that continues the colours on the hole's border; within a face they are interpolated linearly. A hole without a
/// border, where a whole component of the mesh is unseen, takes the mean colour of all pages. \pre all other charts are
/// baked. O(faces + unseen faces x CG iterations).
void fill_unseen(AtlasBuild& build);

/// Writes the same charts in options.unseen_color.
void paint_unseen(AtlasBuild& build);

}  // namespace gpvc::atlas
