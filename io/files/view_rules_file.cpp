// Reads rules about photos and parts of a mesh from JSON or CSV; which faces a part has.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/json_file.h"
#include "io/view_rules.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

/// Throws InputError at a place of a file.
struct Place {
  const fs::path& file;
  std::string place;
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file, place, reason); }
};

Region box_region(const std::vector<double>& v, const Place& at) {
  if (v.size() != 6) at.fail("expected two corners of a box, 6 numbers, found " + std::to_string(v.size()));
  return BoxRegion{{std::min(v[0], v[3]), std::min(v[1], v[4]), std::min(v[2], v[5])},
                   {std::max(v[0], v[3]), std::max(v[1], v[4]), std::max(v[2], v[5])}};
}

GroundRegion ground_region(const std::vector<double>& v, const Place& at) {
  if (v.size() < 6 || v.size() % 2 != 0)
    at.fail("expected x and y of at least three corners of a polygon, found " + std::to_string(v.size()) + " numbers");
  GroundRegion region;
  for (std::size_t i = 0; i < v.size(); i += 2) region.corners.push_back({v[i], v[i + 1]});
  return region;
}

std::array<std::uint32_t, 2> face_range(std::optional<std::uint32_t> first, std::optional<std::uint32_t> last,
                                        const Place& at) {
  if (!first || !last || *first > *last)
    at.fail("expected faces as whole numbers from 0 on, and ranges from the lower to the higher");
  return {*first, *last};
}

// --- JSON

class JsonRules {
 public:
  JsonRules(const fs::path& file, std::string_view text) : json_(file, text) {}

  std::vector<ListedViewRule> read() const {
    if (!json_.root().is_object()) json_.fail("", "expected an object with a list 'rules'");
    const Json& listed = json_.objects("", json_.root(), "rules");
    std::vector<ListedViewRule> rules;
    for (std::size_t n = 0; n < listed.size(); ++n) rules.push_back(rule("rule " + std::to_string(n + 1), listed[n]));
    return rules;
  }

 private:
  ListedViewRule rule(const std::string& place, const Json& object) const {
    const Place at{json_.path(), place};
    ListedViewRule rule;
    rule.place = place;
    const bool box = object.contains("box"), polygon = object.contains("polygon"), faces = object.contains("faces");
    if (box + polygon + faces != 1) at.fail("expected one of 'box', 'polygon' and 'faces'");
    if (box) rule.region = box_region(json_.numbers(place, object, "box", 3, 2), at);
    if (faces) rule.region = face_region(object["faces"], at);
    if (polygon) {
      const Json& corners = object["polygon"];
      GroundRegion region = ground_region(
          json_.numbers(place, object, "polygon", 2, std::max<std::size_t>(1, corners.is_array() ? corners.size() : 0)),
          at);
      if (object.contains("z")) {
        const std::vector<double> z = json_.numbers(place, object, "z", 2);
        if (z[0] > z[1]) at.fail("expected 'z' as the lower and the higher end");
        region.low = z[0];
        region.high = z[1];
      }
      rule.region = std::move(region);
    }
    rule.allow = object.contains("allow");
    if (rule.allow == object.contains("forbid")) at.fail("expected one of 'allow' and 'forbid'");
    rule.photos = photos(object[rule.allow ? "allow" : "forbid"], at);
    refuse_other_members(object, at);
    return rule;
  }

  static Region face_region(const Json& list, const Place& at) {
    const auto number = [](const Json& value) -> std::optional<std::uint32_t> {
      if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
      return value.get<std::uint32_t>();
    };
    if (!list.is_array() || list.empty()) at.fail("expected a list of faces as 'faces'");
    FaceRegion region;
    for (const Json& item : list) {
      const bool range = item.is_array() && item.size() == 2;
      region.ranges.push_back(face_range(number(range ? item[0] : item), number(range ? item[1] : item), at));
    }
    return region;
  }

  static std::vector<std::string> photos(const Json& value, const Place& at) {
    std::vector<std::string> names;
    for (const Json& name : value.is_array() ? value : Json::array({value})) {
      if (!name.is_string() || name.get_ref<const std::string&>().empty())
        at.fail("expected names of photos, or a list of them");
      names.push_back(name.get<std::string>());
    }
    if (names.empty()) at.fail("expected at least one photo");
    return names;
  }

  // A mistyped member would make a rule that says something else.
  static void refuse_other_members(const Json& object, const Place& at) {
    constexpr std::string_view kKnown[] = {"box", "polygon", "z", "faces", "allow", "forbid", "note"};
    for (const auto& [key, value] : object.items())
      if (std::ranges::find(kKnown, key) == std::end(kKnown))
        at.fail("does not know " + quote(key) + "; expected box, polygon, z, faces, allow, forbid or note");
    if (object.contains("z") && !object.contains("polygon")) at.fail("'z' belongs to a polygon");
  }

  JsonFile json_;
};

// --- CSV

std::vector<double> numbers_in(std::string_view text, const Place& at) {
  std::vector<double> values;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value)) at.fail("expected a finite number, found " + quote(word));
    values.push_back(*value);
  }
  return values;
}

Region faces_in_text(std::string_view text, const Place& at) {
  FaceRegion region;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::size_t dash = word.find('-');
    const auto last = dash == std::string_view::npos ? word : word.substr(dash + 1);
    region.ranges.push_back(
        face_range(integer_from<std::uint32_t>(word.substr(0, dash)), integer_from<std::uint32_t>(last), at));
  }
  if (region.ranges.empty()) at.fail("expected at least one face");
  return region;
}

ListedViewRule rule_in_line(std::string_view line, const Place& at) {
  constexpr const char* kFields = "expected REGION,NUMBERS,allow|forbid,PHOTO;PHOTO...";
  std::array<std::string_view, 3> fields;
  for (std::string_view& field : fields) {
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos) at.fail(kFields);
    field = trimmed(line.substr(0, comma));
    line.remove_prefix(comma + 1);
  }
  ListedViewRule rule;
  rule.place = at.place;
  if (fields[0] == "box")
    rule.region = box_region(numbers_in(fields[1], at), at);
  else if (fields[0] == "polygon")
    rule.region = ground_region(numbers_in(fields[1], at), at);
  else if (fields[0] == "faces")
    rule.region = faces_in_text(fields[1], at);
  else
    at.fail("expected box, polygon or faces, found " + quote(fields[0]));
  if (fields[2] != "allow" && fields[2] != "forbid")
    at.fail("expected allow or forbid as the third field, found " + quote(fields[2]));
  rule.allow = fields[2] == "allow";
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(';'), line.size());
    const std::string_view name = trimmed(line.substr(0, end));
    if (!name.empty()) rule.photos.emplace_back(name);
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  if (rule.photos.empty()) at.fail("expected at least one photo as the fourth field");
  return rule;
}

// --- regions

// The sides of a polygon in bands across y, so that a point is compared with those of its band alone.
class PolygonBands {
 public:
  explicit PolygonBands(const std::vector<std::array<double, 2>>& corners) : corners_(corners) {
    const auto by_y = [](const auto& a, const auto& b) { return a[1] < b[1]; };
    const auto [low, high] = std::minmax_element(corners.begin(), corners.end(), by_y);
    low_ = (*low)[1];
    high_ = (*high)[1];
    // As many as there are corners, unless long sides would be in too many of them.
    const std::size_t most = 8 * corners.size();
    for (bands_ = std::isfinite(high_ - low_) ? corners.size() : 1; bands_ > 1 && entries() > most; bands_ /= 2)
      continue;
    std::vector<std::size_t> end(bands_ + 1, 0);
    for_each_side([&](std::size_t, std::size_t band) { ++end[band + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    first_ = end;
    sides_.resize(first_.back());
    for_each_side([&](std::size_t side, std::size_t band) { sides_[end[band]++] = side; });
  }

  bool contain(double x, double y) const {
    if (!(y >= low_ && y <= high_)) return false;
    bool inside = false;
    const std::size_t band = band_of(y);
    for (std::size_t n = first_[band]; n < first_[band + 1]; ++n) {
      const auto &a = corners_[sides_[n]], &b = before(sides_[n]);
      // Half-open in y, so that a ray through a corner crosses one of its two sides.
      if ((a[1] > y) == (b[1] > y)) continue;
      if (x < a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]))) inside = !inside;
    }
    return inside;
  }

 private:
  const std::array<double, 2>& before(std::size_t corner) const {
    return corners_[corner == 0 ? corners_.size() - 1 : corner - 1];
  }
  // Rises with y, so that a side is in the band of each of its points.
  std::size_t band_of(double y) const {
    if (bands_ == 1) return 0;
    const double share = high_ > low_ ? (y - low_) / (high_ - low_) : 0;
    return std::min(static_cast<std::size_t>(share * static_cast<double>(bands_)), bands_ - 1);
  }
  std::array<std::size_t, 2> bands_of(std::size_t side) const {
    const double a = corners_[side][1], b = before(side)[1];
    return {band_of(std::min(a, b)), band_of(std::max(a, b))};
  }
  std::size_t entries() const {
    std::size_t sum = 0;
    for (std::size_t side = 0; side < corners_.size(); ++side) sum += bands_of(side)[1] - bands_of(side)[0] + 1;
    return sum;
  }
  void for_each_side(const auto& visit) const {
    for (std::size_t side = 0; side < corners_.size(); ++side)
      for (std::size_t band = bands_of(side)[0]; band <= bands_of(side)[1]; ++band) visit(side, band);
  }

  const std::vector<std::array<double, 2>>& corners_;
  double low_ = 0, high_ = 0;
  std::size_t bands_ = 1;
  std::vector<std::size_t> first_;  ///< per band, the place in sides_ at which its sides begin
  std::vector<std::size_t> sides_;  ///< by band; each is named by its second corner
};

bool contains(const BoxRegion& box, const WorldPoint& p) {
  return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y &&
         p.z <= box.high.z;
}

// The x that points of a region may have.
std::array<double, 2> x_range(const BoxRegion& box) { return {box.low.x, box.high.x}; }
std::array<double, 2> x_range(const GroundRegion& ground) {
  const auto [low, high] = std::minmax_element(ground.corners.begin(), ground.corners.end());
  return {(*low)[0], (*high)[0]};
}

}  // namespace

std::vector<ListedViewRule> parse_view_rules(const fs::path& file, std::string_view text) {
  text = without_byte_order_mark(text);
  std::vector<ListedViewRule> rules;
  if (trimmed(text).starts_with('{')) {
    rules = JsonRules(file, text).read();
  } else {
    for (std::size_t number = 1; !text.empty(); ++number) {
      const std::string_view line = trimmed(next_line(text));
      if (line.empty() || line.starts_with('#')) continue;
      rules.push_back(rule_in_line(line, {file, "line " + std::to_string(number)}));
    }
  }
  if (rules.empty()) throw InputError(file, "", "expected at least one rule about photos");
  return rules;
}

std::vector<ListedViewRule> read_view_rules(const fs::path& file) {
  const FileBytes bytes(file);
  return parse_view_rules(file, bytes.view());
}

FaceLocator::FaceLocator(const Mesh& mesh) : middles_(mesh.faces.size()), by_x_(mesh.faces.size()) {
  tbb::parallel_for(std::size_t{0}, middles_.size(), [&](std::size_t f) {
    for (const std::uint32_t v : mesh.faces[f]) {
      const WorldPoint& p = mesh.positions[v];
      middles_[f] = {middles_[f].x + p.x / 3, middles_[f].y + p.y / 3, middles_[f].z + p.z / 3};
    }
  });
  std::iota(by_x_.begin(), by_x_.end(), 0u);
  tbb::parallel_sort(by_x_.begin(), by_x_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return middles_[a].x < middles_[b].x; });
}

std::vector<std::uint32_t> FaceLocator::faces_in(const Region& region) const {
  std::vector<std::uint32_t> faces;
  if (const auto* listed = std::get_if<FaceRegion>(&region)) {
    for (const auto& [first, last] : listed->ranges)
      for (std::size_t f = first; f <= last && f < middles_.size(); ++f) faces.push_back(static_cast<std::uint32_t>(f));
  } else if (const auto* box = std::get_if<BoxRegion>(&region)) {
    faces = faces_where(x_range(*box), [&](const WorldPoint& p) { return contains(*box, p); });
  } else {
    const auto& ground = std::get<GroundRegion>(region);
    const PolygonBands bands(ground.corners);
    faces = faces_where(x_range(ground), [&](const WorldPoint& p) {
      return p.z >= ground.low && p.z <= ground.high && bands.contain(p.x, p.y);
    });
  }
  std::ranges::sort(faces);
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

std::vector<std::uint32_t> FaceLocator::faces_where(std::array<double, 2> x,
                                                    const std::function<bool(const WorldPoint&)>& is_inside) const {
  const auto at = [&](std::uint32_t f) { return middles_[f].x; };
  const auto first = std::ranges::lower_bound(by_x_, x[0], {}, at);
  const auto last = std::ranges::upper_bound(first, by_x_.end(), x[1], {}, at);
  const std::span<const std::uint32_t> near(first, last);
  std::vector<std::uint8_t> inside(near.size(), 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, near.size(), 4096), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) inside[n] = is_inside(middles_[near[n]]) ? 1 : 0;
  });
  std::vector<std::uint32_t> faces;
  for (std::size_t n = 0; n < near.size(); ++n)
    if (inside[n] != 0) faces.push_back(near[n]);
  return faces;
}

std::vector<std::uint8_t> faces_in(const Region& region, const Mesh& mesh) {
  std::vector<std::uint8_t> inside(mesh.faces.size(), 0);
  for (const std::uint32_t f : FaceLocator(mesh).faces_in(region)) inside[f] = 1;
  return inside;
}

}  // namespace gpvc::io
