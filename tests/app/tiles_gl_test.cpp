// Jobs: what tiles see, choose and show, beside a run over the whole mesh.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "app/pipeline/steps.h"
#include "app/tiles/done.h"
#include "app/tiles/make_job.h"
#include "app/tiles/plan_text.h"
#include "app/tiles/tile_work.h"
#include "app/tiles/units.h"
#include "app/tileset/tileset.h"
#include "io/reference_system.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "labeling/costs/view_statistics.h"
#include "tests/app/photographed_city.h"
#include "tests/support/errors.h"
#include "visibility/visibility.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;
using test::City;

class TilesJob : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    city_ = new City(4000, 240, 6);
    jobs_ = new std::map<std::size_t, std::unique_ptr<test::TemporaryFolder>>();
  }
  static void TearDownTestSuite() {
    delete jobs_;
    delete city_;
  }
  checks::Input input() const { return {city_->scene, city_->mesh, city_->views}; }
  static JobSettings settings(std::size_t faces_per_tile) {
    JobSettings settings;
    settings.tiles.faces_per_tile = faces_per_tile;
    settings.views_per_unit = 2;
    settings.texture.output.texture = io::ImageFormat::png;
    return settings;
  }
  // A job that is done, made once.
  JobFolder job(std::size_t faces_per_tile) {
    std::unique_ptr<test::TemporaryFolder>& folder = (*jobs_)[faces_per_tile];
    if (folder) return JobFolder(folder->path());
    folder = std::make_unique<test::TemporaryFolder>();
    const JobFolder made(folder->path());
    make_job(made, input(), settings(faces_per_tile), "test", observer_);
    UnitRunner runner(made, {}, observer_);
    for (const Unit& unit : runner.units()) EXPECT_EQ(runner.run(unit), UnitResult::done) << unit.name;
    return made;
  }
  static double figure(const JobFolder& folder, const char* name) {
    return read_done(folder.done_file(kFinishUnit)).value().figures[name].get<double>();
  }

  static City* city_;
  static std::map<std::size_t, std::unique_ptr<test::TemporaryFolder>>* jobs_;
  results::Observer observer_;
};
City* TilesJob::city_ = nullptr;
std::map<std::size_t, std::unique_ptr<test::TemporaryFolder>>* TilesJob::jobs_ = nullptr;

using Records = std::map<std::pair<ViewId, std::uint64_t>, labeling::FaceRecord>;

void add(Records& all, ViewId view, std::span<const std::byte> bytes, const auto& number_of) {
  labeling::FaceRecord record;
  for (std::size_t at = 0; at < bytes.size(); at += sizeof record) {
    std::memcpy(&record, bytes.data() + at, sizeof record);
    const std::uint64_t number = number_of(record.face);
    record.face = 0;
    const auto [place, added] = all.try_emplace({view, number}, record);
    EXPECT_TRUE(added || std::memcmp(&place->second, &record, sizeof record) == 0) << "tiles differ about " << number;
  }
}

TEST_F(TilesJob, ViewsSeeTilesAsTheySeeTheWholeMesh) {
  visibility::VisibilityStage stage(city_->mesh, {});
  labeling::CandidateCollector whole(city_->mesh, {});
  Records expected;
  for (const ViewId id : city_->views) {
    const View& view = city_->scene.views[index(id)];
    whole.add_view(id, view, city_->pictures[index(id)].image, stage.classify(view, id, nullptr));
    add(expected, id, whole.statistics_of(id), [](std::uint32_t face) { return face; });
  }
  for (const std::size_t faces : {std::size_t{100000}, std::size_t{1000}, std::size_t{300}}) {
    const JobFolder folder = job(faces);
    const Job made = folder.read_job();
    Records found;
    for (std::uint32_t t = 0; t < made.tiles(0).size(); ++t) {
      const TileMesh tile = load_tile(folder, made, 0, t);
      for (const TileSight& seen : load_sights(folder, made, 0, t, tile.mesh))
        add(found, seen.view, seen.statistics, [&](std::uint32_t face) { return tile.face[face]; });
    }
    ASSERT_EQ(found.size(), expected.size()) << faces << " faces a tile";
    for (auto a = found.begin(), b = expected.begin(); a != found.end(); ++a, ++b) {
      ASSERT_EQ(a->first, b->first);
      ASSERT_EQ(std::memcmp(&a->second, &b->second, sizeof a->second), 0) << a->first.second;
    }
  }
}

TEST_F(TilesJob, EnergyIsThatOfTheUndividedRun) {
  io::PictureSource photos(city_->scene, city_->pictures);
  const pipeline::Settings s = settings(1).texture;
  const pipeline::Choice whole =
      pipeline::see_and_choose({input(), s, photos, observer_}, pipeline::plan_memory(input(), s));
  // The same faces are compared for photos' gains here, so that the costs are equal up to the averaging of outliers.
  EXPECT_NEAR(figure(job(100000), "expose.energy"), whole.selection.energy, 1e-6 * whole.selection.energy);
  for (const std::size_t faces : {std::size_t{1000}, std::size_t{300}})
    EXPECT_NEAR(figure(job(faces), "expose.energy"), whole.selection.energy, 0.005 * whole.selection.energy);
}

TEST_F(TilesJob, SeamsRunAlongBordersOfTilesNoMoreThanInside) {
  const JobFolder folder = job(300);
  const double inside = (figure(folder, "expose.seams") - figure(folder, "expose.seams_across")) /
                        (figure(folder, "expose.pairs") - figure(folder, "expose.pairs_across"));
  // As a share of the pairs; one tile's border has few, whose share scatters by a third.
  EXPECT_GT(figure(folder, "expose.pairs_across"), 300);
  EXPECT_LT(figure(folder, "expose.seams_across") / figure(folder, "expose.pairs_across"), 1.3 * inside);
}

using Place = std::array<double, 3>;

// Edges of a model, by the positions of their ends, with the colours that each face shows along them.
using EdgeColors = std::map<std::pair<Place, Place>, std::vector<std::array<double, 3>>>;

std::array<double, 3> color_at(const Image& page, double u, double v) {
  const int x = std::clamp(static_cast<int>(u * page.width), 0, page.width - 1);
  const int y = std::clamp(static_cast<int>(v * page.height), 0, page.height - 1);
  const std::uint8_t* at = page.at(x, y);
  return {double(at[0]), double(at[1]), double(at[2])};
}

void add_edges(const io::LoadedModel& loaded, EdgeColors& all) {
  const io::TexturedModel& model = loaded.model;
  for (std::size_t f = 0; f < loaded.mesh.faces.size(); ++f) {
    if (model.face_page[f] == io::kNoPage) continue;
    for (std::size_t e = 0; e < 3; ++e) {
      std::array<Place, 2> ends{};
      std::array<io::TexCoord, 2> at{};
      for (std::size_t k = 0; k < 2; ++k) {
        const std::size_t corner = (e + k) % 3;
        const WorldPoint& p = loaded.mesh.positions[loaded.mesh.faces[f][corner]];
        ends[k] = {p.x, p.y, p.z};
        at[k] = model.texcoords[model.face_texcoords[f][corner]];
      }
      const auto middle = [&](float a, float b) { return 0.5 * (double{a} + double{b}); };
      all[std::minmax(ends[0], ends[1])].push_back(
          color_at(loaded.pages[model.face_page[f]], middle(at[0].u, at[1].u), middle(at[0].v, at[1].v)));
    }
  }
}

double mean_step(const EdgeColors& edges) {
  double sum = 0, count = 0;
  for (const auto& [ends, colors] : edges) {
    if (colors.size() != 2) continue;
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(colors[0][c] - colors[1][c]) / 3;
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

TEST_F(TilesJob, ColorsStepNoMoreAcrossBordersOfTilesThanAcrossSeamsInside) {
  const JobFolder folder = job(1000);
  std::vector<EdgeColors> of_tiles;
  for (int t = 0; t < 4; ++t) {
    EdgeColors edges;
    add_edges(io::read_textured_model(folder.path() / fmt::format("result/obj/{}/model.obj", t)), edges);
    of_tiles.push_back(std::move(edges));
  }
  EdgeColors border, inside;
  for (std::size_t t = 0; t < of_tiles.size(); ++t)
    for (const auto& [ends, colors] : of_tiles[t]) {
      if (colors.size() == 2) inside.emplace(ends, colors);
      for (std::size_t other = t + 1; other < of_tiles.size() && colors.size() == 1; ++other)
        if (const auto theirs = of_tiles[other].find(ends);
            theirs != of_tiles[other].end() && theirs->second.size() == 1)
          border[ends] = {colors[0], theirs->second[0]};
    }
  EXPECT_GT(border.size(), 60u) << "tiles meet in vertices that are the same to the last bit";
  // Most edges inside are within a chart, where both sides are the same texels: seams of charts alone are compared.
  std::erase_if(inside, [](const auto& edge) { return edge.second[0] == edge.second[1]; });
  EXPECT_LT(mean_step(border), mean_step(inside));
}

TEST_F(TilesJob, LevelsOfDetailMeetTheTilesBesideThemInTheSameVertices) {
  const JobFolder folder = job(300);
  const Job made = folder.read_job();
  ASSERT_EQ(made.levels.size(), 3u);
  for (int level = 1; level < 3; ++level)
    for (std::uint32_t t = 0; t < made.tiles(level).size(); ++t) {
      const CoarseTile tile = load_own(folder, made, level, t);
      EXPECT_TRUE(fs::exists(folder.path() / fmt::format("result/tiles/{}_{}.glb", level, t)));
      const TileMesh bordered = load_tile(folder, made, level, t);
      EXPECT_EQ(bordered.own(t).size(), tile.tile.face.size());
      // Whatever is on the border of a tile was a vertex of the mesh.
      for (std::size_t v = 0; v < tile.tile.vertex.size(); ++v)
        EXPECT_EQ(tile.tile.mesh.positions[v], city_->mesh.positions[tile.tile.vertex[v]]);
    }
}

TEST_F(TilesJob, CompleteUnitsAreNotRunAgainUntilTheirInputChanges) {
  test::TemporaryFolder copy;
  fs::copy(job(1000).path(), copy.path(), fs::copy_options::recursive);
  const JobFolder folder(copy.path());
  UnitRunner runner(folder, {}, observer_);
  for (const Unit& unit : runner.units()) EXPECT_EQ(runner.run(unit), UnitResult::was_done) << unit.name;
  // A photo that is touched alone is the same.
  const fs::path photo = city_->scene.views[0].photo;
  fs::last_write_time(photo, fs::last_write_time(photo) + std::chrono::seconds(1));
  for (const Unit& unit : runner.units()) EXPECT_EQ(runner.run(unit), UnitResult::was_done) << unit.name;
  const std::string written = test::read_file(photo);
  std::ofstream(photo, std::ios::binary | std::ios::app) << "more";
  const Job made = folder.read_job();
  std::size_t again = 0;
  for (const Unit& unit : runner.units())
    if (runner.run(unit) == UnitResult::done) {
      ++again;
      const bool shows_it = unit.stage == Stage::see && std::ranges::count(made.groups[unit.number], ViewId{0}) == 1;
      EXPECT_TRUE(shows_it || unit.stage != Stage::see) << unit.name;
    }
  EXPECT_GT(again, 1u);
  std::ofstream(photo, std::ios::binary) << written;
}

// Files keep the coordinates of such a mesh; on the globe a tile in degrees would be nowhere, and one whose heights are
// above another ellipsoid 45 m too high or too low.
TEST_F(TilesJob, TilesOfAMeshFromAnotherSystemLieInTheScenes) {
  Scene scene = city_->scene;
  scene.srs = "EPSG:25832";
  scene.offset = {691000, 5334000, 0};
  Mesh moved = city_->mesh;
  for (const WorldPoint& p : moved.positions) moved.file_positions.push_back(p + scene.offset);
  moved.file_srs = "EPSG:4326";
  io::transform_points(scene.srs, moved.file_srs, moved.file_positions);
  std::map<const Mesh*, std::map<std::string, std::string>> files;
  for (const Mesh* mesh : std::initializer_list<const Mesh*>{&city_->mesh, &moved}) {
    const checks::Input input{scene, *mesh, city_->views};
    const test::TemporaryFolder out;
    const JobFolder folder(out.path() / "job");
    JobSettings whole = settings(100000);
    make_job(folder, input, whole, "test", observer_);
    UnitRunner runner(folder, {}, observer_);
    for (const Unit& unit : runner.units()) runner.run(unit);
    const fs::path result = folder.path() / "result";
    for (const char* file : {"tileset.json", "tiles/0_0.glb", "obj/0/model.obj"})
      files[mesh][file] = test::read_file(result / file);
    results::OutputFolder tileset(out.path() / "tileset", false, "tileset");
    io::PictureSource photos(scene, city_->pictures);
    EXPECT_TRUE(
        tileset::tileset_into({input, whole.texture, photos, observer_}, whole.tiles, tileset).obstacle.empty());
    for (const char* file : {"tileset.json", "tiles/0_0.glb"})
      files[mesh][std::string("by tileset/") + file] = test::read_file(tileset.in_making() / file);
  }
  for (const auto& [name, bytes] : files[&moved]) {
    EXPECT_FALSE(bytes.empty()) << name;
    const bool same = bytes == files[&city_->mesh][name];
    EXPECT_EQ(same, name != "obj/0/model.obj") << name;
  }
}

TEST_F(TilesJob, AMeshOfWhichHardlyAnythingIsSeenIsRefused) {
  Mesh large = city_->mesh;
  for (WorldPoint& p : large.positions) p = 1000.0 * p;
  const test::TemporaryFolder out;
  const JobFolder folder(out.path());
  JobSettings chosen = settings(1000);
  chosen.texture.costs.keep_views = true;
  make_job(folder, {city_->scene, large, city_->views}, chosen, "test", observer_);
  const auto judge = [&] {
    UnitRunner runner(folder, {}, observer_);
    for (const Unit& unit : runner.units())
      if (unit.level == 0 && (unit.stage == Stage::see || unit.stage == Stage::judge)) runner.run(unit);
  };
  const std::optional<Error> error = test::caught(judge);
  ASSERT_TRUE(error);
  EXPECT_TRUE(test::contains(error->what(), "photos see less than 5 % of the faces")) << error->what();
  EXPECT_EQ(error->cures(), std::vector{Cure::allow_unseen});
  EXPECT_LT(test::measured(*error, "seen_share"), 0.05);
  chosen.texture.allow_unseen = true;
  make_job(folder, {city_->scene, large, city_->views}, chosen, "test", observer_);
  EXPECT_NO_THROW(judge());
}

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
  const std::array<std::array<std::string, 2>, 8> read_by{{{"mesh/tile-0", "cost-0-0"},
                                                           {"units/see-0-0/views", "judge"},
                                                           {"units/see-0-0/tile-0", "cost-0-0"},
                                                           {"units/judge/photos", "cost-0-0"},
                                                           {"units/cost-0-0/costs", choose},
                                                           {"units/" + choose + "/labels", bake},
                                                           {"units/" + expose_unit(0) + "/ratios", kLevelUnit},
                                                           {"units/level/exposure", bake}}};
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

}  // namespace
}  // namespace gpvc::tiles
