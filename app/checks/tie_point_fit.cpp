#include "app/checks/tie_point_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/checks/mesh_fit.h"
#include "app/checks/sighting_shift.h"
#include "io/error.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

/// Where the line of sight of a view through a point meets the plane of a face.
std::optional<WorldPoint> surface_behind(const Mesh& mesh, FaceId face, const View& view, const WorldPoint& point) {
  const Triangle& t = mesh.faces[index(face)];
  const WorldPoint& corner = mesh.positions[t[0]];
  const WorldPoint normal = cross(mesh.positions[t[1]] - corner, mesh.positions[t[2]] - corner);
  const WorldPoint ray = point - view.pose.centre;
  const double scale = dot(normal, corner - view.pose.centre) / dot(normal, ray);
  return scale > 0 && std::isfinite(scale) ? std::optional(view.pose.centre + scale * ray) : std::nullopt;
}

/// The faces that a view sees around a point, at the middles of the four pixels that it lies between: at an edge, either may
/// be the point's. kNoFace where it sees none.
std::array<FaceId, 4> seen_faces(const View& view, const visibility::Ivm& ivm, const WorldPoint& point) {
  std::array<FaceId, 4> faces;
  faces.fill(kNoFace);
  const auto at = pixel_from_world(view, point);
  if (!at || !(at->x >= 0 && at->y >= 0 && at->x < ivm.width && at->y < ivm.height)) return faces;
  const int x0 = static_cast<int>(std::floor(at->x - 0.5)), y0 = static_cast<int>(std::floor(at->y - 0.5));
  for (int i = 0; i < 4; ++i)
    if (const int x = x0 + i % 2, y = y0 + i / 2; x >= 0 && y >= 0 && x < ivm.width && y < ivm.height)
      faces[static_cast<std::size_t>(i)] = ivm.at(x, y);
  return faces;
}

/// The distance of two points in reduced pixels; nullopt where one lies behind the camera.
std::optional<double> distance_in(const View& view, const WorldPoint& p, const WorldPoint& q) {
  const auto at = pixel_from_world(view, p), other = pixel_from_world(view, q);
  if (!at || !other) return {};
  return std::hypot(at->x - other->x, at->y - other->y) / reduction(view.camera.width, view.camera.height);
}

}  // namespace

std::vector<io::TiePoint> read_tie_points(const Scene& scene, results::Observer& observer) {
  constexpr std::size_t kMost = 100'000;  // read and compared in well below a second
  try {
    for (const SightingShift& shift : sighting_shifts(scene, io::read_sightings(scene, kMost)))
      observer.warning(shift_text(scene, shift));
    return io::read_tie_points(scene, kMost);
  } catch (const InputError& error) {
    observer.warning(std::string(error.what()) + "; its points are not compared with the mesh", error.cures());
    return {};
  }
}

TiePointFit::TiePointFit(const Input& input, std::vector<io::TiePoint> points)
    : input_(input), points_(std::move(points)) {
  std::ranges::stable_sort(points_, {}, &io::TiePoint::a);
}

FitGroups TiePointFit::counts(ViewId view, const visibility::Ivm& ivm) const {
  // The points' own errors are about a pixel of the photos; coarse and smoothed meshes add theirs. Of right meshes 94, 98
  // and 99 % lie within two pixels (three scenes from photos), of those moved by 5 % of their size 21, 31 and 55 %.
  constexpr double kOnMesh = 2;
  FitGroups groups{};
  const View& a = input_.scene.views[index(view)];
  for (auto at = std::ranges::lower_bound(points_, view, {}, &io::TiePoint::a); at != points_.end() && at->a == view;
       ++at) {
    const io::TiePoint& point = *at;
    const View& b = input_.scene.views[index(point.b)];
    std::optional<double> nearest;
    for (const FaceId face : seen_faces(a, ivm, point.position)) {
      if (face == kNoFace) continue;
      const std::optional<WorldPoint> seen = surface_behind(input_.mesh, face, a, point.position);
      const std::optional<double> distance = seen ? distance_in(b, point.position, *seen) : std::nullopt;
      if (distance) nearest = std::min(*distance, nearest.value_or(*distance));
    }
    if (!nearest) continue;
    SurfaceCounts& group = groups[static_cast<std::size_t>(at - points_.begin()) % kFitGroups];
    group.places += 1;
    group.found += 1;
    (*nearest <= kOnMesh ? group.on_mesh : group.off_mesh) += 1;
  }
  return groups;
}

}  // namespace gpvc::checks
