// A mesh on the ground: x to the east, y to the north, z its height.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/checks/input.h"

namespace gpvc::query {

struct Ground {
  Mesh mesh;           ///< its positions on the ground, its faces
  std::string wkt{};   ///< reference system of x and y; empty: none is known
  std::string name{};  ///< a sentence on what x, y and z are
  /// Longitudes and latitudes of points on the ground (WGS 84, in degrees). \pre there is a wkt. Throws Error.
  void to_lonlat(std::vector<WorldPoint>& points) const;
};

/// As orthophotos have it: in the scene's reference system, or without one by the direction that its cameras call up. Throws Error
/// where PROJ cannot take the mesh there.
Ground ground_of(const checks::Input& input);

}  // namespace gpvc::query
