#include "app/tiles/sound.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace gpvc::tiles {
namespace {

bool ascends(const auto& numbers) {
  return std::ranges::adjacent_find(numbers, std::greater_equal<>()) == numbers.end();
}

bool are_finite(std::span<const WorldPoint> points) {
  return std::ranges::all_of(points, [](const WorldPoint& p) { return std::isfinite(p.x + p.y + p.z); });
}

bool is_sound(const labeling::CostTable& table, std::size_t faces, std::size_t views) {
  if (table.first.size() != faces + 1 || table.first.front() != 0 || table.first.back() != table.views.size() ||
      table.views.size() != table.costs.size() || !std::ranges::is_sorted(table.first))
    return false;
  for (std::size_t f = 0; f < faces; ++f)
    if (!ascends(table.views_of(f))) return false;
  return std::ranges::all_of(table.views, [&](std::uint32_t view) { return view < views; }) &&
         std::ranges::all_of(table.costs, [](float cost) { return std::isfinite(cost) && cost >= 0; });
}

bool is_sound(const visibility::CoverageTable& coverage, const Scene& scene, std::size_t faces) {
  return std::ranges::all_of(coverage.entries, [&](const visibility::FaceCoverage& entry) {
    if (index(entry.face) >= faces || index(entry.view) >= scene.views.size()) return false;
    const Camera& camera = scene.views[index(entry.view)].camera;
    if (entry.width < 0 || entry.height < 0 || entry.width > camera.width || entry.height > camera.height) return false;
    const auto words = (std::uint64_t(entry.width) * std::uint64_t(entry.height) + 63) / 64;
    return entry.first_word <= coverage.words.size() && words <= coverage.words.size() - entry.first_word;
  });
}

bool are_below(const auto& numbers, std::size_t count) {
  return std::ranges::all_of(numbers, [&](auto number) { return static_cast<std::size_t>(number) < count; });
}

bool is_sound(const Level& level, std::size_t views) {
  const std::size_t tiles = level.tiles.size();
  return tiles > 0 && level.reduction >= 1 && level.reduction <= (1 << 16) && std::isfinite(level.texel_size) &&
         std::ranges::all_of(level.tiles, [&](const TileInfo& tile) {
           return are_below(tile.views, views) && ascends(tile.views) && are_below(tile.beside, tiles) &&
                  are_below(tile.around, tiles);
         });
}

}  // namespace

bool is_sound(const Job& job) {
  const std::size_t views = job.scene.views.size();
  for (std::size_t k = 0; k < job.levels.size(); ++k)
    if (!is_sound(job.levels[k], views) || (k > 0 && job.levels[k - 1].tiles.size() != 4 * job.levels[k].tiles.size()))
      return false;
  return !job.levels.empty() && are_below(job.views, views) &&
         job.listed.size() == job.settings.texture.view_rules.size() &&
         std::ranges::all_of(job.groups, [&](const auto& group) { return are_below(group, views) && ascends(group); });
}

bool is_sound(const TileMesh& tile, std::size_t tiles) {
  const Mesh& mesh = tile.mesh;
  const std::size_t faces = mesh.faces.size(), vertices = mesh.positions.size();
  return tile.face.size() == faces && tile.tile.size() == faces && tile.place.size() == faces &&
         tile.vertex.size() == vertices && (mesh.source_face.empty() || mesh.source_face.size() == faces) &&
         (mesh.file_positions.empty() || mesh.file_positions.size() == vertices) && are_finite(mesh.positions) &&
         are_finite(mesh.file_positions) && ascends(tile.face) && ascends(tile.vertex) &&
         std::ranges::all_of(tile.tile, [&](std::uint32_t number) { return number < tiles; }) &&
         std::ranges::all_of(mesh.faces, [&](const Triangle& corners) {
           return std::ranges::all_of(corners, [&](std::uint32_t v) { return v < vertices; });
         });
}

bool is_sound(const TileSight& seen, const Scene& scene, std::size_t faces) {
  if (index(seen.view) >= scene.views.size() || seen.coverage.view != seen.view) return false;
  const Camera& camera = scene.views[index(seen.view)].camera;
  return pipeline::is_sound(seen.coverage, faces, camera.width, camera.height);
}

bool is_sound(const TileCosts& costs, const Scene& scene, std::size_t faces) {
  return costs.tags.size() == faces &&
         std::ranges::all_of(costs.tags, [](labeling::FaceTag tag) { return tag <= labeling::FaceTag::unseen; }) &&
         is_sound(costs.table, faces, scene.views.size()) && is_sound(costs.coverage, scene, faces);
}

bool is_sound(const labeling::PhotoJudgement& photos, const Scene& scene) {
  return photos.log2_gain.size() <= 3 * scene.views.size() &&
         std::ranges::all_of(photos.log2_gain, [](double gain) { return std::isfinite(gain); }) &&
         std::ranges::all_of(photos.agreement, [&](const auto& each) { return index(each.view) < scene.views.size(); });
}

bool is_sound(std::span<const ViewTells> views, const Scene& scene) {
  return std::ranges::all_of(views, [&](const ViewTells& each) {
    return index(each.view) < scene.views.size() && pipeline::is_sound(each.fit);
  });
}

bool is_sound(const atlas::SeamRatio& ratio, const Scene& scene) {
  const auto is_finite = [](double value) { return std::isfinite(value); };
  return are_below(ratio.views, scene.views.size()) && std::ranges::all_of(ratio.logs[0], is_finite) &&
         std::ranges::all_of(ratio.logs[1], is_finite) && std::ranges::all_of(ratio.r2, is_finite) &&
         std::isfinite(ratio.weight) && ratio.weight >= 0;
}

bool is_sound(std::span<const ViewId> labels, const Scene& scene) {
  return std::ranges::all_of(labels, [&](ViewId view) { return view == kNoView || index(view) < scene.views.size(); });
}

}  // namespace gpvc::tiles
