// What units read of a tile.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/pipeline/coverage_store.h"
#include "app/pipeline/stored.h"
#include "app/tiles/job.h"
#include "app/tiles/job_members.h"
#include "app/tiles/tile_mesh.h"
#include "labeling/labeling.h"

namespace gpvc::tiles {

/// What a view sees of a tile and its border.
struct TileSight {
  ViewId view{};
  std::vector<std::byte> statistics;  ///< see labeling::CandidateCollector::statistics_of()
  pipeline::PackedCoverage coverage;
};
GPVC_MEMBERS(TileSight, view, statistics, coverage)

/// What a view tells of the fit of photos, poses and mesh.
struct ViewTells {
  ViewId view{};
  checks::ViewFit fit;
};
GPVC_MEMBERS(ViewTells, view, fit)

/// Candidates of a tile's faces and its border.
struct TileCosts {
  labeling::CostTable table;
  std::vector<labeling::FaceTag> tags;
  visibility::CoverageTable coverage;
};
GPVC_MEMBERS(TileCosts, table, tags, coverage)

std::string tile_file(std::uint32_t tile);
/// The mesh of a tile with its border.
TileMesh load_tile(const JobFolder& folder, const Job& job, int level, std::uint32_t tile);
/// The tile's own faces; on level 0 with its border.
CoarseTile load_own(const JobFolder& folder, const Job& job, int level, std::uint32_t tile);
/// What photos see of the tile, from all groups that look at it, views ascending. \param mesh of the tile with its border
std::vector<TileSight> load_sights(const JobFolder& folder, const Job& job, int level, std::uint32_t tile,
                                   const Mesh& mesh);
/// \param faces how many the tile has with its border
TileCosts load_costs(const JobFolder& folder, const Job& job, int level, std::uint32_t tile, std::size_t faces);

/// The labels of a tile's own faces that a unit of Stage::choose has left.
std::vector<ViewId> load_labels(const JobFolder& folder, const Job& job, const std::string& unit);

/// Labels of all faces of a tile's mesh: `unit_of_tile(number)` names the unit that has left those of a tile; empty: kNoView.
template <typename UnitOfTile>
std::vector<ViewId> labels_of(const JobFolder& folder, const Job& job, const TileMesh& mesh,
                              std::span<const std::uint32_t> tiles, const UnitOfTile& unit_of_tile) {
  std::vector<ViewId> labels(mesh.face.size(), kNoView);
  for (const std::uint32_t tile : tiles) {
    const std::string unit = unit_of_tile(tile);
    if (unit.empty()) continue;
    const std::vector<ViewId> theirs = load_labels(folder, job, unit);
    for (std::size_t f = 0; f < labels.size(); ++f) {
      if (mesh.tile[f] != tile) continue;
      if (mesh.place[f] >= theirs.size())
        throw InputError(folder.unit(unit), "labels", "are fewer than the faces of the tile", {Cure::make_job});
      labels[f] = theirs[mesh.place[f]];
    }
  }
  return labels;
}

}  // namespace gpvc::tiles
