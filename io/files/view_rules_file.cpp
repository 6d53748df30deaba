// Reads rules about photos and parts of a mesh: CSV here, JSON by view_rules_json.cpp.
#include <array>
#include <cmath>
#include <optional>

#include "io/file_bytes.h"
#include "io/files/view_rules_text.h"
#include "io/paths.h"

namespace gpvc::io {
namespace {

std::vector<double> numbers_in(std::string_view text, const RulePlace& at) {
  std::vector<double> values;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value)) at.fail("expected a finite number, found " + quote(word));
    values.push_back(*value);
  }
  return values;
}

void add_faces(std::string_view text, const RulePlace& at, FaceRegion& region) {
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
    const std::size_t dash = word.find('-');
    const auto last = dash == std::string_view::npos ? word : word.substr(dash + 1);
    region.ranges.push_back(
        face_range(integer_from<std::uint32_t>(word.substr(0, dash)), integer_from<std::uint32_t>(last), at));
  }
}

FaceRegion faces_in_text(std::string_view text, const RulePlace& at) {
  if (text.starts_with('@')) return faces_in_file(text.substr(1), at);
  FaceRegion region;
  add_faces(text, at, region);
  if (region.ranges.empty()) at.fail("expected at least one face, or @FILE with faces");
  return region;
}

// "NAME X Y X Y"; the name may have spaces.
PhotoRegion photo_in_text(std::string_view text, const RulePlace& at) {
  text = trimmed(text);
  std::string_view name = text;
  for (int n = 0; n < 4; ++n) {
    const std::size_t space = name.find_last_of(" \t");
    if (space == std::string_view::npos) at.fail("expected a photo and two corners of a rectangle in it, 4 numbers");
    name = trimmed(name.substr(0, space));
  }
  return photo_region(std::string(name), numbers_in(text.substr(name.size()), at), at);
}

ListedViewRule rule_in_line(std::string_view line, const RulePlace& at) {
  constexpr const char* kFields = "expected REGION,NUMBERS,allow|forbid,PHOTO;PHOTO...";
  ListedViewRule rule;
  rule.place = at.place;
  std::array<std::string_view, 3> fields;
  if (std::ranges::count(line, ',') == 1 && line.starts_with("photo,")) {
    const PhotoRegion shown = photo_in_text(line.substr(line.find(',') + 1), at);
    rule.photos = {shown.photo};
    rule.region = shown;
    return rule;
  }
  for (std::string_view& field : fields) {
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos) at.fail(kFields);
    field = trimmed(line.substr(0, comma));
    line.remove_prefix(comma + 1);
  }
  if (fields[0] == "box")
    rule.region = box_region(numbers_in(fields[1], at), at);
  else if (fields[0] == "polygon")
    rule.region = ground_region(numbers_in(fields[1], at), at);
  else if (fields[0] == "faces")
    rule.region = faces_in_text(fields[1], at);
  else if (fields[0] == "photo")
    rule.region = photo_in_text(fields[1], at);
  else
    at.fail("expected box, polygon, faces or photo, found " + quote(fields[0]));
  if (fields[2] != "allow" && fields[2] != "forbid")
    at.fail("expected allow or forbid as the third field, found " + quote(fields[2]));
  rule.allow = fields[2] == "allow";
  rule.photos = names_in(line);
  if (rule.photos.empty()) at.fail("expected at least one photo as the fourth field");
  return rule;
}

}  // namespace

FaceRegion faces_in_file(std::string_view name, const RulePlace& at) {
  const std::filesystem::path file = at.file.parent_path() / name;
  if (!is_file(file)) at.fail("there is no list of faces " + file.string());
  const FileBytes bytes(file);
  std::string_view text = without_byte_order_mark(bytes.view());
  FaceRegion region;
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string line(next_line(text));
    line.resize(std::min(line.find('#'), line.size()));
    std::ranges::replace(line, ',', ' ');
    add_faces(line, {file, "line " + std::to_string(number)}, region);
  }
  if (region.ranges.empty()) throw InputError(file, "", "expected at least one face");
  return region;
}

std::vector<ListedViewRule> parse_view_rules(const std::filesystem::path& file, std::string_view text) {
  text = without_byte_order_mark(text);
  std::vector<ListedViewRule> rules;
  if (trimmed(text).starts_with('{')) {
    rules = json_view_rules(file, text);
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

std::vector<ListedViewRule> read_view_rules(const std::filesystem::path& file) {
  const FileBytes bytes(file);
  return parse_view_rules(file, bytes.view());
}

}  // namespace gpvc::io
