// Places on the cuts between charts.
#pragma once

#include <vector>

#include "atlas/alignment/place_patches.h"
#include "atlas/atlas.h"

namespace gpvc::atlas {

/// Places on edges between faces of different views, of which the one with the lower number is the reference: 16 pixels apart, and of
/// very many some thousands all over the mesh. Not where a face has its texture already; each between parts of a mesh that have each
/// other's faces in their borders belongs to one of them. O(pairs of faces log pairs).
std::vector<ComparedPlace> cut_places(const AtlasInput& input);

}  // namespace gpvc::atlas
