#include "atlas/baking/plane_map.h"

#include <cmath>

#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// A texel of a projected chart lies where its ray meets the plane.
std::optional<PlaneMap> map_projected(const Mesh& mesh, const Triangle& t, const Chart& chart, const View& view) {
  const WorldPoint& p = mesh.positions[t[0]];
  const WorldPoint normal = cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p);
  const double k = dot(normal, p - view.pose.centre);
  if (k == 0 || !std::isfinite(k)) return std::nullopt;
  const WorldPoint r1 = ray_of(view, chart.frame_position(0, 0));
  const WorldPoint rx = ray_of(view, chart.frame_position(1, 0)) - r1;
  const WorldPoint ry = ray_of(view, chart.frame_position(0, 1)) - r1;
  const double size = std::abs(k), sign = k < 0 ? -1 : 1;
  return PlaneMap{
      view.pose.centre,      rx * size, ry * size, r1 * size, sign * dot(normal, rx), sign * dot(normal, ry),
      sign * dot(normal, r1)};
}

/// The texels of a flat chart, and of one that is given, are affine images of their faces.
std::optional<PlaneMap> map_flat(const Mesh& mesh, const Triangle& t, const TexelTriangle& c) {
  const double ux = c[1].x - c[0].x, uy = c[1].y - c[0].y, vx = c[2].x - c[0].x, vy = c[2].y - c[0].y;
  const double area = ux * vy - uy * vx;
  if (area == 0) return std::nullopt;
  const WorldPoint& a = mesh.positions[t[0]];
  const WorldPoint ab = mesh.positions[t[1]] - a, ac = mesh.positions[t[2]] - a;
  const WorldPoint dx = ab * (vy / area) - ac * (uy / area), dy = ac * (ux / area) - ab * (vx / area);
  return PlaneMap{a, dx, dy, dx * -c[0].x + dy * -c[0].y};
}

}  // namespace

std::optional<PlaneMap> plane_map(const Mesh& mesh, const Scene& scene, const ChartSet& set, std::uint32_t face) {
  const Chart& chart = set.charts[set.face_chart[face]];
  if (chart.kind == ChartKind::flat || chart.given) return map_flat(mesh, mesh.faces[face], set.corners[face]);
  return map_projected(mesh, mesh.faces[face], chart, scene.views[index(chart.view)]);
}

FrameFromTexel frame_from_texel(const PlaneMap& map, const View& view) {
  const WorldPoint shift = map.base - view.pose.centre;
  const auto column = [&](const WorldPoint& d, double w) {
    const CameraPoint p = to_camera_axes(view.pose, d + shift * w);
    const Camera& c = view.camera;
    return WorldPoint{c.fx * p.x + c.cx * p.z, c.fy * p.y + c.cy * p.z, p.z};
  };
  const WorldPoint x = column(map.dx, map.wx), y = column(map.dy, map.wy), one = column(map.d1, map.w1);
  return {{x.x, y.x, one.x, x.y, y.y, one.y, x.z, y.z, one.z}};
}

}  // namespace gpvc::atlas
