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

/// The mesh around a place, and the views that show nearly the whole of its faces: the reference, then the others. None of them where
/// nothing is to be compared.
struct PlaceSurface {
  static constexpr std::size_t kViews = ComparedPlace::kMostOthers + 1;
  GridDepths depths{};
  std::array<bool, kViews> shown{};
};

/// Of each place. O(places), TBB.
std::vector<PlaceSurface> find_surfaces(const AtlasInput& input, const FaceNeighbours& neighbours,
                                        std::span<const ComparedPlace> places);

/// Two photos at a place.
struct PlaceComparison {
  std::uint32_t place = 0, other = 0;  ///< numbers of the place and of the view among its others
  std::optional<PatchShift> shift{};   ///< nullopt: they show different things
};

/// Patches of the photos at some places.
class PlacePatches {
 public:
  /// Borrows input, places and `shared`: the surfaces of the last places, which follow those of the first. Holds up to 5 kB a place.
  PlacePatches(const AtlasInput& input, std::span<const ComparedPlace> places, std::vector<PlaceSurface> surfaces,
               std::span<const PlaceSurface> shared);

  /// True if the view's coarse photo is needed.
  bool needs(ViewId view) const { return !of_view_[index(view)].empty(); }
  /// Takes what a view shows. TBB.
  void take(ViewId view, const Image& means);
  /// Where both photos show the place, and it has texture in the reference; by place. TBB.
  std::vector<PlaceComparison> compare() const;

 private:
  static constexpr std::size_t kPatches = PlaceSurface::kViews;
  /// A place's patch: 0 is the reference's, 1 that of the first other.
  struct Taken {
    std::uint32_t place = 0, patch = 0;
  };

  const PlaceSurface& surface(std::size_t place) const {
    return place < surfaces_.size() ? surfaces_[place] : shared_[place - surfaces_.size()];
  }

  const AtlasInput* input_;
  std::span<const ComparedPlace> places_;
  std::vector<PlaceSurface> surfaces_;
  std::span<const PlaceSurface> shared_;
  Grouped<Taken> of_view_;                                           ///< by view
  std::vector<std::array<std::optional<Patch>, kPatches>> patches_;  ///< by place
};

}  // namespace gpvc::atlas
