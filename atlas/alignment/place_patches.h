// Photos compared with each other at places on the mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/alignment/patch.h"
#include "atlas/atlas.h"
#include "io/grouping.h"

namespace gpvc::atlas {

/// A place, and views that are compared with its reference.
struct ComparedPlace {
  static constexpr std::size_t kMostOthers = 3;
  SurfacePlace on;
  std::array<ViewId, kMostOthers> others{};
  std::size_t count = 0;  ///< of them
};

/// Two photos at a place.
struct PlaceComparison {
  std::uint32_t place = 0, other = 0;  ///< numbers of the place and of the view among its others
  std::optional<PatchShift> shift{};   ///< nullopt: they show different things
};

/// Patches of the photos at some places.
class PlacePatches {
 public:
  /// Of the others those that do not show nearly the whole of a place's faces are left out. Borrows all. O(places), TBB; holds 5 kB
  /// a place.
  PlacePatches(const AtlasInput& input, const FaceNeighbours& neighbours, std::span<const ComparedPlace> places);

  /// True if the view's coarse photo is needed.
  bool needs(ViewId view) const { return !of_view_[index(view)].empty(); }
  /// Takes what a view shows. TBB.
  void take(ViewId view, const Image& means);
  /// Where both photos show the place, and it has texture in the reference; by place. TBB.
  std::vector<PlaceComparison> compare() const;

 private:
  static constexpr std::size_t kPatches = ComparedPlace::kMostOthers + 1;
  /// A place's patch: 0 is the reference's, 1 that of the first other.
  struct Taken {
    std::uint32_t place = 0, patch = 0;
  };

  const AtlasInput* input_;
  std::span<const ComparedPlace> places_;
  std::vector<GridDepths> depths_;                                   ///< by place
  Grouped<Taken> of_view_;                                           ///< by view
  std::vector<std::array<std::optional<Patch>, kPatches>> patches_;  ///< by place
};

}  // namespace gpvc::atlas
