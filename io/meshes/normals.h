// Smooth normals of a mesh, for writers.
#pragma once

#include <array>
#include <vector>

#include "io/scene.h"

namespace gpvc::io {

/// Per written position, of unit length: the normals of its faces weighted by their angles there (Thürmer and Wüthrich 1998),
/// so that they do not depend on how a surface is cut into triangles. Edges may have any number of faces. Where the sum
/// vanishes (faces back to back) it is the first face's normal; +z for a position in no face with an area. O(faces).
std::vector<std::array<float, 3>> vertex_normals(const Mesh& mesh);

}  // namespace gpvc::io
