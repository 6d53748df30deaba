// How far the photos on the two sides of cuts between charts are apart.
#pragma once

#include "atlas/alignment/cut_places.h"
#include "atlas/alignment/place_patches.h"
#include "atlas/atlas.h"

namespace gpvc::atlas {

/// Of the places on cuts that both photos show, and that have texture in the first. O(places), TBB.
/// \param patches of the places
CutMisfit cut_misfit(const AtlasInput& input, const CutPlaces& cuts, const PlacePatches& patches);

}  // namespace gpvc::atlas
