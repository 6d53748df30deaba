#include "atlas/alignment/place_patches.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "atlas/charts/chart_raster.h"

namespace gpvc::atlas {

namespace {

/// The reference and the others.
std::array<ViewId, PlaceSurface::kViews> views_of(const ComparedPlace& place) {
  std::array<ViewId, PlaceSurface::kViews> views{place.on.reference};
  std::ranges::copy(place.others, views.begin() + 1);
  return views;
}

/// Which of the first `count` views show the grid's faces whole, but for a tenth of its points.
std::array<bool, PlaceSurface::kViews> showing(const AtlasInput& input, const SurfaceGrid& grid,
                                               const std::array<ViewId, PlaceSurface::kViews>& views,
                                               std::size_t count) {
  constexpr std::size_t kViews = PlaceSurface::kViews;
  std::array<std::size_t, kViews> points{};
  std::array<bool, kViews> sees{};
  std::uint32_t before = kNoOwner;
  for (const std::uint32_t face : grid.faces) {
    if (face == kNoOwner) continue;
    if (face != before) {
      sees = {};
      if (input.tags[face] == labeling::FaceTag::seen)
        for (const std::uint32_t view : input.candidates.views_of(face))
          for (std::size_t k = 0; k < count; ++k) sees[k] = sees[k] || view == index(views[k]);
    }
    before = face;
    for (std::size_t k = 0; k < count; ++k) points[k] += sees[k] ? 1 : 0;
  }
  std::array<bool, kViews> shows{};
  for (std::size_t k = 0; k < count; ++k) shows[k] = 10 * points[k] >= 9 * grid.faces.size();
  return shows;
}

}  // namespace

std::vector<PlaceSurface> find_surfaces(const AtlasInput& input, const FaceNeighbours& neighbours,
                                        std::span<const ComparedPlace> places) {
  std::vector<PlaceSurface> surfaces(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const ComparedPlace& place = places[i];
    const auto grid = surface_around(input.mesh, neighbours, input.scene, place.on);
    if (!grid) return;
    const auto shows = showing(input, *grid, views_of(place), 1 + place.count);
    // Without the reference nothing is compared, and without an other.
    if (shows[0] && std::ranges::count(shows, true) >= 2) surfaces[i] = {grid->depth, shows};
  });
  return surfaces;
}

PlacePatches::PlacePatches(const AtlasInput& input, std::span<const ComparedPlace> places,
                           std::vector<PlaceSurface> surfaces, std::span<const PlaceSurface> shared)
    : input_(&input), places_(places), surfaces_(std::move(surfaces)), shared_(shared), patches_(places.size()) {
  of_view_ = group_items<Taken>(input.scene.views.size(), [&](const auto& emit) {
    for (std::uint32_t i = 0; i < places.size(); ++i) {
      const auto views = views_of(places[i]);
      for (std::uint32_t k = 0; k < kPatches; ++k)
        if (surface(i).shown[k]) emit(index(views[k]), Taken{i, k});
    }
  });
}

void PlacePatches::take(ViewId view, const Image& means) {
  const CoarseLuma luma = coarse_luma(means);
  const std::span<const Taken> mine = std::as_const(of_view_)[index(view)];
  tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t i) {
    const auto [place, patch] = mine[i];
    patches_[place][patch] = take_patch(input_->scene, places_[place].on, surface(place).depths, view, luma);
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
