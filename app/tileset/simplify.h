// Parts of a mesh with a quarter of their faces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../../io/scene.h"

namespace gpvc::tileset {

/// A part of a mesh, simplified.
struct Simplified {
  std::vector<Triangle> faces;  ///< of vertices that the mesh has
  double error = 0;             ///< at most how far the surface is from the part's, as quadrics tell; units of the mesh
};

/// To a quarter of the faces, or as far as the part's border allows, which stays as it is. Flat ground keeps faces of modest
/// size and shape, too, some five mean edges at most. Corners at one position count as one vertex, whether or not faces
/// share it. Both sides of faces that are there twice, turned over, stay the same; faces that are there twice with the same
/// front are left out. O(faces log faces).
Simplified simplified(const Mesh& mesh, std::span<const std::uint32_t> faces);

}  // namespace gpvc::tileset
