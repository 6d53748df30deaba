#include "atlas/charts/flat_chart.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "atlas/vector3.h"

namespace gpvc::atlas {

namespace {

/// The face laid flat: first corner at the origin, second on the x axis.
struct FlatTriangle {
  double bx, cx, cy;
};

FlatTriangle lay_flat(const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const Vector3 ab = b - a, ac = c - a;
  const double length = norm(ab);
  if (!(length > 0)) return {0, norm(ac), 0};
  const double along = dot(ab, ac) / length;
  return {length, along, norm(cross(ab, ac)) / length};
}

/// Depth at which the view sees the face, at a pixel that shows it, near the middle of its coverage.
std::optional<double> seen_depth(const Mesh& mesh, std::uint32_t face, const View& view,
                                 const visibility::FaceCoverage& entry, const visibility::CoverageTable& table) {
  const auto& t = mesh.faces[face];
  const Vector3 normal =
      cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
  const double offset = dot(normal, mesh.positions[t[0]] - view.pose.centre);
  const int middle_x = entry.x0 + entry.width / 2, middle_y = entry.y0 + entry.height / 2;
  std::optional<double> depth;
  double nearest = 0;
  for (int y = entry.y0; y < entry.y0 + entry.height; ++y) {
    for (int x = entry.x0; x < entry.x0 + entry.width; ++x) {
      if (!table.sees(entry, x, y)) continue;
      const double distance = std::hypot(x - middle_x, y - middle_y);
      if (depth && distance >= nearest) continue;
      const double z = offset / dot(normal, ray_direction(view, {x + 0.5, y + 0.5}));
      if (!(z > 0) || !std::isfinite(z)) continue;
      depth = z, nearest = distance;
    }
  }
  return depth;
}

double nearest_vertex_depth(const Mesh& mesh, std::uint32_t face, const View& view) {
  double depth = 0;
  for (const auto v : mesh.faces[face]) {
    const double z = camera_from_world(view.pose, mesh.positions[v]).z;
    if (z > 0 && (depth == 0 || z < depth)) depth = z;
  }
  return depth;
}

}  // namespace

bool is_grazing(const TexelTriangle& p, const Mesh& mesh, std::size_t face) {
  const auto& t = mesh.faces[face];
  const FlatTriangle flat = lay_flat(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
  if (!(flat.bx > 0) || !(flat.cy > 0)) return false;
  // Columns of the Jacobian pixels per metre: along the first edge, and across it.
  const double ux = (p[1].x - p[0].x) / flat.bx, uy = (p[1].y - p[0].y) / flat.bx;
  const double vx = (p[2].x - p[0].x - flat.cx * ux) / flat.cy, vy = (p[2].y - p[0].y - flat.cx * uy) / flat.cy;
  const double squares = ux * ux + uy * uy + vx * vx + vy * vy, area = std::abs(ux * vy - uy * vx);
  const double root = std::sqrt(std::max(0.0, squares * squares - 4 * area * area));
  const double longest = std::sqrt((squares + root) / 2);
  return area < 0.1 * longest * longest;
}

FlatFace flatten(const Mesh& mesh, std::uint32_t face, const Scene& scene, ViewId label, const CoverageIndex& coverage,
                 const FlatLimits& limits) {
  const auto& t = mesh.faces[face];
  // The longest edge runs along x, so that the box is at most twice the triangle.
  std::array<std::size_t, 3> turn{0, 1, 2};
  const auto edge = [&](std::size_t i) { return norm(mesh.positions[t[(i + 1) % 3]] - mesh.positions[t[i]]); };
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (edge(i) > edge(longest)) longest = i;
  for (std::size_t i = 0; i < 3; ++i) turn[i] = (longest + i) % 3;
  const FlatTriangle flat =
      lay_flat(mesh.positions[t[turn[0]]], mesh.positions[t[turn[1]]], mesh.positions[t[turn[2]]]);

  const View& view = scene.views[index(label)];
  const visibility::FaceCoverage* entry = coverage.find(FaceId{face}, label);
  std::optional<double> depth;
  if (entry) depth = seen_depth(mesh, face, view, *entry, coverage.table());
  if (!depth) depth = nearest_vertex_depth(mesh, face, view);
  double texels_per_m = *depth > 0 ? std::max(view.camera.fx, view.camera.fy) / *depth : 0;
  const double area = flat.bx * flat.cy;  // of the box
  const double most_texels = kTexelsPerSeenPixel * (entry ? std::max(4.0, double(entry->visible)) : 64.0);
  if (area * texels_per_m * texels_per_m > most_texels) texels_per_m = std::sqrt(most_texels / area);
  if (limits.texel_size > 0) texels_per_m = std::min(texels_per_m, 1 / limits.texel_size);
  texels_per_m *= limits.reduction;
  // Two texels of slack: half a texel of border on each side and the rounding up of the box.
  const double extent = std::max(flat.bx, flat.cy) * texels_per_m;
  if (extent > limits.room - 2) texels_per_m *= (limits.room - 2) / extent;

  FlatFace result;
  const double width = flat.bx * texels_per_m, height = flat.cy * texels_per_m;
  result.corners[turn[0]] = {0.5, 0.5};
  result.corners[turn[1]] = {0.5 + width, 0.5};
  result.corners[turn[2]] = {0.5 + std::clamp(flat.cx * texels_per_m, 0.0, width), 0.5 + height};
  result.width = std::max(1, static_cast<int>(std::ceil(width + 1)));
  result.height = std::max(1, static_cast<int>(std::ceil(height + 1)));
  return result;
}

}  // namespace gpvc::atlas
