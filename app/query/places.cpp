#include "app/query/places.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <span>

#include "app/tileset/placing.h"
#include "io/box.h"
#include "io/reference_system.h"
#include "io/view_rules.h"

namespace gpvc::query {
namespace {

using visibility::SurfacePoint;

// The weights of a face's corners at a point of it.
std::array<double, 3> weights_in(const Mesh& mesh, FaceId face, const WorldPoint& p) {
  const auto [a, b, c] = mesh.faces[index(face)];
  const WorldPoint &pa = mesh.positions[a], &pb = mesh.positions[b], &pc = mesh.positions[c];
  const WorldPoint normal = cross(pb - pa, pc - pa);
  const double squared = dot(normal, normal);
  if (!(squared > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
  const double of_b = dot(cross(p - pa, pc - pa), normal) / squared,
               of_c = dot(cross(pb - pa, p - pa), normal) / squared;
  return {1 - of_b - of_c, of_b, of_c};
}

WorldPoint weighed(std::span<const WorldPoint> positions, const Triangle& face, const std::array<double, 3>& weights) {
  return positions[face[0]] * weights[0] + positions[face[1]] * weights[1] + positions[face[2]] * weights[2];
}

bool is_finite(const WorldPoint& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

std::string text_of(const Place& place) {
  return place.has_height ? fmt::format("{}, {}, {}", place.at.x, place.at.y, place.at.z)
                          : fmt::format("{}, {}", place.at.x, place.at.y);
}

}  // namespace

std::string system_of(const Scene& scene) {
  const auto place = tileset::place_of_enu(scene.srs);
  return place ? tileset::plane_around(*place, 0) : scene.srs;
}

PlaceFinder::PlaceFinder(const checks::Input& input, const PhotoFinder& finder) : input_(input), finder_(finder) {
  const Box box = box_of(input.mesh);
  limit_ = input.mesh.positions.empty() ? 0 : length(box.high - box.low) / 50;
  if (input.mesh.file_positions.empty()) return;
  as_in_file_.positions = input.mesh.file_positions;
  as_in_file_.faces = input.mesh.faces;
  file_stage_.emplace(as_in_file_);
}

void PlaceFinder::fail(const Place& place, const std::string& reason) const {
  throw InputError(input_.mesh_file, place.name, fmt::format("the point ({}) {}", text_of(place), reason));
}

std::optional<SurfacePoint> PlaceFinder::nearest_in_file(const WorldPoint& place) const {
  if (!file_stage_) return finder_.nearest(place);
  const auto found = file_stage_->nearest(place);
  if (!found) return std::nullopt;
  const FaceId face = found->faces.front();
  const std::array<double, 3> weights = weights_in(as_in_file_, face, found->at);
  auto point = finder_.nearest(weighed(input_.mesh.positions, input_.mesh.faces[index(face)], weights));
  if (point) point->distance = found->distance;
  return point;
}

// The highest point of the surface over or under a place.
std::optional<SurfacePoint> PlaceFinder::highest(const WorldPoint& place) const {
  std::optional<WorldPoint> best;
  for (const Triangle& face : input_.mesh.faces) {
    const WorldPoint &a = input_.mesh.positions[face[0]], &b = input_.mesh.positions[face[1]],
                     &c = input_.mesh.positions[face[2]];
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) continue;
    const double of_b = ((place.x - a.x) * (c.y - a.y) - (place.y - a.y) * (c.x - a.x)) / area;
    const double of_c = ((b.x - a.x) * (place.y - a.y) - (b.y - a.y) * (place.x - a.x)) / area;
    if (!(of_b >= 0 && of_c >= 0 && of_b + of_c <= 1)) continue;
    const double z = a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z);
    if (!best || z > best->z) best = WorldPoint{place.x, place.y, z};
  }
  return best ? finder_.nearest(*best) : std::nullopt;
}

SurfacePoint PlaceFinder::find(const Place& place) const {
  if (!is_finite(place.at)) fail(place, "is not made of numbers");
  const Scene& scene = input_.scene;
  std::optional<SurfacePoint> point;
  if (place.srs.empty()) {
    point = place.has_height ? nearest_in_file(place.at) : highest(place.at);
    // Scenes whose large coordinates are written from an origin: people know the large ones.
    if (!(scene.offset == WorldPoint{})) {
      const WorldPoint local = place.at - scene.offset;
      const auto other = place.has_height ? finder_.nearest(local) : highest(local);
      if (other && (!point || other->distance < point->distance)) point = other;
    }
  } else {
    const std::string system = system_of(scene);
    if (system.empty())
      fail(place, fmt::format("is in {}, and the scene names no reference system to take it to",
                              place.srs == io::kGeoJsonSystem ? "longitude and latitude" : place.srs));
    std::array<WorldPoint, 1> at{place.at};
    try {
      if (place.srs != scene.srs) io::transform_points(place.srs, system, at);
    } catch (const Error& error) {
      fail(place, fmt::format("cannot be brought to the scene's reference system: {}", error.what()));
    }
    const WorldPoint local = at.front() - scene.offset;
    point = place.has_height ? finder_.nearest(local) : highest(local);
  }
  if (!point) fail(place, "has no surface of the mesh above or below it");
  if (point->distance > limit_)
    fail(place,
         fmt::format("lies {:.6g} from the surface, farther than {:.6g}, a fiftieth of the mesh's extent; is it in "
                     "other coordinates?",
                     point->distance, limit_));
  return *point;
}

WorldPoint PlaceFinder::in_file(const SurfacePoint& point) const {
  if (input_.mesh.file_positions.empty()) return point.at;
  const FaceId face = point.faces.front();
  return weighed(input_.mesh.file_positions, input_.mesh.faces[index(face)], weights_in(input_.mesh, face, point.at));
}

std::optional<WorldPoint> PlaceFinder::in_system(const SurfacePoint& point) const {
  if (input_.scene.srs.empty()) return std::nullopt;
  return point.at + input_.scene.offset;
}

}  // namespace gpvc::query
