#include "atlas/charts/flat_chart.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// The face laid flat: first corner at the origin, second on the x axis.
struct FlatTriangle {
  double bx, cx, cy;
};

FlatTriangle lay_flat(const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const WorldPoint ab = b - a, ac = c - a;
  const double base = length(ab);
  if (!(base > 0)) return {0, length(ac), 0};
  const double along = dot(ab, ac) / base;
  return {base, along, length(cross(ab, ac)) / base};
}

/// Depth of the face at the pixel that shows it closest to the middle of its coverage.
std::optional<double> seen_depth(const Mesh& mesh, std::uint32_t face, const View& view,
                                 const visibility::FaceCoverage& entry, const visibility::CoverageTable& table) {
  const auto& t = mesh.faces[face];
  const WorldPoint& a = mesh.positions[t[0]];
  const WorldPoint normal = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
  const double offset = dot(normal, a - view.pose.centre);
  const int middle_x = entry.x0 + entry.width / 2, middle_y = entry.y0 + entry.height / 2;
  std::optional<double> depth;
  double nearest = 0;
  for (int y = entry.y0; y < entry.y0 + entry.height; ++y) {
    for (int x = entry.x0; x < entry.x0 + entry.width; ++x) {
      if (!table.sees(entry, x, y)) continue;
      const double distance = std::hypot(x - middle_x, y - middle_y);
      if (depth && distance >= nearest) continue;
      const double z = offset / dot(normal, ray_of(view, {x + 0.5, y + 0.5}));
      if (!(z > 0) || !std::isfinite(z)) continue;
      depth = z;
      nearest = distance;
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

/// The corners' order in which the longest edge comes first. Laid along x, it makes a box of at most twice the
/// triangle's area.
std::array<std::size_t, 3> longest_edge_first(const Mesh& mesh, const Triangle& t) {
  const auto edge = [&](std::size_t i) { return length(mesh.positions[t[(i + 1) % 3]] - mesh.positions[t[i]]); };
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (edge(i) > edge(longest)) longest = i;
  return {longest, (longest + 1) % 3, (longest + 2) % 3};
}

/// Pixels of the view that the whole face takes; 0 if it reaches behind the camera.
double frame_area(const Mesh& mesh, std::uint32_t face, const View& view) {
  const std::optional<ProjectedFace> projected = project_face(mesh, face, view);
  return projected ? std::abs(doubled_area(projected->corners)) / 2 : 0;
}

/// Texels per world unit that match the view's pixels, within kTexelsPerSeenPixel for a box of the given area.
double seen_density(const Mesh& mesh, std::uint32_t face, const View& view, const CoverageIndex& coverage, ViewId id,
                    double area) {
  const visibility::FaceCoverage* entry = coverage.find(FaceId{face}, id);
  std::optional<double> depth;
  if (entry) depth = seen_depth(mesh, face, view, *entry, coverage.table());
  if (!depth) depth = nearest_vertex_depth(mesh, face, view);
  const double density = *depth > 0 ? std::max(view.camera.fx, view.camera.fy) / *depth : 0;
  const double pixels = entry ? double(entry->visible) : frame_area(mesh, face, view);
  const double most_texels = kTexelsPerSeenPixel * std::max(4.0, pixels);
  return area * density * density > most_texels ? std::sqrt(most_texels / area) : density;
}

}  // namespace

std::optional<ProjectedFace> project_face(const Mesh& mesh, std::uint32_t face, const View& view) {
  ProjectedFace result;
  for (std::size_t i = 0; i < 3; ++i) {
    const CameraPoint p = camera_from_world(view.pose, mesh.positions[mesh.faces[face][i]]);
    if (!(p.z > 0)) return std::nullopt;
    const PixelPoint q = pixel_from_camera(view.camera, p);
    result.corners[i] = {q.x, q.y};
    result.depths[i] = p.z;
  }
  return result;
}

bool is_grazing(const TexelTriangle& p, const Mesh& mesh, std::size_t face) {
  const auto& t = mesh.faces[face];
  const FlatTriangle flat = lay_flat(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
  if (!(flat.bx > 0) || !(flat.cy > 0)) return false;
  // Columns of the Jacobian, pixels per world unit: along the first edge, and across it.
  const double ux = (p[1].x - p[0].x) / flat.bx, uy = (p[1].y - p[0].y) / flat.bx;
  const double vx = (p[2].x - p[0].x - flat.cx * ux) / flat.cy, vy = (p[2].y - p[0].y - flat.cx * uy) / flat.cy;
  const double squares = ux * ux + uy * uy + vx * vx + vy * vy, area = std::abs(ux * vy - uy * vx);
  const double root = std::sqrt(std::max(0.0, squares * squares - 4 * area * area));
  const double longest = std::sqrt((squares + root) / 2);
  return area < 0.1 * longest * longest;
}

double bend(const TexelTriangle& p, const std::array<double, 3>& depths) {
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double a = std::sqrt(depths[i]), b = std::sqrt(depths[j]);
    most = std::max(most, std::hypot(p[j].x - p[i].x, p[j].y - p[i].y) * std::abs(a - b) / (a + b));
  }
  return most;
}

bool is_bent(const AtlasInput& input, std::uint32_t face) {
  const ViewId label = input.labels[face];
  if (label == kNoView || !labeling::has_candidates(input.tags[face])) return false;
  const std::optional<ProjectedFace> projected = project_face(input.mesh, face, input.scene.views[index(label)]);
  return projected && bend(projected->corners, projected->depths) > kMostBend;
}

FlatFace flatten(const Mesh& mesh, std::uint32_t face, const Scene& scene, ViewId label, const CoverageIndex& coverage,
                 const FlatLimits& limits) {
  const auto& t = mesh.faces[face];
  const std::array<std::size_t, 3> turn = longest_edge_first(mesh, t);
  const FlatTriangle flat =
      lay_flat(mesh.positions[t[turn[0]]], mesh.positions[t[turn[1]]], mesh.positions[t[turn[2]]]);
  double density = seen_density(mesh, face, scene.views[index(label)], coverage, label, flat.bx * flat.cy);
  if (limits.texel_size > 0) density = std::min(density, 1 / limits.texel_size);
  density *= limits.reduction;
  // Two texels of slack: half a texel of border on each side, and rounding the box up to whole texels.
  const double extent = std::max(flat.bx, flat.cy) * density;
  if (extent > limits.room - 2) density *= (limits.room - 2) / extent;

  FlatFace result;
  const double width = flat.bx * density, height = flat.cy * density;
  result.corners[turn[0]] = {0.5, 0.5};
  result.corners[turn[1]] = {0.5 + width, 0.5};
  result.corners[turn[2]] = {0.5 + std::clamp(flat.cx * density, 0.0, width), 0.5 + height};
  result.width = std::max(1, static_cast<int>(std::ceil(width + 1)));
  result.height = std::max(1, static_cast<int>(std::ceil(height + 1)));
  return result;
}

}  // namespace gpvc::atlas
