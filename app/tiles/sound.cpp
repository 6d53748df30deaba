#include "app/tiles/sound.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <ranges>
#include <variant>
#include <vector>

#include "io/finite.h"
#include "io/lens_terms.h"
#include "io/mesh.h"

namespace gpvc::tiles {
namespace {

using io::is_finite;

bool ascends(const auto& numbers) {
  return std::ranges::adjacent_find(numbers, std::greater_equal<>()) == numbers.end();
}

bool are_positions(std::span<const WorldPoint> points) {
  return std::ranges::all_of(points, [](const WorldPoint& p) {
    return std::abs(p.x) <= io::kMostCoordinate && std::abs(p.y) <= io::kMostCoordinate &&
           std::abs(p.z) <= io::kMostCoordinate;
  });
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
    if (!(entry.visible_share >= 0 && entry.visible_share <= 1)) return false;
    // Empty ones may be anywhere.
    const bool empty = entry.width == 0 || entry.height == 0;
    if (!empty && (entry.x0 < 0 || entry.y0 < 0 || entry.x0 > camera.width - entry.width ||
                   entry.y0 > camera.height - entry.height))
      return false;
    const auto words = (std::uint64_t(entry.width) * std::uint64_t(entry.height) + 63) / 64;
    return entry.first_word <= coverage.words.size() && words <= coverage.words.size() - entry.first_word;
  });
}

bool are_below(const auto& numbers, std::size_t count) {
  return std::ranges::all_of(numbers, [&](auto number) { return static_cast<std::size_t>(number) < count; });
}

template <typename Value, std::size_t kCount>
bool is_named(const Named<Value> (&names)[kCount], Value value) {
  return name_of(names, value) != nullptr;
}

bool is_bias(double epsilon) { return std::isfinite(epsilon) && epsilon > 0; }
bool is_sound(const visibility::Gpvc& method) {
  return is_named(visibility::kSamplingNames, method.sampling) && is_named(visibility::kDrawingNames, method.drawing) &&
         is_named(visibility::kClassifierNames, method.classifier) &&
         !(method.drawing == visibility::Drawing::native && method.classifier == visibility::Classifier::gpu);
}
bool is_sound(const visibility::PaperGpvc& method) {
  return is_named(visibility::kSamplingNames, method.sampling) &&
         is_named(visibility::kProjectionNames, method.projection) &&
         is_named(visibility::kCoverageCorrectionNames, method.correction) &&
         is_named(visibility::kClassifierNames, method.classifier);
}
bool is_sound(const visibility::ShadowMap& method) {
  return is_named(visibility::kProjectionNames, method.projection) && is_bias(method.epsilon);
}
bool is_sound(const visibility::RayTracing& method) {
  return method.sampling <= visibility::RaySampling::dense && is_named(visibility::kDrawingNames, method.drawing) &&
         is_bias(method.epsilon);
}
bool is_sound(const visibility::NoTest& method) { return is_named(visibility::kDrawingNames, method.drawing); }

bool is_sound(const JobSettings& settings, std::size_t views) {
  return pipeline::are_sound(settings) &&
         std::visit([](const auto& method) { return is_sound(method); }, settings.texture.visibility.method) &&
         std::ranges::all_of(settings.texture.view_rules,
                             [&](const pipeline::ViewRule& rule) { return pipeline::is_sound(rule, views); });
}

// Photos have no more pixels (io/images.h).
constexpr std::int64_t kMostPixels = std::int64_t{1} << 30;
constexpr int kMostReduction = 1 << 14;

// A view to texture from. Those that are not may have no photo, and so no size.
bool is_sound(const View& view) {
  const Camera& camera = view.camera;
  return camera.width > 0 && camera.height > 0 && std::int64_t{camera.width} * camera.height <= kMostPixels &&
         camera.fx > 0 && camera.fy > 0 && is_finite(camera) && is_finite(view.pose) &&
         is_named(kLensModelNames, camera.distortion.model) && view.reduction >= 1 && view.reduction <= kMostReduction;
}

bool is_sound(const io::ModelOptions& model) {
  return is_finite(model) && is_named(io::kUpAxisNames, model.up) && model.buffer_limit_bytes > 0;
}

bool is_sound(const TileInfo& tile, std::uint32_t number, std::size_t tiles, std::span<const ViewId> views) {
  constexpr std::size_t kMostFaces = UINT32_MAX;
  constexpr double kMostEstimated = 1e15;  // of what fills disks; what a plan makes of it are whole numbers of 64 bits
  const auto is_estimate = [&](double value) { return value >= 0 && value <= kMostEstimated; };
  const auto is_other = [&](std::uint32_t other) { return other < tiles && other != number; };
  return ascends(tile.views) && std::ranges::includes(views, tile.views) && ascends(tile.around) &&
         std::ranges::all_of(tile.around, is_other) && std::ranges::all_of(tile.beside, is_other) &&
         tile.faces <= kMostFaces && tile.all_faces <= kMostFaces && tile.vertices <= kMostFaces &&
         is_estimate(tile.pairs) && is_estimate(tile.texels) &&
         (tile.faces == 0 || (is_finite(tile.own_box) && is_finite(tile.box)));
}

bool is_sound(const Level& level, const Scene& scene, std::span<const ViewId> views) {
  if (level.reduction < 1 || level.reduction > kMostReduction || !is_finite(level.texel_size) || level.texel_size < 0)
    return false;
  for (const ViewId view : views) {
    const Camera& camera = scene.views[index(view)].camera;
    if (level.reduction > std::min(camera.width, camera.height)) return false;
  }
  for (std::uint32_t t = 0; t < level.tiles.size(); ++t)
    if (!is_sound(level.tiles[t], t, level.tiles.size(), views)) return false;
  return true;
}

bool are_sound(const Job& job) {
  for (std::size_t k = 0; k < job.levels.size(); ++k)
    if (!is_sound(job.levels[k], job.scene, job.views) ||
        (k > 0 && job.levels[k - 1].tiles.size() != 4 * job.levels[k].tiles.size()))
      return false;
  const std::size_t tiles = job.levels.empty() ? 0 : job.levels[0].tiles.size();
  return std::has_single_bit(tiles) && std::countr_zero(tiles) % 2 == 0;
}

// Each of the views to texture from once.
bool are_sound(std::span<const std::vector<ViewId>> groups, std::span<const ViewId> views) {
  std::vector<ViewId> all;
  for (const std::vector<ViewId>& group : groups) {
    if (group.empty() || !ascends(group)) return false;
    all.insert(all.end(), group.begin(), group.end());
  }
  std::ranges::sort(all);
  return std::ranges::equal(all, views);
}

}  // namespace

bool is_sound(const Job& job) {
  const std::size_t views = job.scene.views.size();
  const auto is_view = [&](ViewId view) { return index(view) < views && is_sound(job.scene.views[index(view)]); };
  const auto is_point = [&](const io::TiePoint& point) {
    return is_finite(point) && index(point.a) < views && index(point.b) < views;
  };
  return !job.views.empty() && ascends(job.views) && std::ranges::all_of(job.views, is_view) &&
         is_finite(job.scene.offset) && is_sound(job.settings, views) && is_sound(job.model) &&
         is_sound(job.tiles_model) && std::ranges::all_of(job.tie_points, is_point) && are_sound(job) &&
         are_sound(job.groups, job.views) && job.listed.size() == job.settings.texture.view_rules.size();
}

bool is_sound(const TileMesh& tile, const Job& job, int level, std::uint32_t number) {
  const Mesh& mesh = tile.mesh;
  const std::size_t faces = mesh.faces.size(), vertices = mesh.positions.size(), tiles = job.tiles(level).size();
  if (tile.face.size() != faces || tile.tile.size() != faces || tile.place.size() != faces ||
      tile.vertex.size() != vertices || !(mesh.source_face.empty() || mesh.source_face.size() == faces) ||
      !(mesh.file_positions.empty() || mesh.file_positions.size() == vertices) || !ascends(tile.face) ||
      !ascends(tile.vertex) || !are_positions(mesh.positions) || !are_positions(mesh.file_positions) ||
      !are_below(tile.tile, tiles))
    return false;
  std::size_t own = 0;
  for (std::size_t f = 0; f < faces; ++f) {
    if (!are_below(mesh.faces[f], vertices) || (tile.tile[f] == number && tile.place[f] != own++)) return false;
    if (tile.face[f] != (level > 0 ? face_number(tile.tile[f], tile.place[f]) : tile.face[f] & UINT32_MAX))
      return false;
  }
  const TileInfo& info = job.tiles(level)[number];
  return level > 0 || (own == info.faces && faces == info.all_faces);
}

bool is_sound(std::span<const TileSight> sights, std::span<const ViewId> group, const TileInfo& tile, const Mesh& mesh,
              const Scene& scene) {
  const auto view_of = [](const TileSight& seen) { return seen.view; };
  if (std::ranges::adjacent_find(sights, std::greater_equal<>(), view_of) != sights.end()) return false;
  return std::ranges::all_of(sights, [&](const TileSight& seen) {
    return std::ranges::binary_search(group, seen.view) && std::ranges::binary_search(tile.views, seen.view) &&
           seen.coverage.view == seen.view && labeling::is_sound(seen.statistics, mesh.faces.size()) &&
           pipeline::is_sound(seen.coverage, mesh, scene.views[index(seen.view)]);
  });
}

bool is_sound(const TileCosts& costs, const Scene& scene, std::size_t faces) {
  return costs.tags.size() == faces &&
         std::ranges::all_of(costs.tags, [](labeling::FaceTag tag) { return tag <= labeling::FaceTag::background; }) &&
         is_sound(costs.table, faces, scene.views.size()) && is_sound(costs.coverage, scene, faces);
}

bool is_sound(const labeling::PhotoJudgement& photos, const Scene& scene) {
  return photos.log2_gain.size() <= 3 * scene.views.size() && photos.log2_gain.size() % 3 == 0 &&
         std::ranges::all_of(photos.log2_gain, [](double gain) { return std::abs(gain) <= labeling::kMostLog2Gain; }) &&
         std::ranges::all_of(photos.agreement, [&](const auto& each) {
           return index(each.view) < scene.views.size() && is_finite(each);
         });
}

bool is_sound(std::span<const ViewTells> views, const Scene& scene) {
  return std::ranges::all_of(views, [&](const ViewTells& each) {
    return index(each.view) < scene.views.size() && pipeline::is_sound(each.fit, scene.views[index(each.view)].camera);
  });
}

bool is_sound(const atlas::ColorRatio& ratio, const Scene& scene) {
  if (!are_below(ratio.views, scene.views.size()) || !is_finite(ratio) || !(ratio.weight >= 0)) return false;
  // Farther than any frame reaches, and near enough for sums of fourth powers.
  constexpr double kFarthest = 1e6;  // px
  return std::ranges::all_of(
      ratio.at, [](const auto& at) { return std::abs(at[0]) <= kFarthest && std::abs(at[1]) <= kFarthest; });
}

bool is_sound(std::span<const ViewId> labels, const Scene& scene) {
  return std::ranges::all_of(labels, [&](ViewId view) { return view == kNoView || index(view) < scene.views.size(); });
}

}  // namespace gpvc::tiles
