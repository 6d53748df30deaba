#include "app/tiles/tile_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "app/tiles/plan.h"
#include "app/tiles/sound.h"

namespace gpvc::tiles {

std::string tile_file(std::uint32_t tile) { return fmt::format("tile-{}", tile); }

TileMesh load_tile(const JobFolder& folder, const Job& job, int level, std::uint32_t tile) {
  const auto is_right = [&](const TileMesh& mesh) { return is_sound(mesh, job, level, tile); };
  if (level > 0) return folder.get<TileMesh>(ring_unit(level, tile), "tile", is_right);
  TileMesh mesh;
  folder.read_mesh_file(tile_file(tile), [&](io::WorkStore::Reader& in) {
    mesh = in.get<TileMesh>();
    if (!is_right(mesh)) in.refuse();
  });
  return mesh;
}

CoarseTile load_own(const JobFolder& folder, const Job& job, int level, std::uint32_t tile) {
  if (level == 0) return {load_tile(folder, job, 0, tile), 0};
  return folder.get<CoarseTile>(simplify_unit(level, tile), "tile", [&](const CoarseTile& coarse) {
    return is_sound(coarse.tile, job, level, tile) && std::isfinite(coarse.error) && coarse.error >= 0;
  });
}

std::vector<TileSight> load_sights(const JobFolder& folder, const Job& job, int level, std::uint32_t tile,
                                   const Mesh& mesh) {
  const Scene scene = scene_at(job, level);
  const TileInfo& info = job.tiles(level)[tile];
  std::vector<TileSight> all;
  for (std::size_t g = 0; g < job.groups.size(); ++g) {
    const auto frames = [&](ViewId view) { return std::ranges::binary_search(info.views, view); };
    const auto are_right = [&](std::span<const TileSight> sights) {
      return is_sound(sights, job.groups[g], info, mesh, scene);
    };
    if (!std::ranges::any_of(job.groups[g], frames)) continue;
    std::ranges::move(folder.get<std::vector<TileSight>>(see_unit(level, g), tile_file(tile), are_right),
                      std::back_inserter(all));
  }
  std::ranges::sort(all, {}, &TileSight::view);
  return all;
}

TileCosts load_costs(const JobFolder& folder, const Job& job, int level, std::uint32_t tile, std::size_t faces) {
  const Scene scene = scene_at(job, level);
  return folder.get<TileCosts>(cost_unit(level, tile), "costs",
                               [&](const TileCosts& costs) { return is_sound(costs, scene, faces); });
}

std::vector<ViewId> load_labels(const JobFolder& folder, const Job& job, const std::string& unit) {
  return folder.get<std::vector<ViewId>>(unit, "labels",
                                         [&](std::span<const ViewId> labels) { return is_sound(labels, job.scene); });
}

}  // namespace gpvc::tiles
