// The mesh around a place, as a grid of points that a view's frame has some pixels apart.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "atlas/charts/charts.h"
#include "io/scene.h"

namespace gpvc::atlas {

/// Points along each edge of a grid, a coarse pixel (io::kCoarsePixel) of the frame apart.
inline constexpr std::size_t kPatchEdge = 24;

/// A place on the mesh: where the frame of a view has it, and a face there.
struct SurfacePlace {
  ViewId reference{};
  PixelPoint at;
  std::uint32_t face = 0;
};

/// Row-major: a point lies so many times the ray of its position (ray_of) from the reference's centre. In floats it lies within a ten
/// millionth of its distance of where it should, which no photo resolves. The place is between the four points in the middle.
using GridDepths = std::array<float, kPatchEdge * kPatchEdge>;

struct SurfaceGrid {
  GridDepths depth;
  /// Per point, on which it lies; kNoOwner beyond the mesh, on the plane of the place's face.
  std::array<std::uint32_t, kPatchEdge * kPatchEdge> faces;
};

/// The position of a point of the grid in the frame of the reference.
PixelPoint grid_position(const SurfacePlace& place, std::size_t column, std::size_t row);

/// The first faces that the reference's rays meet, of those that are connected with the place's face within the grid; where there
/// is none, the plane of that face. nullopt where a ray does not meet that plane, and where there are more than some thousand faces.
/// O(faces around the place).
std::optional<SurfaceGrid> surface_around(const Mesh& mesh, const FaceNeighbours& neighbours, const Scene& scene,
                                          const SurfacePlace& place);

/// Where the reference's ray meets the plane of the place's face; nullopt where it does not.
std::optional<WorldPoint> point_on_face(const Mesh& mesh, const Scene& scene, const SurfacePlace& place);

/// How positions of the frame of another view move with those of the reference, row-major, on the plane of the place's face.
/// nullopt where either does not see the plane.
std::optional<std::array<double, 4>> other_from_reference(const Mesh& mesh, const Scene& scene,
                                                          const SurfacePlace& place, ViewId other);

}  // namespace gpvc::atlas
