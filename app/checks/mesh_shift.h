// Finds by how much a mesh is moved against the points of a scene.
#pragma once

#include <optional>
#include <span>

#include "io/scene.h"
#include "io/tie_points.h"

namespace gpvc::checks {

/// A move of the mesh after which far more points lie on it.
struct MeshShift {
  WorldPoint by;                      ///< to be added to the mesh's positions, to 1 / 400 of its size
  double share = 0, share_as_is = 0;  ///< of the points, that lie on the mesh with it and without
};

/// Searches moves of up to a fifth of the mesh's size along each axis, and of up to twice its size along z. nullopt where no move brings half of the points onto the
/// mesh, and twice as many as lie on it as it is. O(faces + area / size^2 of the finest cells); TBB.
std::optional<MeshShift> find_shift(const Mesh& mesh, std::span<const io::TiePoint> points);

}  // namespace gpvc::checks
