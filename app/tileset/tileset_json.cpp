#include "app/tileset/tileset_json.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "io/reference_system.h"
#include "io/vector.h"

namespace gpvc::tileset {
namespace {

using Json = nlohmann::ordered_json;

// Of an axis-aligned box: its middle and three half edges.
Json volume(const TileBox& box) {
  Json numbers = Json::array();
  for (std::size_t i = 0; i < 3; ++i) numbers.push_back((box.low.at[i] + box.high.at[i]) / 2);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 3; ++i) numbers.push_back(i == axis ? (box.high.at[i] - box.low.at[i]) / 2 : 0.0);
  return {{"box", numbers}};
}

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

// Where the coordinates around a point of the system lie: the point, and how it moves with each of them.
struct Placement {
  WorldPoint origin;
  std::array<WorldPoint, 3> axes;
};

// North, east and up at a place on the ellipsoid.
std::optional<Placement> place_of_enu(const std::string& system, const WorldPoint& at) {
  double latitude = 0, longitude = 0;
  const char* end = system.data() + system.size();
  const auto [comma, bad] = std::from_chars(system.data() + std::string_view("ENU:").size(), end, latitude);
  if (bad != std::errc{} || comma == end || *comma != ',') return std::nullopt;
  if (std::from_chars(comma + 1, end, longitude).ec != std::errc{}) return std::nullopt;
  std::array<WorldPoint, 1> origin{WorldPoint{longitude, latitude, 0}};
  io::transform_points("EPSG:4979", io::kGeocentric, origin);
  const double u = latitude * std::numbers::pi / 180, v = longitude * std::numbers::pi / 180;
  const Placement there{origin[0],
                        {WorldPoint{-std::sin(v), std::cos(v), 0},
                         {-std::sin(u) * std::cos(v), -std::sin(u) * std::sin(v), std::cos(u)},
                         {std::cos(u) * std::cos(v), std::cos(u) * std::sin(v), std::sin(u)}}};
  return Placement{there.origin + there.axes[0] * at.x + there.axes[1] * at.y + there.axes[2] * at.z, there.axes};
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
  return options.srs.starts_with("ENU:") ? place_of_enu(options.srs, at) : place_of(options.srs, at);
}

class Writer {
 public:
  explicit Writer(std::span<const std::vector<Tile>> levels) : levels_(levels), boxes_(levels.size()) {
    for (std::size_t k = 0; k < levels.size(); ++k)
      for (std::size_t n = 0; n < levels[k].size(); ++n) {
        TileBox box = levels[k][n].box;
        for (std::size_t child = 4 * n; k > 0 && child < 4 * n + 4; ++child) box.add(boxes_[k - 1][child]);
        boxes_[k].push_back(box);
      }
  }

  const TileBox& box() const { return boxes_.back()[0]; }

  Json tile(std::size_t level, std::size_t number) const {
    const Tile& tile = levels_[level][number];
    Json json{{"boundingVolume", volume(boxes_[level][number])}, {"geometricError", tile.error}, {"refine", "REPLACE"}};
    if (!tile.file.empty()) json["content"] = {{"uri", tile.file}};
    for (std::size_t child = 4 * number; level > 0 && child < 4 * number + 4; ++child)
      if (!boxes_[level - 1][child].is_empty) json["children"].push_back(this->tile(level - 1, child));
    return json;
  }

 private:
  std::span<const std::vector<Tile>> levels_;
  std::vector<std::vector<TileBox>> boxes_;  ///< with those of the children
};

}  // namespace

void TileBox::add(const TilePoint& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    low.at[i] = is_empty ? p.at[i] : std::min(low.at[i], p.at[i]);
    high.at[i] = is_empty ? p.at[i] : std::max(high.at[i], p.at[i]);
  }
  is_empty = false;
}

void TileBox::add(const TileBox& box) {
  if (box.is_empty) return;
  add(box.low);
  add(box.high);
}

TilePoint tile_from_world(const io::ModelOptions& options, const WorldPoint& p) {
  const std::array<TilePoint, 3> axes = world_axes(options.up);
  const WorldPoint local = p - options.offset;
  TilePoint q;
  for (std::size_t i = 0; i < 3; ++i)
    q.at[i] = local.x * axes[0].at[i] + local.y * axes[1].at[i] + local.z * axes[2].at[i];
  return q;
}

double geometric_error(double surface, double texel) {
  // A texel that is drawn larger than a screen's pixel shows that detail is missing. Viewers refine a tile whose error is seen
  // larger than some 16 pixels (the default of CesiumJS): an error of so many texels makes them refine where a texel would be
  // larger than two pixels.
  constexpr double kErrorTexels = 8;
  return std::max(surface, kErrorTexels * texel);
}

std::string obstacle_to_geocentric(const io::ModelOptions& options) {
  try {
    if (options.srs.empty() || !place_of_offset(options)) return "no reference system is known";
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

std::optional<std::array<double, 16>> geocentric_from_tile(const io::ModelOptions& options) {
  if (!obstacle_to_geocentric(options).empty()) return std::nullopt;
  const std::optional<Placement> place = place_of_offset(options);
  const std::array<TilePoint, 3> axes = world_axes(options.up);
  std::array<double, 16> matrix{};
  // The axes of the world are orthonormal in tile coordinates, so the inverse is the transpose.
  for (std::size_t column = 0; column < 3; ++column) {
    const WorldPoint to =
        place->axes[0] * axes[0].at[column] + place->axes[1] * axes[1].at[column] + place->axes[2] * axes[2].at[column];
    matrix[4 * column] = to.x;
    matrix[4 * column + 1] = to.y;
    matrix[4 * column + 2] = to.z;
  }
  matrix[12] = place->origin.x;
  matrix[13] = place->origin.y;
  matrix[14] = place->origin.z;
  matrix[15] = 1;
  return matrix;
}

std::string tileset_text(std::span<const std::vector<Tile>> levels, const io::ModelOptions& options) {
  const Writer writer(levels);
  Json root = writer.tile(levels.size() - 1, 0);
  if (const auto matrix = geocentric_from_tile(options)) root["transform"] = *matrix;
  // How much is missing where nothing is drawn: all of it.
  double diagonal2 = 0;
  for (std::size_t i = 0; i < 3; ++i) diagonal2 += std::pow(writer.box().high.at[i] - writer.box().low.at[i], 2);
  const Json tileset{{"asset", {{"version", "1.1"}, {"generator", "gpvc"}}},
                     {"geometricError", std::max(std::sqrt(diagonal2), levels.back()[0].error)},
                     {"root", std::move(root)}};
  return tileset.dump(1) + "\n";
}

}  // namespace gpvc::tileset
