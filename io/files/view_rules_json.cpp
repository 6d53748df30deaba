// Rules about photos and parts of a mesh in JSON and GeoJSON.
#include <iterator>

#include "io/files/geojson.h"
#include "io/files/view_rules_text.h"
#include "io/scenes/json_file.h"

namespace gpvc::io {
namespace {

std::vector<std::string> photos(const Json& value, const RulePlace& at) {
  std::vector<std::string> names;
  for (const Json& name : value.is_array() ? value : Json::array({value})) {
    if (!name.is_string() || name.get_ref<const std::string&>().empty())
      at.fail("expected names of photos, or a list of them");
    names.push_back(name.get<std::string>());
  }
  if (names.empty()) at.fail("expected at least one photo");
  return names;
}

void read_choice(const Json& object, ListedViewRule& rule, const RulePlace& at) {
  rule.allow = object.contains("allow");
  if (rule.allow == object.contains("forbid")) at.fail("expected one of 'allow' and 'forbid'");
  rule.photos = photos(object[rule.allow ? "allow" : "forbid"], at);
}

void read_heights(const std::vector<double>& z, GroundRegion& region, const RulePlace& at) {
  if (z[0] > z[1]) at.fail("expected 'z' as the lower and the higher end");
  region.low = z[0];
  region.high = z[1];
}

class GeoRules {
 public:
  explicit GeoRules(const JsonFile& json) : json_(json) {}

  std::vector<ListedViewRule> read() const {
    const Json& root = json_.root();
    const std::string type = json_.text("", root, "type"), srs = geojson_system(json_);
    std::vector<ListedViewRule> rules;
    if (type == "Feature") {
      rules.push_back(rule("the feature", root));
    } else if (type == "FeatureCollection") {
      const Json& features = json_.objects("", root, "features");
      for (std::size_t n = 0; n < features.size(); ++n)
        rules.push_back(rule("feature " + std::to_string(n + 1), features[n]));
    } else {
      json_.fail("", "expected a Feature or a FeatureCollection, found " + quote(type));
    }
    for (ListedViewRule& each : rules) each.srs = srs;
    return rules;
  }

 private:
  ListedViewRule rule(const std::string& place, const Json& feature) const {
    const RulePlace at{json_.path(), place};
    // GIS programs write all columns of a table, those without a value as null.
    Json properties = json_.object(place, feature, "properties");
    for (auto each = properties.begin(); each != properties.end();)
      each = each->is_null() ? properties.erase(each) : std::next(each);
    for (const char* choice : {"allow", "forbid"})
      if (properties.contains(choice) && properties[choice].is_string())
        properties[choice] = names_in(properties[choice].get<std::string>());
    ListedViewRule rule;
    rule.place = place;
    read_choice(properties, rule, at);
    GroundRegion region{corners(place, json_.object(place, feature, "geometry"))};
    if (properties.contains("z")) read_heights(json_.numbers(place, properties, "z", 2), region, at);
    rule.region = std::move(region);
    return rule;
  }

  std::vector<std::array<double, 2>> corners(const std::string& place, const Json& geometry) const {
    const std::string type = json_.text(place, geometry, "type");
    if (type != "Polygon" && type != "MultiPolygon")
      json_.fail(place, "expected a Polygon or MultiPolygon, found " + quote(type));
    if (!geometry.contains("coordinates")) json_.fail(place, "expected the coordinates of a polygon");
    const Json& listed = geometry["coordinates"];
    std::vector<std::array<double, 2>> all;
    if (type == "Polygon")
      add_rings(place, listed, all);
    else if (listed.is_array())
      for (const Json& polygon : listed) add_rings(place, polygon, all);
    if (all.empty()) json_.fail(place, "expected the coordinates of a polygon");
    return all;
  }

  // Rings follow each other, with a way from the first corner of all to each ring and back again. A point crosses both or
  // none, so that holes are holes.
  void add_rings(const std::string& place, const Json& rings, std::vector<std::array<double, 2>>& all) const {
    if (!rings.is_array()) json_.fail(place, "expected a list of rings as the coordinates of a polygon");
    for (const Json& ring : rings) {
      const std::size_t first = all.size();
      for (const Json& corner : ring) {
        const bool is_point = corner.is_array() && corner.size() >= 2 && corner[0].is_number() && corner[1].is_number();
        if (!is_point) json_.fail(place, "expected corners of a polygon as lists of two numbers");
        all.push_back({corner[0].get<double>(), corner[1].get<double>()});
      }
      if (all.size() > first && all.back() != all[first]) all.push_back(all[first]);  // some leave it out
      constexpr std::size_t kLeast = 4;
      if (all.size() - first < kLeast) json_.fail(place, "expected at least three corners of a ring");
      if (first > 0) all.push_back(all[0]);
    }
  }

  const JsonFile& json_;
};

class JsonRules {
 public:
  JsonRules(const std::filesystem::path& file, std::string_view text) : json_(file, text) {}

  std::vector<ListedViewRule> read() const {
    if (json_.root().is_object() && json_.root().contains("type")) return GeoRules(json_).read();
    if (!json_.root().is_object()) json_.fail("", "expected an object with a list 'rules'");
    const Json& listed = json_.objects("", json_.root(), "rules");
    std::vector<ListedViewRule> rules;
    for (std::size_t n = 0; n < listed.size(); ++n) rules.push_back(rule("rule " + std::to_string(n + 1), listed[n]));
    return rules;
  }

 private:
  ListedViewRule rule(const std::string& place, const Json& object) const {
    const RulePlace at{json_.path(), place};
    ListedViewRule rule;
    rule.place = place;
    const bool box = object.contains("box"), polygon = object.contains("polygon"), faces = object.contains("faces"),
               photo = object.contains("photo");
    if (box + polygon + faces + photo != 1) at.fail("expected one of 'box', 'polygon', 'faces' and 'photo'");
    if (photo)
      rule.region = photo_region(json_.text(place, object, "photo"), json_.numbers(place, object, "pixels", 2, 2), at);
    if (box) rule.region = box_region(json_.numbers(place, object, "box", 3, 2), at);
    if (faces) rule.region = face_region(object["faces"], at);
    if (polygon) {
      const Json& corners = object["polygon"];
      GroundRegion region = ground_region(
          json_.numbers(place, object, "polygon", 2, std::max<std::size_t>(1, corners.is_array() ? corners.size() : 0)),
          at);
      if (object.contains("z")) read_heights(json_.numbers(place, object, "z", 2), region, at);
      rule.region = std::move(region);
    }
    if (photo && !object.contains("allow") && !object.contains("forbid"))
      rule.photos = {std::get<PhotoRegion>(rule.region).photo};
    else
      read_choice(object, rule, at);
    refuse_other_members(object, at);
    return rule;
  }

  static FaceRegion face_region(const Json& list, const RulePlace& at) {
    const auto number = [](const Json& value) -> std::optional<std::uint32_t> {
      if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
      return value.get<std::uint32_t>();
    };
    if (list.is_string()) return faces_in_file(list.get_ref<const std::string&>(), at);
    if (!list.is_array() || list.empty()) at.fail("expected a list of faces, or a file with one, as 'faces'");
    FaceRegion region;
    for (const Json& item : list) {
      const bool range = item.is_array() && item.size() == 2;
      region.ranges.push_back(face_range(number(range ? item[0] : item), number(range ? item[1] : item), at));
    }
    return region;
  }

  // A mistyped member would make a rule that says something else.
  static void refuse_other_members(const Json& object, const RulePlace& at) {
    constexpr std::string_view kKnown[] = {"box",    "polygon", "z",      "faces", "photo",
                                           "pixels", "allow",   "forbid", "note"};
    for (const auto& [key, value] : object.items())
      if (std::ranges::find(kKnown, key) == std::end(kKnown))
        at.fail("does not know " + quote(key) +
                "; expected box, polygon, z, faces, photo, pixels, allow, forbid or note");
    if (object.contains("z") && !object.contains("polygon")) at.fail("'z' belongs to a polygon");
    if (object.contains("pixels") && !object.contains("photo")) at.fail("'pixels' belong to a photo");
  }

  JsonFile json_;
};

}  // namespace

std::vector<ListedViewRule> json_view_rules(const std::filesystem::path& file, std::string_view text) {
  return JsonRules(file, text).read();
}

}  // namespace gpvc::io
