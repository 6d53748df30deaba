// Points that a GIS program has written as GeoJSON (RFC 7946).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene.h"

namespace gpvc::io {

struct GeoPoint {
  WorldPoint at;           ///< east or longitude, north or latitude, height
  bool has_height = true;  ///< else z is 0 and means nothing
  std::string name;        ///< its "name", its id, or its place in the file: "feature 3"
};

struct GeoPoints {
  std::vector<GeoPoint> points;  ///< at least one
  std::string srs;               ///< as the file states it, else longitude and latitude (kGeoJsonSystem)
};

/// Of a Feature, a FeatureCollection or a geometry, whose geometries are Points and MultiPoints. Throws InputError.
GeoPoints read_geojson_points(const std::filesystem::path& file);

}  // namespace gpvc::io
