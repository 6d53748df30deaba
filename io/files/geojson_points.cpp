#include "io/geojson_points.h"

#include <cmath>

#include "io/file_bytes.h"
#include "io/files/geojson.h"
#include "io/files/text_scan.h"

namespace gpvc::io {
namespace {

class PointReader {
 public:
  explicit PointReader(const JsonFile& json) : json_(json) {}

  GeoPoints read() {
    const Json& root = json_.root();
    const std::string type = json_.text("", root, "type");
    found_.srs = geojson_system(json_);
    if (type == "FeatureCollection") {
      const Json& features = json_.objects("", root, "features");
      for (std::size_t n = 0; n < features.size(); ++n) feature("feature " + std::to_string(n + 1), features[n]);
    } else if (type == "Feature") {
      feature("the feature", root);
    } else {
      geometry("the geometry", root, "the geometry");
    }
    if (found_.points.empty()) json_.fail("", "holds no point");
    return std::move(found_);
  }

 private:
  void feature(const std::string& place, const Json& feature) {
    std::string name = place;
    const auto take = [&](const Json& object, const char* key) {
      const auto value = object.find(key);
      if (value == object.end()) return;
      if (value->is_string()) name = value->get<std::string>();
      if (value->is_number_integer()) name = value->dump();
    };
    take(feature, "id");
    if (const auto properties = feature.find("properties"); properties != feature.end() && properties->is_object())
      take(*properties, "name");
    geometry(place, json_.object(place, feature, "geometry"), name);
  }

  void geometry(const std::string& place, const Json& geometry, const std::string& name) {
    const std::string type = json_.text(place, geometry, "type");
    const auto listed = geometry.find("coordinates");
    if (type != "Point" && type != "MultiPoint")
      json_.fail(place, "expected a Point or a MultiPoint, found " + quote(type));
    if (listed == geometry.end() || !listed->is_array()) json_.fail(place, "expected the coordinates of a point");
    if (type == "Point") return point(place, *listed, name);
    for (std::size_t n = 0; n < listed->size(); ++n)
      point(place, (*listed)[n], name + ", point " + std::to_string(n + 1));
  }

  void point(const std::string& place, const Json& coordinates, const std::string& name) {
    GeoPoint point{{}, coordinates.is_array() && coordinates.size() > 2, name};
    double* const to[] = {&point.at.x, &point.at.y, &point.at.z};
    const std::size_t count = point.has_height ? 3 : 2;
    for (std::size_t i = 0; i < count; ++i) {
      if (!coordinates.is_array() || coordinates.size() <= i || !coordinates[i].is_number() ||
          !std::isfinite(coordinates[i].get<double>()))
        json_.fail(place, "expected two or three numbers as the coordinates of a point");
      *to[i] = coordinates[i].get<double>();
    }
    found_.points.push_back(std::move(point));
  }

  const JsonFile& json_;
  GeoPoints found_;
};

}  // namespace

GeoPoints read_geojson_points(const std::filesystem::path& file) {
  const FileBytes bytes(file);
  const JsonFile json(file, bytes.view());
  if (!json.root().is_object()) json.fail("", "expected GeoJSON: an object with a type");
  return PointReader(json).read();
}

}  // namespace gpvc::io
