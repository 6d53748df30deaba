#include "app/tileset/placing.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "io/error.h"
#include "io/reference_system.h"
#include "io/vector.h"

namespace gpvc::tileset {
namespace {

constexpr std::string_view kEnu = "ENU:";
constexpr const char* kDegrees = "EPSG:4979";  // with heights above the ellipsoid

WorldPoint turned(const std::array<double, 4>& q, const WorldPoint& p) {
  const WorldPoint axis{q[0], q[1], q[2]}, twice = cross(axis, p) * 2;
  return p + twice * q[3] + cross(axis, twice);
}

// The axes of the world in tile coordinates.
std::array<TilePoint, 3> world_axes(io::UpAxis up) {
  std::array<TilePoint, 3> axes;
  const std::array<WorldPoint, 3> units{WorldPoint{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (std::size_t i = 0; i < 3; ++i) {
    // glTF's y is up; viewers turn it by a quarter around x.
    const WorldPoint p = turned(io::gltf_rotation(up), units[i]);
    axes[i] = {{std::round(p.x), std::round(-p.z), std::round(p.y)}};
  }
  return axes;
}

// Where coordinates around a point lie: the point, and how it moves with each of them.
struct Placement {
  WorldPoint origin;
  std::array<WorldPoint, 3> axes;
};

// East, north and up at a place.
Placement east_north_up(double latitude, double longitude, double height) {
  std::array<WorldPoint, 1> origin{WorldPoint{longitude, latitude, height}};
  io::transform_points(kDegrees, io::kGeocentric, origin);
  const double u = latitude * std::numbers::pi / 180, v = longitude * std::numbers::pi / 180;
  return {origin[0],
          {WorldPoint{-std::sin(v), std::cos(v), 0},
           {-std::sin(u) * std::cos(v), -std::sin(u) * std::sin(v), std::cos(u)},
           {std::cos(u) * std::cos(v), std::cos(u) * std::sin(v), std::sin(u)}}};
}

std::optional<Placement> around_enu(const std::string& system, const WorldPoint& at) {
  const auto place = place_of_enu(system);
  if (!place) return std::nullopt;
  Placement there = east_north_up((*place)[0], (*place)[1], 0);
  there.origin = there.origin + there.axes[0] * at.x + there.axes[1] * at.y + there.axes[2] * at.z;
  return there;
}

Placement place_of(const std::string& system, const WorldPoint& at) {
  // Differences over a unit of the system to both sides.
  std::array<WorldPoint, 7> points{at,
                                   {at.x + 1, at.y, at.z},
                                   {at.x - 1, at.y, at.z},
                                   {at.x, at.y + 1, at.z},
                                   {at.x, at.y - 1, at.z},
                                   {at.x, at.y, at.z + 1},
                                   {at.x, at.y, at.z - 1}};
  io::transform_points(system, io::kGeocentric, points);
  const auto axis = [&](std::size_t i) { return (points[2 * i + 1] - points[2 * i + 2]) * 0.5; };
  return {points[0], {axis(0), axis(1), axis(2)}};
}

// Throws Error where PROJ does not know the system, lacks a grid for its heights, or the place is beyond it.
std::optional<Placement> place_of_offset(const io::ModelOptions& options) {
  const WorldPoint at = options.offset + options.srs_offset;
  return options.srs.starts_with(kEnu) ? around_enu(options.srs, at) : place_of(options.srs, at);
}

Matrix matrix_of(const Placement& tile) {
  Matrix matrix{};
  for (std::size_t column = 0; column < 4; ++column) {
    const WorldPoint& to = column < 3 ? tile.axes[column] : tile.origin;
    matrix[4 * column] = to.x;
    matrix[4 * column + 1] = to.y;
    matrix[4 * column + 2] = to.z;
  }
  matrix[15] = 1;
  return matrix;
}

// Of the tile's coordinates, from that of the world's around the offset.
Placement of_tile(const Placement& world, io::UpAxis up) {
  // The axes of the world are orthonormal in tile coordinates, so the inverse is the transpose.
  const std::array<TilePoint, 3> axes = world_axes(up);
  Placement tile{world.origin, {}};
  for (std::size_t i = 0; i < 3; ++i)
    tile.axes[i] = world.axes[0] * axes[0].at[i] + world.axes[1] * axes[1].at[i] + world.axes[2] * axes[2].at[i];
  return tile;
}

Placement at_place(const Place& place) {
  const Placement there = east_north_up(place.latitude, place.longitude, place.height);
  const double heading = place.heading * std::numbers::pi / 180, c = std::cos(heading), s = std::sin(heading);
  const auto& [east, north, up] = there.axes;
  return {there.origin, {east * c - north * s, east * s + north * c, up}};
}

std::string point_text(const WorldPoint& p) { return fmt::format("({}, {}, {})", p.x, p.y, p.z); }

std::string remark_on_heights(const io::ModelOptions& options) {
  const std::string& srs = options.srs;
  if (srs.starts_with(kEnu)) return "";
  const std::optional<std::string> level = io::system_name(srs).heights;
  if (!level)
    return fmt::format("{} says nothing of heights: the scene's are taken for heights above the ellipsoid", srs);
  if (level->empty()) return "";
  const WorldPoint at = options.offset + options.srs_offset;
  std::array<WorldPoint, 1> above{at};
  io::transform_points(srs, kDegrees, above);
  return fmt::format(
      "heights of {} are above {}, those of the tiles above the ellipsoid: {:.2f} m where the scene's is {}", srs,
      *level, above[0].z, at.z);
}

}  // namespace

std::optional<std::array<double, 2>> place_of_enu(const std::string& system) {
  if (!system.starts_with(kEnu)) return std::nullopt;
  std::array<double, 2> place{};
  const char* end = system.data() + system.size();
  const auto [comma, bad] = std::from_chars(system.data() + kEnu.size(), end, place[0]);
  if (bad != std::errc{} || comma == end || *comma != ',') return std::nullopt;
  if (std::from_chars(comma + 1, end, place[1]).ec != std::errc{}) return std::nullopt;
  return place;
}

TilePoint tile_from_world(const io::ModelOptions& options, const WorldPoint& p) {
  const std::array<TilePoint, 3> axes = world_axes(options.up);
  const WorldPoint local = p - options.offset;
  TilePoint q;
  for (std::size_t i = 0; i < 3; ++i)
    q.at[i] = local.x * axes[0].at[i] + local.y * axes[1].at[i] + local.z * axes[2].at[i];
  return q;
}

std::string obstacle_to_geocentric(const io::ModelOptions& options) {
  try {
    if (options.srs.empty() || !place_of_offset(options)) return "no reference system is known";
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

std::string plane_around(const std::array<double, 2>& place, double height) {
  constexpr double kEarth = 6371000;
  return fmt::format("+proj=tmerc +lat_0={} +lon_0={} +k_0={:.9f} +x_0=0 +y_0=0 +datum=WGS84 +units=m +type=crs",
                     place[0], place[1], 1 + height / kEarth);
}

std::optional<Matrix> geocentric_from_tile(const io::ModelOptions& options) {
  if (!obstacle_to_geocentric(options).empty()) return std::nullopt;
  return matrix_of(of_tile(*place_of_offset(options), options.up));
}

Matrix root_transform(const io::ModelOptions& options, const std::optional<Place>& place) {
  if (const auto matrix = geocentric_from_tile(options)) return *matrix;
  if (place) return matrix_of(at_place(*place));
  return matrix_of(of_tile({options.offset, {WorldPoint{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, options.up));
}

std::string remark_on_placing(const io::ModelOptions& options, const std::optional<Place>& place) {
  const std::string obstacle = obstacle_to_geocentric(options);
  if (obstacle.empty()) return remark_on_heights(options);
  if (!place) return fmt::format("the tiles are in the scene's own coordinates: {}", obstacle);
  return fmt::format("the scene's point {} stands at latitude {}, longitude {}, {} m above the ellipsoid",
                     point_text(options.offset), place->latitude, place->longitude, place->height);
}

void refuse_place(const Scene& scene, const WorldPoint& any, const std::optional<Place>& place) {
  io::ModelOptions options;
  options.offset = any;
  options.srs = scene.srs;
  options.srs_offset = scene.offset;
  if (place && obstacle_to_geocentric(options).empty())
    throw InputError(
        scene.source, "",
        fmt::format("names the reference system {}, which places the tiles: a place is for scenes without", scene.srs));
}

}  // namespace gpvc::tileset
