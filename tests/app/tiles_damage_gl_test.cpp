// Jobs whose files are damaged, replaced, or hold what no unit leaves.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>

#include "app/tiles/tile_work.h"
#include "labeling/costs/view_statistics.h"
#include "tests/app/tiles_job.h"
#include "tests/support/errors.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;

// Writes a part of a job anew, under its key and with hashes that are right: the part's own, and that where the job lists it.
template <typename Write>
void rewrite(const JobFolder& folder, const fs::path& file, const Write& write) {
  const std::string bytes = test::read_file(file);
  io::WorkKey key;
  std::memcpy(&key, bytes.data() + 8, sizeof key);
  std::string body = bytes.substr(24, bytes.size() - 40);
  io::WorkStore(file.parent_path()).keep(file.filename(), key, [&](io::WorkStore::Writer& out) { write(out, body); });
  const bool of_mesh = file.parent_path().filename() == "mesh";
  const fs::path list = of_mesh ? folder.mesh_files() : file.parent_path() / "done.json";
  Done done = read_done(list).value();
  const UnitOutput now = output_of(folder.path(), file);
  *std::ranges::find(done.outputs, now.file, &UnitOutput::file) = now;
  write_done(list, done);
}

// Whatever is in the files, a unit that reads them says so in a sentence, or takes it for a colour, a cost or a place.
TEST_F(TilesJob, ValuesThatNoUnitLeavesAreRefusedThoughTheHashIsRight) {
  const JobFolder made = job(1000);
  const std::string choose = choose_unit(0, kRounds, 0), bake = bake_unit(0, 0);
  const std::array<std::array<std::string, 2>, 9> read_by{{{"mesh/tile-0", "cost-0-0"},
                                                           {"units/see-0-0/views", "judge"},
                                                           {"units/see-0-0/tile-0", "cost-0-0"},
                                                           {"units/judge/photos", "cost-0-0"},
                                                           {"units/cost-0-0/costs", choose},
                                                           {"units/" + choose + "/labels", bake},
                                                           {"units/" + expose_unit(0) + "/relations", kLevelUnit},
                                                           {"units/level/exposure", bake},
                                                           {"units/level/alignment", bake}}};
  std::mt19937 random(3);
  std::size_t refused = 0;
  for (const std::array<std::string, 2>& each : read_by)
    for (int i = 0; i < 4; ++i) {
      test::TemporaryFolder copy;
      fs::copy(made.path(), copy.path(), fs::copy_options::recursive);
      const JobFolder folder(copy.path());
      rewrite(folder, copy.path() / each[0], [&](io::WorkStore::Writer& out, std::string& body) {
        const std::size_t at = i == 0 ? 0 : random() % body.size() / 8 * 8;
        for (std::size_t n = at; n < std::min(at + 64, body.size()); ++n)
          body[n] = static_cast<char>(i % 2 == 0 ? random() : n % 4 == 3 ? 0x7f : 0xff);
        out.write(body.data(), body.size());
      });
      UnitRunner runner(folder, {}, observer_);
      fs::remove(folder.done_file(each[1]));
      refused += test::caught([&] { runner.run(runner.find(each[1])); }) ? 1 : 0;
    }
  EXPECT_GT(refused, 10u);
}

TEST_F(TilesJob, AJobThatNoSceneMakesIsRefusedThoughTheHashIsRight) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  const Job good = folder.read_job();
  const auto is_refused = [&](const auto& change) {
    Job changed = good;
    change(changed);
    rewrite(folder, copy.path() / "mesh" / kSceneFile,
            [&](io::WorkStore::Writer& out, std::string&) { out.add(changed); });
    const std::optional<Error> error = test::caught([&] { folder.read_job(); });
    return error && test::contains(error->what(), "is missing or damaged");
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_refused([](Job&) {}));
  // Cameras.
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.fx = kNan; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.fy = -1; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.width = 0; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.height = 1 << 30; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.distortion.k1 = kNan; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.distortion.motion.turn[2] = kNan; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].camera.distortion.model = static_cast<LensModel>(99); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].pose.rotation[4] = kNan; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.scene.views[1].reduction = 0; }));
  // Options.
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.costs.term = static_cast<labeling::DataTerm>(7); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.atlas.seams = static_cast<atlas::SeamLeveling>(7); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.output.up = static_cast<io::UpAxis>(7); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.atlas.page_size = 0; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.atlas.padding = 1 << 20; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.atlas.margin_px = 1 << 20; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.solver.smoothness = kNan; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.costs.data_weight = -1; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.texture.visibility.method = visibility::ShadowMap{{}, kNan}; }));
  EXPECT_TRUE(is_refused([](Job& j) {
    j.settings.texture.visibility.method = visibility::Gpvc{.sampling = static_cast<visibility::Sampling>(9)};
  }));
  EXPECT_TRUE(is_refused([](Job& j) { j.settings.tiles.faces_per_tile = 0; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.model.up = static_cast<io::UpAxis>(7); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.tiles_model.offset.x = kNan; }));
  // Views, tiles and groups.
  EXPECT_TRUE(is_refused([](Job& j) { j.tie_points.push_back({{}, ViewId{0}, ViewId{1000}}); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].tiles[0].pairs = 1e300; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.views.push_back(j.views.front()); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.groups[0].push_back(ViewId{1000}); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.groups.push_back(j.groups[0]); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].tiles[1].faces += 1; }) ||
              test::caught([&] { load_tile(folder, folder.read_job(), 0, 1); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].tiles[1].pairs = kNan; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].tiles[1].around.push_back(1000); }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].tiles[1].views = {ViewId{1000}}; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].reduction = 1 << 12; }));
  EXPECT_TRUE(is_refused([](Job& j) { j.levels[0].tiles.resize(5); }));
}

TEST_F(TilesJob, MeshesThatNoCutMakesAreRefusedThoughTheHashIsRight) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  const Job whole = folder.read_job();
  for (const int level : {0, 1}) {
    const TileMesh good = load_tile(folder, whole, level, 0);
    const fs::path file = level == 0 ? copy.path() / "mesh" / tile_file(0) : folder.unit(ring_unit(1, 0)) / "tile";
    const auto is_refused = [&](const auto& change) {
      TileMesh changed = good;
      change(changed);
      rewrite(folder, file, [&](io::WorkStore::Writer& out, std::string&) { out.add(changed); });
      return test::caught([&] { load_tile(folder, whole, level, 0); }).has_value();
    };
    EXPECT_FALSE(is_refused([](TileMesh&) {}));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.mesh.positions[3].y = std::numeric_limits<double>::infinity(); }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.mesh.positions[3].z = 1e30; }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.mesh.faces[3][1] = 0x7FFFFFFF; }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.tile[3] = 1000; }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.place[3] += 7; }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.face.back() = std::uint64_t{1} << 63; }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.vertex[0] = m.vertex[1]; }));
    EXPECT_TRUE(is_refused([](TileMesh& m) { m.place.pop_back(); }));
  }
}

TEST_F(TilesJob, WhatNoViewSeesIsRefusedThoughTheHashIsRight) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  const Job whole = folder.read_job();
  const TileMesh tile = load_tile(folder, whole, 0, 0);
  const std::vector<TileSight> good =
      folder.get<std::vector<TileSight>>(see_unit(0, 0), tile_file(0), [](auto&) { return true; });
  ASSERT_FALSE(good.empty());
  const auto is_refused = [&](const auto& change) {
    std::vector<TileSight> changed = good;
    change(changed);
    rewrite(folder, folder.unit(see_unit(0, 0)) / tile_file(0),
            [&](io::WorkStore::Writer& out, std::string&) { out.add(changed); });
    return test::caught([&] { load_sights(folder, whole, 0, 0, tile.mesh); }).has_value();
  };
  EXPECT_FALSE(is_refused([](std::vector<TileSight>&) {}));
  EXPECT_TRUE(is_refused([](std::vector<TileSight>& sights) { sights.push_back(sights.back()); }));
  EXPECT_TRUE(
      is_refused([](std::vector<TileSight>& sights) { sights[0].view = sights[0].coverage.view = ViewId{1000}; }));
  EXPECT_TRUE(is_refused([](std::vector<TileSight>& sights) { sights[0].statistics.resize(19); }));
  EXPECT_TRUE(is_refused([](std::vector<TileSight>& sights) {
    const float quality = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(sights[0].statistics.data() + 4, &quality, sizeof quality);
  }));
  // A few bytes that stand for boxes of the whole frame.
  EXPECT_TRUE(is_refused([&](std::vector<TileSight>& sights) {
    const Camera& camera = whole.scene.views[index(sights[0].view)].camera;
    visibility::CoverageTable table;
    table.words.resize((static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) + 63) / 64);
    for (std::uint32_t f = 0; f < tile.mesh.faces.size(); ++f)
      table.entries.push_back({FaceId{f}, sights[0].view, 0, 0, camera.width, camera.height, 1, 0.5f, 0});
    sights[0].coverage = pipeline::pack(sights[0].view, table);
    EXPECT_LT(sights[0].coverage.bytes.size(), 20 * table.entries.size());
  }));
}

// Pages have the profile of a photo that was read when the job was made.
TEST_F(TilesJob, AFirstPhotoOfAnotherProfileThanThePagesIsRefused) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  Job changed = folder.read_job();
  changed.color_profile = {1, 2, 3};
  rewrite(folder, copy.path() / "mesh" / kSceneFile,
          [&](io::WorkStore::Writer& out, std::string&) { out.add(changed); });
  UnitRunner runner(folder, {}, observer_);
  std::size_t refused = 0;
  for (std::size_t g = 0; g < changed.groups.size(); ++g) {
    fs::remove(folder.done_file(see_unit(0, g)));
    const std::optional<Error> error = test::caught([&] { runner.run(runner.find(see_unit(0, g))); });
    if (!error) continue;
    ++refused;
    EXPECT_TRUE(test::contains(error->what(), "has another colour profile than the job's pages")) << error->what();
  }
  EXPECT_EQ(refused, 1u) << "by the unit that looks at it";
}

// As when a job is made anew while a unit of the former one waits for its lock.
TEST_F(TilesJob, AReplacedJobIsNotWorkedOnAsTheFormerOne) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  UnitRunner runner(folder, {}, observer_);
  JobSettings other = settings(1000);
  other.texture.output.quality = 50;
  make_job(folder, input(), other, "test", observer_);
  for (const Unit& unit : runner.units()) {
    const std::optional<Error> error = test::caught([&] { runner.run(unit); });
    ASSERT_TRUE(error);
    EXPECT_TRUE(test::contains(error->what(), "holds another job than when this run began")) << error->what();
  }
  EXPECT_FALSE(fs::exists(folder.done_file(kFinishUnit)));
}

TEST_F(TilesJob, NamesWhatIsMissingOrDamaged) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  UnitRunner runner(folder, {}, observer_);
  const auto message = [&](const std::string& unit) {
    try {
      runner.run(runner.find(unit));
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  fs::remove(folder.done_file("judge"));
  EXPECT_NE(message("cost-0-1").find("judge"), std::string::npos);
  EXPECT_EQ(message("judge"), "");

  const fs::path costs = folder.unit("cost-0-1") / "costs";
  fs::resize_file(costs, fs::file_size(costs) / 2);
  fs::remove(folder.done_file("choose-0-1-1"));
  EXPECT_NE(message("choose-0-1-1").find("cost-0-1"), std::string::npos) << "its output is cut off";
  EXPECT_EQ(message("cost-0-1"), "") << "an output of another size is made again";
  EXPECT_EQ(message("choose-0-1-1"), "");

  const fs::path tile = folder.path() / "mesh" / "tile-2";
  fs::resize_file(tile, fs::file_size(tile) - 5);
  fs::remove(folder.done_file("bake-0-2"));
  EXPECT_NE(message("bake-0-2").find(tile.string()), std::string::npos);
  EXPECT_FALSE(fs::exists(folder.done_file("bake-0-2")));
}

}  // namespace
}  // namespace gpvc::tiles
