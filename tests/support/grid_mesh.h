// A flat mesh for tests and benchmarks.
#pragma once

#include "io/scene.h"

namespace gpvc::test {

/// A grid of columns x rows squares of edge `cell` from (0, 0, z), two counter-clockwise triangles each.
inline Mesh grid_mesh(int columns, int rows, double cell, double z = 0) {
  Mesh mesh;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x) mesh.positions.push_back({x * cell, y * cell, z});
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (columns + 1) + x); };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  return mesh;
}

}  // namespace gpvc::test
