// What the formats of rules about photos have in common.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/view_rules.h"

namespace gpvc::io {

/// Throws InputError at a place of a file.
struct RulePlace {
  const std::filesystem::path& file;
  std::string place;
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file, place, reason); }
};

inline BoxRegion box_region(const std::vector<double>& v, const RulePlace& at) {
  if (v.size() != 6) at.fail("expected two corners of a box, 6 numbers, found " + std::to_string(v.size()));
  return BoxRegion{{std::min(v[0], v[3]), std::min(v[1], v[4]), std::min(v[2], v[5])},
                   {std::max(v[0], v[3]), std::max(v[1], v[4]), std::max(v[2], v[5])}};
}

inline GroundRegion ground_region(const std::vector<double>& v, const RulePlace& at) {
  if (v.size() < 6 || v.size() % 2 != 0)
    at.fail("expected x and y of at least three corners of a polygon, found " + std::to_string(v.size()) + " numbers");
  GroundRegion region;
  for (std::size_t i = 0; i < v.size(); i += 2) region.corners.push_back({v[i], v[i + 1]});
  return region;
}

inline std::array<std::uint32_t, 2> face_range(std::optional<std::uint32_t> first, std::optional<std::uint32_t> last,
                                               const RulePlace& at) {
  if (!first || !last || *first > *last)
    at.fail("expected faces as whole numbers from 0 on, and ranges from the lower to the higher");
  return {*first, *last};
}

inline PhotoRegion photo_region(std::string photo, const std::vector<double>& v, const RulePlace& at) {
  if (photo.empty() || v.size() != 4) at.fail("expected a photo and two corners of a rectangle in it, 4 numbers");
  return {std::move(photo), {std::min(v[0], v[2]), std::min(v[1], v[3])}, {std::max(v[0], v[2]), std::max(v[1], v[3])}};
}

/// "NAME; NAME".
inline std::vector<std::string> names_in(std::string_view list) {
  std::vector<std::string> names;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(';'), list.size());
    const std::string_view name = trimmed(list.substr(0, end));
    if (!name.empty()) names.emplace_back(name);
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return names;
}

/// Faces and ranges out of a text file, whose name counts from the folder of the rules. Throws InputError.
FaceRegion faces_in_file(std::string_view name, const RulePlace& at);

/// Rules in JSON or GeoJSON. Throws InputError.
std::vector<ListedViewRule> json_view_rules(const std::filesystem::path& file, std::string_view text);

}  // namespace gpvc::io
