// Small shifts that bring the photos of a scene into line with each other on the mesh. Parts of the public match_photos() and
// fit_alignment().
#pragma once

#include <array>
#include <span>
#include <vector>

#include "atlas/alignment/cut_places.h"
#include "atlas/alignment/surface_grid.h"
#include "atlas/atlas.h"
#include "atlas/charts/charts.h"

namespace gpvc::atlas {

/// As the public match_photos(), in so many bytes: the fewer, the more often photos are fetched. The matches are the same.
std::vector<PhotoMatch> match_photos(const AtlasInput& input, const FaceNeighbours& neighbours, const CutPlaces& cuts,
                                     std::size_t bytes);
/// More would hardly save a fetch.
inline constexpr std::size_t kMatchBytes = std::size_t{75} << 20;

/// The scene as the fields have it. \param fields empty, or one a view
Scene aligned_scene(const Scene& scene, std::span<const ShiftField> fields);

/// What the shift fields have removed of the shift between two photos at a place: the shift without fields is that with them plus
/// this. In pixels of the reference's frame; (0, 0) where either does not show the place's plane.
std::array<double, 2> shift_by_fields(const AtlasInput& input, const SurfacePlace& place, ViewId other);

/// Row-major; nullopt where a view shows so little of what the other shows that the shift between both is not known.
std::optional<std::array<double, 4>> inverse(const std::array<double, 4>& matrix);

}  // namespace gpvc::atlas
