#include "app/query/coverage_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/query/sharpness.h"

namespace gpvc::query {
namespace {

using evaluate::Json;  // which writes what is not finite as null

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

// Between the mean normal of an area and up, in degrees: 0 flat ground, 90 a wall, above 90 an underside.
double tilt_of(const Area& area, const Ground& ground) {
  WorldPoint normal;
  for (const FaceId face : area.faces) normal = normal + normal_of(ground.mesh, face);
  return std::acos(std::clamp(unit(normal).z, -1.0, 1.0)) * 180 / std::numbers::pi;
}

std::vector<std::array<double, 2>> placed(const GroundRing& ring, const Ground& ground) {
  if (ground.wkt.empty()) return ring;
  std::vector<WorldPoint> points;
  for (const auto& [x, y] : ring) points.push_back({x, y, 0});
  ground.to_lonlat(points);
  std::vector<std::array<double, 2>> result;
  constexpr double kMillimetre = 1e-8;  // of a degree
  for (const WorldPoint& p : points) result.push_back({rounded(p.x, kMillimetre), rounded(p.y, kMillimetre)});
  return result;
}

Json polygons_json(const std::vector<GroundPolygon>& polygons, const Ground& ground) {
  Json all = Json::array();
  for (const GroundPolygon& polygon : polygons) {
    Json rings = Json::array({placed(polygon.outer, ground)});
    for (const GroundRing& hole : polygon.holes) rings.push_back(placed(hole, ground));
    all.push_back(std::move(rings));
  }
  return all;
}

}  // namespace

Json areas_geojson(const std::vector<Area>& areas, const Ground& ground, const CellGrid& grid) {
  Json features = Json::array();
  for (std::size_t n = 0; n < areas.size(); ++n) {
    const Area& area = areas[n];
    Json properties = {{"area", n + 1},
                       {"reason", name_of(kLackNames, area.lack)},
                       {"surface", area.surface},
                       {"faces", area.faces.size()},
                       {"least_photos", area.least_photos},
                       {"most_photos", area.most_photos},
                       {"best_gsd", area.gsd},
                       {"best_angle", area.angle},
                       {"tilt", rounded(tilt_of(area, ground), 0.1)}};
    features.push_back({{"type", "Feature"},
                        {"properties", std::move(properties)},
                        {"geometry",
                         {{"type", "MultiPolygon"},
                          {"coordinates", polygons_json(outline_of(ground.mesh, area.faces, grid), ground)}}}});
  }
  Json json = {{"type", "FeatureCollection"}};
  if (ground.wkt.empty()) json["coordinates"] = ground.name;
  json["features"] = std::move(features);
  return json;
}

std::string areas_table(const std::vector<Area>& areas, const checks::Input& input, const Ground& ground) {
  std::string table =
      "area,reason,surface,faces,x,y,z,longitude,latitude,tilt,least_photos,most_photos,best_gsd,best_angle\n";
  for (std::size_t n = 0; n < areas.size(); ++n) {
    const Area& area = areas[n];
    const WorldPoint at = area.middle + input.scene.offset;
    std::string degrees = ",";
    if (!ground.wkt.empty()) {
      WorldPoint sum;
      double all = 0;
      for (const FaceId face : area.faces) {
        const double surface = length(normal_of(ground.mesh, face));
        sum = sum + middle_of(ground.mesh, face) * surface;
        all += surface;
      }
      std::vector<WorldPoint> middle{all > 0 ? sum * (1 / all) : middle_of(ground.mesh, area.faces.front())};
      ground.to_lonlat(middle);
      degrees = fmt::format("{:.8f},{:.8f}", middle.front().x, middle.front().y);
    }
    table += fmt::format("{},{},{:.6g},{},{:.3f},{:.3f},{:.3f},{},{:.1f},{},{},{},{}\n", n + 1,
                         name_of(kLackNames, area.lack), area.surface, area.faces.size(), at.x, at.y, at.z, degrees,
                         tilt_of(area, ground), area.least_photos, area.most_photos, number_text(area.gsd),
                         number_text(area.angle));
  }
  return table;
}

}  // namespace gpvc::query
