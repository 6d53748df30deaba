// Bounding boxes of meshes and places.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "scene.h"

namespace gpvc {

/// An axis-aligned bounding box; empty until a point is added.
struct Box {
  WorldPoint low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const WorldPoint& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};

/// Of all positions, including those that no face uses.
inline Box box_of(const Mesh& mesh) {
  Box box;
  for (const WorldPoint& p : mesh.positions) box.add(p);
  return box;
}

/// Of the faces from begin to end.
inline Box box_of_faces(const Mesh& mesh, std::size_t begin, std::size_t end) {
  Box box;
  for (std::size_t f = begin; f != end; ++f)
    for (const std::uint32_t v : mesh.faces[f]) box.add(mesh.positions[v]);
  return box;
}

}  // namespace gpvc
