// The units of a job: what each waits for, and what it takes.
//
//   see-L-G        visibility and statistics of a group of views, against the faces in their frames
//   judge          compares the photos with each other, from some faces of every tile
//   cost-L-T       candidates and costs of a tile and its border
//   choose-L-R-T   views of a tile's faces in round R
//   expose-T       colour ratios across the seams of a tile, and its part of the energy
//   level          exposure of all photos
//   bake-L-T       charts, leveling, pages and models of a tile
//   simplify-L-T   the mesh of a tile from its four children
//   ring-L-T       the same with its border
//   finish         tileset.json, and the figures of the whole
//
// L is a level of detail, 0 being that of the mesh. Photos are judged and their exposure found on level 0.
//
// Labels. The energy of a labeling is a sum over faces and pairs. In round 1 tiles of one colour are solved after those of
// lower colours, whose labels hold in their borders; borders without labels yet are solved with the tile and let go. In
// round 2 each tile is improved from the labels of round 1 while its border holds still. Tiles of one colour share no pair, so
// no unit of round 2 raises the energy of the whole, in whatever order they run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/tiles/job.h"

namespace gpvc::tiles {

enum class Stage { see, judge, cost, choose, expose, level, bake, simplify, ring, finish };
inline constexpr Named<Stage> kStageNames[] = {
    {"see", Stage::see},       {"judge", Stage::judge},  {"cost", Stage::cost}, {"choose", Stage::choose},
    {"expose", Stage::expose}, {"level", Stage::level},  {"bake", Stage::bake}, {"simplify", Stage::simplify},
    {"ring", Stage::ring},     {"finish", Stage::finish}};

inline constexpr int kRounds = 2;

struct Unit {
  std::string name;
  Stage stage{};
  int level = 0;
  std::uint32_t number = 0;              ///< of a tile or a group of views
  int round = 0;                         ///< of choose: from 1
  std::vector<std::string> after{};      ///< units that must be complete before
  int cores = 1;                         ///< that it makes use of
  double memory_bytes = 0, seconds = 0;  ///< predicted, on so many cores
  double disk_bytes = 0;                 ///< that it leaves
  double photo_bytes = 0;                ///< of photo files that it reads
};

std::string see_unit(int level, std::size_t group);
std::string cost_unit(int level, std::size_t tile);
std::string choose_unit(int level, int round, std::size_t tile);
std::string expose_unit(std::size_t tile);
std::string bake_unit(int level, std::size_t tile);
std::string simplify_unit(int level, std::size_t tile);
std::string ring_unit(int level, std::size_t tile);
inline constexpr const char* kJudgeUnit = "judge";
inline constexpr const char* kLevelUnit = "level";
inline constexpr const char* kFinishUnit = "finish";

/// The unit whose labels a tile's neighbour has when choose_unit(level, round, tile) runs; empty: none yet.
std::string labels_before(const Job& job, int level, int round, std::uint32_t tile, std::uint32_t neighbour);

/// All units, each after those that it waits for.
std::vector<Unit> plan_units(const Job& job);

/// Colours for TileInfo::color: as few as a greedy choice in the order of the tiles needs.
void color_tiles(std::span<TileInfo> tiles);

/// Groups of views that stand near each other, of at most `most` views.
std::vector<std::vector<ViewId>> group_views(const Scene& scene, std::span<const ViewId> views, std::size_t most);

}  // namespace gpvc::tiles
