#include "atlas/alignment/place_patches.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "atlas/charts/chart_raster.h"

namespace gpvc::atlas {

namespace {

/// True if the view shows the grid's faces whole, but for a tenth of its points.
bool shows(const AtlasInput& input, const SurfaceGrid& grid, ViewId view) {
  std::size_t shown = 0;
  std::uint32_t before = kNoOwner;
  bool seen = false;
  for (const std::uint32_t face : grid.faces) {
    if (face == kNoOwner) continue;
    if (face != before)
      seen = input.tags[face] == labeling::FaceTag::seen &&
             std::ranges::binary_search(input.candidates.views_of(face), static_cast<std::uint32_t>(index(view)));
    before = face;
    if (seen) ++shown;
  }
  return 10 * shown >= 9 * grid.faces.size();
}

}  // namespace

PlacePatches::PlacePatches(const AtlasInput& input, const FaceNeighbours& neighbours,
                           std::span<const ComparedPlace> places)
    : input_(&input), places_(places), depths_(places.size()), patches_(places.size()) {
  std::vector<std::array<bool, kPatches>> wanted(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const ComparedPlace& place = places[i];
    const auto grid = surface_around(input.mesh, neighbours, input.scene, place.on);
    if (!grid || !shows(input, *grid, place.on.reference)) return;
    depths_[i] = grid->depth;
    for (std::size_t k = 0; k < place.count; ++k) wanted[i][k + 1] = shows(input, *grid, place.others[k]);
    wanted[i][0] = std::ranges::any_of(wanted[i], [](bool is) { return is; });
  });
  of_view_ = group_items<Taken>(input.scene.views.size(), [&](const auto& emit) {
    for (std::uint32_t i = 0; i < places.size(); ++i) {
      if (wanted[i][0]) emit(index(places[i].on.reference), Taken{i, 0});
      for (std::uint32_t k = 1; k < kPatches; ++k)
        if (wanted[i][k]) emit(index(places[i].others[k - 1]), Taken{i, k});
    }
  });
}

void PlacePatches::take(ViewId view, const Image& means) {
  const CoarseLuma luma = coarse_luma(means);
  const std::span<const Taken> mine = std::as_const(of_view_)[index(view)];
  tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t i) {
    const auto [place, patch] = mine[i];
    patches_[place][patch] = take_patch(input_->scene, places_[place].on, depths_[place], view, luma);
  });
}

std::vector<PlaceComparison> PlacePatches::compare() const {
  std::vector<std::array<std::optional<PlaceComparison>, ComparedPlace::kMostOthers>> found(places_.size());
  tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(places_.size()), [&](std::uint32_t i) {
    const std::optional<Patch>& reference = patches_[i][0];
    if (!reference || !has_texture(*reference)) return;
    for (std::uint32_t k = 0; k < ComparedPlace::kMostOthers; ++k)
      if (const std::optional<Patch>& other = patches_[i][k + 1])
        found[i][k] = PlaceComparison{i, k, shift_between(*reference, *other)};
  });
  std::vector<PlaceComparison> comparisons;
  for (const auto& of_place : found)
    for (const auto& one : of_place)
      if (one) comparisons.push_back(*one);
  return comparisons;
}

}  // namespace gpvc::atlas
