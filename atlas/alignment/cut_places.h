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
/// very many some thousands all over the mesh. Edges of finished faces are left out. An edge between two parts of a mesh, which
/// have each other's faces in their borders, is taken by the part that has the face with the lower number. The same however photos are aligned. O(pairs of faces log pairs), TBB.
CutPlaces cut_places(const AtlasInput& input, const FaceNeighbours& neighbours);

}  // namespace gpvc::atlas
