// Finds out whether the mesh lies where the photos show it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "../../io/image.h"
#include "../../io/scene.h"
#include "../../labeling/labeling.h"
#include "fit_verdict.h"

namespace gpvc::checks {

/// What was measured, in one clause without an end.
std::string photo_fit_text(const MeshFit& fit);
std::string tie_point_fit_text(const MeshFit& fit);

/// Pixels of a photo to one that surfaces are looked for in, each way. Errors of a pixel or two of mesh and poses vanish.
inline int reduction(int width, int height) { return std::max(1, std::max(width, height) / 1000); }

/// The luma of a photo, reduced to at most 2000 pixels a side.
struct SmallPhoto {
  int factor = 1;  ///< reduction()
  Image image;     ///< 1 channel; empty: the photo is not looked at
};

/// O(pixels).
SmallPhoto small_photo(const Image& photo);

/// By 180 degrees.
SmallPhoto turned_over(SmallPhoto photo);
/// Left and right exchanged.
SmallPhoto mirrored(SmallPhoto photo);

/// True for at most 96 of `views` views, which are used one after the other: runs of four, which overlap in most flights.
bool is_compared(std::size_t number, std::size_t views);

/// A face that two views see.
struct Place {
  FaceId face{};
  ViewId a{}, b{};
};

/// At most 3072 faces with two of their candidate views that have a small photo, seen from directions apart by 3 to 30 degrees,
/// the nearest of them: the first such faces that are found in steps which spread over all of them, ascending. `left_out`: views not
/// to be used. O(candidates) at most.
std::vector<Place> choose_places(const Mesh& mesh, const Scene& scene, const labeling::CostTable& candidates,
                                 std::span<const SmallPhoto> photos, std::span<const ViewId> left_out);

/// The same for every face whose front two of the photos may frame, one for each patch of a photo; occlusion is ignored.
/// O(faces x views).
std::vector<Place> framed_places(const Mesh& mesh, const Scene& scene, std::span<const SmallPhoto> photos);

/// Compares what view a shows of each place with what view b shows along a's line of sight, up to 24 pixels in front of
/// the mesh and behind it. With a mesh in its place the photos agree best at the mesh; with one elsewhere they do so at
/// any distance, or nowhere. Agreement is the correlation of two patches, which no exposure changes. Chance is what the
/// same photos give with the patch of another place. Deterministic, TBB. O(places).
MeshFit measure_fit(const Mesh& mesh, const Scene& scene, std::span<const SmallPhoto> photos,
                    std::span<const Place> places);

/// The places at which photos agree on the mesh, less those that they do by chance.
inline double places_on_mesh(const MeshFit& fit) { return fit.share * static_cast<double>(fit.found); }

}  // namespace gpvc::checks
