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

// To so many parts of a unit.
double rounded(double value, double parts) { return std::round(value * parts) / parts; }

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }

// Between the mean normal of an area and up, in degrees: 0 flat ground, 90 a wall, above 90 an underside.
double tilt_of(const Area& area, const Ground& ground) {
  WorldPoint normal;
  for (const FaceId face : area.faces) normal = normal + normal_of(ground.mesh, face);
  return std::acos(std::clamp(unit(normal).z, -1.0, 1.0)) * 180 / std::numbers::pi;
}

// Takes all corners to degrees at once: PROJ needs longer to find the way than for the points.
void place_on_globe(std::vector<std::vector<GroundPolygon>>& areas, const Ground& ground) {
  std::vector<WorldPoint> points;
  const auto for_each_corner = [&](const auto& use) {
    for (std::vector<GroundPolygon>& polygons : areas)
      for (GroundPolygon& polygon : polygons) {
        std::ranges::for_each(polygon.outer, use);
        for (GroundRing& hole : polygon.holes) std::ranges::for_each(hole, use);
      }
  };
  for_each_corner([&](const std::array<double, 2>& corner) { points.push_back({corner[0], corner[1], 0}); });
  ground.to_lonlat(points);
  constexpr double kMillimetres = 1e8;  // a degree has, about
  std::size_t next = 0;
  for_each_corner([&](std::array<double, 2>& corner) {
    const WorldPoint& p = points[next++];
    corner = {rounded(p.x, kMillimetres), rounded(p.y, kMillimetres)};
  });
}

WorldPoint middle_on_ground(const Area& area, const Ground& ground) {
  WorldPoint sum;
  double all = 0;
  for (const FaceId face : area.faces) {
    const double surface = surface_of(ground.mesh, face);
    sum = sum + middle_of(ground.mesh, face) * surface;
    all += surface;
  }
  return all > 0 ? sum * (1 / all) : middle_of(ground.mesh, area.faces.front());
}

Json polygons_json(const std::vector<GroundPolygon>& polygons) {
  Json all = Json::array();
  for (const GroundPolygon& polygon : polygons) {
    Json rings = Json::array({polygon.outer});
    for (const GroundRing& hole : polygon.holes) rings.push_back(hole);
    all.push_back(std::move(rings));
  }
  return all;
}

}  // namespace

Json areas_geojson(const std::vector<Area>& areas, const Ground& ground, const CellGrid& grid) {
  std::vector<std::vector<GroundPolygon>> outlines;
  for (const Area& area : areas) outlines.push_back(outline_of(ground.mesh, area.faces, grid));
  if (!ground.wkt.empty() && !areas.empty()) place_on_globe(outlines, ground);
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
                       {"tilt", rounded(tilt_of(area, ground), 10)}};
    features.push_back({{"type", "Feature"},
                        {"properties", std::move(properties)},
                        {"geometry", {{"type", "MultiPolygon"}, {"coordinates", polygons_json(outlines[n])}}}});
  }
  Json json = {{"type", "FeatureCollection"}};
  if (ground.wkt.empty()) json["coordinates"] = ground.name;
  json["features"] = std::move(features);
  return json;
}

std::string areas_table(const std::vector<Area>& areas, const checks::Input& input, const Ground& ground) {
  std::string table =
      "area,reason,surface,faces,x,y,z,longitude,latitude,tilt,least_photos,most_photos,best_gsd,best_angle\n";
  std::vector<WorldPoint> middles;
  if (!ground.wkt.empty() && !areas.empty()) {
    for (const Area& area : areas) middles.push_back(middle_on_ground(area, ground));
    ground.to_lonlat(middles);
  }
  for (std::size_t n = 0; n < areas.size(); ++n) {
    const Area& area = areas[n];
    const WorldPoint at = area.middle + input.scene.offset;
    const std::string degrees = middles.empty() ? "," : fmt::format("{:.8f},{:.8f}", middles[n].x, middles[n].y);
    table += fmt::format("{},{},{:.6g},{},{:.3f},{:.3f},{:.3f},{},{:.1f},{},{},{},{}\n", n + 1,
                         name_of(kLackNames, area.lack), area.surface, area.faces.size(), at.x, at.y, at.z, degrees,
                         tilt_of(area, ground), area.least_photos, area.most_photos, number_text(area.gsd),
                         number_text(area.angle));
  }
  return table;
}

}  // namespace gpvc::query
