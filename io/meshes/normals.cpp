#include "io/meshes/normals.h"

#include <cmath>

#include "io/vector.h"

namespace gpvc::io {
namespace {

struct Sum {
  WorldPoint normals{}, first{};
  double angles = 0;
};

std::array<float, 3> direction_of(const Sum& sum) {
  // Each term has a relative error of a few 2^-52: for a thousand faces, a sum below this is rounding alone.
  constexpr double kRounding = 0x1p-40;
  WorldPoint v = sum.normals;
  double size = std::hypot(v.x, v.y, v.z);
  if (!(size > kRounding * sum.angles)) {
    v = sum.first;
    size = std::hypot(v.x, v.y, v.z);
  }
  if (!(size > 0)) return {0, 0, 1};
  return {static_cast<float>(v.x / size), static_cast<float>(v.y / size), static_cast<float>(v.z / size)};
}

}  // namespace

std::vector<std::array<float, 3>> vertex_normals(const Mesh& mesh) {
  const std::vector<WorldPoint>& positions = mesh.written_positions();
  std::vector<Sum> sums(positions.size());
  for (const Triangle& face : mesh.faces) {
    std::array<WorldPoint, 3> edges;
    for (std::size_t corner = 0; corner < 3; ++corner)
      edges[corner] = positions[face[(corner + 1) % 3]] - positions[face[corner]];
    const WorldPoint across = cross(edges[0], edges[1]);
    const double area = std::hypot(across.x, across.y, across.z);
    if (!(area > 0) || !std::isfinite(area)) continue;
    const WorldPoint normal{across.x / area, across.y / area, across.z / area};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      // The angle between this edge and the previous one reversed; the cross product is the same at every corner.
      const double angle = std::atan2(area, -dot(edges[corner], edges[(corner + 2) % 3]));
      Sum& sum = sums[face[corner]];
      if (sum.angles == 0) sum.first = normal;
      sum.angles += angle;
      sum.normals = sum.normals + angle * normal;
    }
  }
  std::vector<std::array<float, 3>> normals;
  normals.reserve(sums.size());
  for (const Sum& sum : sums) normals.push_back(direction_of(sum));
  return normals;
}

}  // namespace gpvc::io
