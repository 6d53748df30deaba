// How far the photos on the two sides of cuts between charts are apart.
#pragma once

#include <vector>

#include "atlas/alignment/place_patches.h"
#include "atlas/atlas.h"

namespace gpvc::atlas {

/// Patches of both photos around places on cuts.
class CutPatches {
 public:
  /// Borrows both. See cut_places() and PlacePatches.
  CutPatches(const AtlasInput& input, const FaceNeighbours& neighbours);
  CutPatches(const CutPatches&) = delete;
  CutPatches& operator=(const CutPatches&) = delete;

  bool needs(ViewId view) const { return patches_.needs(view); }
  void take(ViewId view, const Image& means) { patches_.take(view, means); }
  /// Of the places that both photos show, and that have texture in the first. O(places), TBB.
  CutMisfit measure() const;

 private:
  const AtlasInput* input_;
  std::vector<ComparedPlace> places_;
  PlacePatches patches_;
};

}  // namespace gpvc::atlas
