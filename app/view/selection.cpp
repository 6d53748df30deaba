#include "app/view/selection.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/pipeline/rule_regions.h"
#include "io/file_bytes.h"
#include "io/output_file.h"
#include "io/paths.h"
#include "io/vector.h"
#include "io/view_rules.h"

namespace gpvc::view {
namespace {

using evaluate::Json;

// By the even-odd rule.
bool is_inside(std::span<const PhotoPoint> polygon, double x, double y) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const PhotoPoint &a = polygon[i], &b = polygon[j];
    if ((a.y > y) != (b.y > y) && x < (b.x - a.x) * (y - a.y) / (b.y - a.y) + a.x) inside = !inside;
  }
  return inside;
}

}  // namespace

std::vector<std::uint32_t> faces_in(const checks::Input& input, const View& screen,
                                    std::span<const PhotoPoint> polygon) {
  PhotoPoint low = polygon.front(), high = low;
  for (const PhotoPoint& p : polygon) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  Scene scene;
  scene.views.push_back(screen);
  const ViewId only{0};
  const checks::Input seen{scene, input.mesh, std::span(&only, 1), input.mesh_file};
  std::vector<std::uint32_t> faces;
  for (const auto& [first, last] : pipeline::faces_shown(seen, seen.views, low, high).ranges)
    for (std::uint32_t f = first; f <= last; ++f) {
      const auto [a, b, c] = input.mesh.faces[f];
      const auto& at = input.mesh.positions;
      const CameraPoint middle = camera_from_world(screen.pose, (at[a] + at[b] + at[c]) * (1.0 / 3));
      if (!(middle.z > 0)) continue;
      const PixelPoint pixel = pixel_from_camera(screen.camera, middle);
      if (is_inside(polygon, pixel.x, pixel.y)) faces.push_back(f);
    }
  return faces;
}

std::vector<std::uint32_t> chart_around(FaceId face, std::span<const std::int32_t> labels,
                                        const labeling::FaceGraph& graph) {
  const auto start = static_cast<std::uint32_t>(face);
  if (labels[start] < 0) return {start};
  std::vector<std::vector<std::uint32_t>> next(labels.size());
  for (const auto& [a, b] : graph.edges)
    if (labels[a] == labels[start] && labels[b] == labels[start]) {
      next[a].push_back(b);
      next[b].push_back(a);
    }
  std::vector<bool> reached(labels.size(), false);
  std::vector<std::uint32_t> faces{start};
  reached[start] = true;
  for (std::size_t at = 0; at < faces.size(); ++at)
    for (const std::uint32_t other : next[faces[at]])
      if (!reached[other]) {
        reached[other] = true;
        faces.push_back(other);
      }
  std::ranges::sort(faces);
  return faces;
}

Json faces_json(std::span<const std::uint32_t> ascending) {
  Json listed = Json::array();
  for (std::size_t i = 0; i < ascending.size();) {
    std::size_t end = i + 1;
    while (end < ascending.size() && ascending[end] == ascending[end - 1] + 1) ++end;
    listed.push_back(end - i == 1 ? Json(ascending[i]) : Json{ascending[i], ascending[end - 1]});
    i = end;
  }
  return listed;
}

std::vector<std::uint32_t> faces_from(const Json& listed, std::size_t count, const char* place) {
  const auto fail = [&] { throw InputError(place, "", "expected a list of faces and of ranges [FIRST, LAST]"); };
  const auto number = [&](const Json& value) {
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= count) fail();
    return value.get<std::uint32_t>();
  };
  if (!listed.is_array()) fail();
  std::vector<std::uint32_t> faces;
  for (const Json& entry : listed) {
    const bool is_range = entry.is_array() && entry.size() == 2;
    const std::uint32_t first = number(is_range ? entry[0] : entry), last = is_range ? number(entry[1]) : first;
    if (last < first || faces.size() + (last - first) > 4 * count) fail();
    for (std::uint32_t f = first; f <= last; ++f) faces.push_back(f);
  }
  std::ranges::sort(faces);
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

Json RuleFile::read() const {
  const std::lock_guard lock(mutex_);
  const std::filesystem::path& from = io::is_file(file_) || earlier_.empty() ? file_ : earlier_;
  if (!io::is_file(from)) return Json::array();
  const Json json = Json::parse(io::FileBytes(from).view(), nullptr, false);
  if (json.is_object() && json.value("rules", Json(nullptr)) == Json::array()) return Json::array();
  io::read_view_rules(from);  // names the place of what is wrong
  if (!json.is_object() || !json.contains("rules"))
    throw InputError(from, "", "is no JSON with a list \"rules\", which alone can be edited here");
  return json["rules"];
}

void RuleFile::write(const Json& rules) const {
  const std::lock_guard lock(mutex_);
  std::string text = "{\n \"rules\": [";
  for (std::size_t i = 0; i < rules.size(); ++i) text += (i == 0 ? "\n  " : ",\n  ") + rules[i].dump();
  text += "\n ]\n}\n";
  if (!rules.empty()) io::parse_view_rules(file_, text);
  io::write_file(file_, text);
}

}  // namespace gpvc::view
