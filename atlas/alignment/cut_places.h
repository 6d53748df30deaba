// Places on the cuts between charts.
#pragma once

#include <vector>

#include "atlas/alignment/place_patches.h"
#include "atlas/atlas.h"

namespace gpvc::atlas {

struct CutPlaces {
  std::vector<ComparedPlace> places;
  std::vector<PlaceSurface> surfaces;  ///< of each
};

/// Places on edges between faces of different views, of which the one with the lower number is the reference: 16 pixels apart, and of
/// very many some thousands all over the mesh. Not where a face has its texture already; each between parts of a mesh that have each
/// other's faces in their borders belongs to one of them. The same however photos are aligned. O(pairs of faces log pairs), TBB.
CutPlaces cut_places(const AtlasInput& input, const FaceNeighbours& neighbours);

}  // namespace gpvc::atlas
