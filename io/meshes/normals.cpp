#include "io/meshes/normals.h"

#include <cmath>

namespace gpvc::io {
namespace {

using Vector = std::array<double, 3>;

Vector between(const WorldPoint& from, const WorldPoint& to) { return {to.x - from.x, to.y - from.y, to.z - from.z}; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vector& a) { return std::hypot(a[0], a[1], a[2]); }

struct Sum {
  Vector normals{}, first{};
  double angles = 0;
};

void add(Sum& sum, const Vector& normal, double angle) {
  if (sum.angles == 0) sum.first = normal;
  sum.angles += angle;
  for (std::size_t axis = 0; axis < 3; ++axis) sum.normals[axis] += angle * normal[axis];
}

std::array<float, 3> direction_of(const Sum& sum) {
  // Each term has a relative error of a few 2^-52: for a thousand faces, a sum below this is rounding alone.
  constexpr double kRounding = 0x1p-40;
  Vector v = sum.normals;
  double size = length(v);
  if (!(size > kRounding * sum.angles)) {
    v = sum.first;
    size = length(v);
  }
  if (!(size > 0)) return {0, 0, 1};
  return {static_cast<float>(v[0] / size), static_cast<float>(v[1] / size), static_cast<float>(v[2] / size)};
}

}  // namespace

std::vector<std::array<float, 3>> vertex_normals(const Mesh& mesh) {
  std::vector<Sum> sums(mesh.positions.size());
  for (const Triangle& face : mesh.faces) {
    const std::array<Vector, 3> edges{between(mesh.positions[face[0]], mesh.positions[face[1]]),
                                      between(mesh.positions[face[1]], mesh.positions[face[2]]),
                                      between(mesh.positions[face[2]], mesh.positions[face[0]])};
    Vector normal = cross(edges[0], edges[1]);
    const double area = length(normal);
    if (!(area > 0) || !std::isfinite(area)) continue;
    for (double& component : normal) component /= area;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      // The angle between this edge and the previous one reversed; the cross product is the same at every corner.
      const double angle = std::atan2(area, -dot(edges[corner], edges[(corner + 2) % 3]));
      add(sums[face[corner]], normal, angle);
    }
  }
  std::vector<std::array<float, 3>> normals;
  normals.reserve(sums.size());
  for (const Sum& sum : sums) normals.push_back(direction_of(sum));
  return normals;
}

}  // namespace gpvc::io
