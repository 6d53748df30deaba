// What readers of GeoJSON share.
#pragma once

#include <string>

#include "io/scenes/json_file.h"
#include "io/view_rules.h"

namespace gpvc::io {

/// RFC 7946 has no "crs" any more; programs write it for systems other than longitude and latitude.
inline std::string geojson_system(const JsonFile& json) {
  const Json& root = json.root();
  if (!root.contains("crs") || root["crs"].is_null()) return kGeoJsonSystem;
  return json.text("crs", json.object("crs", json.object("", root, "crs"), "properties"), "name");
}

}  // namespace gpvc::io
