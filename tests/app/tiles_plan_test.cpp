// The units of a job, and what they wait for.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

#include "app/tiles/make_job.h"
#include "app/tiles/plan.h"
#include "app/tiles/plan_text.h"

namespace gpvc::tiles {
namespace {

TEST(TilesPlan, ColorsDifferBetweenTilesThatShareAnEdge) {
  std::vector<TileInfo> tiles(5);
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    tiles[a].beside.push_back(b);
    tiles[b].beside.push_back(a);
  };
  for (const auto& [a, b] : std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {1, 2}, {0, 2}, {2, 3}, {3, 4}})
    join(a, b);
  color_tiles(tiles);
  for (std::size_t t = 0; t < tiles.size(); ++t)
    for (const std::uint32_t other : tiles[t].beside) EXPECT_NE(tiles[t].color, tiles[other].color);
  EXPECT_EQ(tiles[3].color, 0) << "the first colour that is free";
}

TEST(TilesPlan, GroupsHoldEachViewOnceAndThoseNearEachOther) {
  Scene scene;
  std::vector<ViewId> views;
  for (std::uint32_t v = 0; v < 10; ++v) {
    View view;
    view.pose.centre = {v < 5 ? 0.0 : 1000.0, double(v), 0};
    scene.views.push_back(view);
    views.push_back(ViewId{v});
  }
  const auto groups = group_views(scene, views, 5);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0], (std::vector<ViewId>{ViewId{0}, ViewId{1}, ViewId{2}, ViewId{3}, ViewId{4}}));
}

TEST(TilesPlan, UnitsWaitForEarlierWaves) {
  Job job;
  job.scene.views.resize(2);
  for (View& view : job.scene.views) view.camera = {100, 100, 100, 100, 50, 50, {}};
  job.groups = {{ViewId{0}}, {ViewId{1}}};
  Level level;
  level.tiles.resize(4);
  for (std::uint32_t t = 0; t < 4; ++t) {
    level.tiles[t].views = {ViewId{0}, ViewId{1}};
    for (std::uint32_t other = 0; other < 4; ++other)
      if (other != t) level.tiles[t].beside.push_back(other);
    level.tiles[t].around = level.tiles[t].beside;
  }
  color_tiles(level.tiles);
  job.levels.push_back(level);
  const std::vector<Unit> units = plan_units(job);
  std::set<std::string> before;
  for (const auto& wave : waves(units)) {
    for (const Unit* unit : wave)
      for (const std::string& name : unit->after) EXPECT_TRUE(before.contains(name)) << unit->name << " after " << name;
    for (const Unit* unit : wave) before.insert(unit->name);
  }
  EXPECT_EQ(before.size(), units.size());
  EXPECT_EQ(units.back().name, kFinishUnit);
  EXPECT_EQ(labels_before(job, 0, 1, 3, 0), "choose-0-1-0");
  EXPECT_EQ(labels_before(job, 0, 1, 0, 3), "");
  EXPECT_EQ(labels_before(job, 0, 2, 0, 3), "choose-0-1-3");
}

// Three photos that are looked at one by one; of four coarser tiles, the first is in one of them and the second in two.
TEST(TilesPlan, CoarserLevelsWaitForWhatTheyRead) {
  Job job;
  job.scene.views.resize(3);
  for (View& view : job.scene.views) view.camera = {100, 100, 100, 100, 50, 50, {}};
  job.groups = {{ViewId{0}}, {ViewId{1}}, {ViewId{2}}};
  job.levels.resize(2);
  job.levels[0].tiles.resize(16);
  job.levels[1].tiles.resize(4);
  job.levels[1].tiles[0].views = {ViewId{0}};
  job.levels[1].tiles[1].views = {ViewId{0}, ViewId{1}};
  std::map<std::string, std::set<std::string>> after;
  for (const Unit& unit : plan_units(job))
    after.emplace(unit.name, std::set<std::string>(unit.after.begin(), unit.after.end()));
  EXPECT_EQ(after.at("see-1-0"), (std::set<std::string>{"ring-1-0", "ring-1-1", "see-0-0"}));
  EXPECT_EQ(after.at("cost-1-0"), (std::set<std::string>{"judge", "ring-1-0", "see-1-0"}));
  EXPECT_EQ(after.at("cost-1-1"), (std::set<std::string>{"judge", "ring-1-1", "see-1-0", "see-1-1"}));
  EXPECT_EQ(after.at("cost-1-2"), (std::set<std::string>{"judge", "ring-1-2"}));
  EXPECT_TRUE(after.contains("see-0-2"));
  EXPECT_FALSE(after.contains("see-1-2")) << "no tile of the level would wait for it";
}

}  // namespace
}  // namespace gpvc::tiles
