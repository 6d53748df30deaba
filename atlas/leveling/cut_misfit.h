// How far the photos on the two sides of cuts between charts are apart.
#pragma once

#include <span>

#include "atlas/alignment/cut_places.h"
#include "atlas/alignment/place_patches.h"
#include "atlas/atlas.h"

namespace gpvc::atlas {

/// Patches of both photos around places on cuts.
class CutPatches {
 public:
  /// Borrows both.
  CutPatches(const AtlasInput& input, const CutPlaces& cuts)
      : input_(&input), places_(cuts.places), patches_(input, places_, {}, cuts.surfaces) {}
  CutPatches(const CutPatches&) = delete;
  CutPatches& operator=(const CutPatches&) = delete;

  bool needs(ViewId view) const { return patches_.needs(view); }
  void take(ViewId view, const Image& means) { patches_.take(view, means); }
  /// Of the places that both photos show, and that have texture in the first. O(places), TBB.
  CutMisfit measure() const;

 private:
  const AtlasInput* input_;
  std::span<const ComparedPlace> places_;
  PlacePatches patches_;
};

}  // namespace gpvc::atlas
