#include "app/tiles/tile_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "app/tiles/plan.h"

namespace gpvc::tiles {

std::string tile_file(std::uint32_t tile) { return fmt::format("tile-{}", tile); }

TileMesh load_tile(const JobFolder& folder, int level, std::uint32_t tile) {
  if (level > 0) return folder.get<TileMesh>(ring_unit(level, tile), "tile");
  TileMesh mesh;
  folder.read_mesh_file(tile_file(tile), [&](io::WorkStore::Reader& in) { mesh = in.get<TileMesh>(); });
  return mesh;
}

CoarseTile load_own(const JobFolder& folder, int level, std::uint32_t tile) {
  if (level == 0) return {load_tile(folder, 0, tile), 0};
  return folder.get<CoarseTile>(simplify_unit(level, tile), "tile");
}

std::vector<TileSight> load_sights(const JobFolder& folder, const Job& job, int level, std::uint32_t tile) {
  std::vector<TileSight> all;
  for (std::size_t g = 0; g < job.groups.size(); ++g) {
    const auto frames = [&](ViewId view) { return std::ranges::binary_search(job.tiles(level)[tile].views, view); };
    if (!std::ranges::any_of(job.groups[g], frames)) continue;
    std::ranges::move(folder.get<std::vector<TileSight>>(see_unit(level, g), tile_file(tile)), std::back_inserter(all));
  }
  std::ranges::sort(all, {}, &TileSight::view);
  return all;
}

std::vector<ViewId> load_labels(const JobFolder& folder, const std::string& unit) {
  return folder.get<std::vector<ViewId>>(unit, "labels");
}

}  // namespace gpvc::tiles
