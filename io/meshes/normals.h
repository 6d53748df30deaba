// Smooth normals of a mesh, for writers.
#pragma once

#include <array>
#include <vector>

#include "io/scene.h"

namespace gpvc::io {

/// Per position, of unit length: the normals of its faces weighted by their angles there (Thürmer and Wüthrich 1998),
/// so that a surface's normals do not depend on how it is cut into triangles. Edges with any number of faces are fine.
/// Where nothing or no direction is left of the sum (faces back to back), the first face's normal; +z for a position in
/// no face with an area. O(faces).
std::vector<std::array<float, 3>> vertex_normals(const Mesh& mesh);

}  // namespace gpvc::io
