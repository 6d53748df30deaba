// What the atlas of a tile is made from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/tiles/plan.h"
#include "app/tiles/tile_work.h"
#include "atlas/atlas.h"

namespace gpvc::tiles {

/// A tile with its border, its candidates, and the labels of the last round.
struct TileAtlas {
  TileMesh tile;
  labeling::FaceGraph graph;
  TileCosts costs;
  std::vector<ViewId> labels;
  std::vector<std::uint8_t> border;

  TileAtlas(const JobFolder& folder, const Job& job, int level, std::uint32_t number)
      : tile(load_tile(folder, job, level, number)),
        graph(labeling::face_graph(tile.mesh)),
        costs(load_costs(folder, job, level, number, tile.face.size())),
        border(tile.border(number)) {
    std::vector<std::uint32_t> tiles = job.tiles(level)[number].around;
    tiles.push_back(number);
    labels = labels_of(folder, job, tile, tiles, [&](std::uint32_t t) { return choose_unit(level, kRounds, t); });
  }
  atlas::AtlasInput input(const Scene& scene, io::PhotoSource& photos,
                          std::span<const atlas::ViewExposure> exposure = {},
                          std::span<const ShiftField> alignment = {}) const {
    return {tile.mesh,      scene,  photos,   graph,   labels, costs.tags, costs.table,
            costs.coverage, border, exposure, nullptr, {},     alignment};
  }
};

}  // namespace gpvc::tiles
