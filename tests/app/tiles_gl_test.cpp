// Jobs: what tiles see, choose and show, beside a run over the whole mesh.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>

#include "app/pipeline/steps.h"
#include "app/tiles/tile_work.h"
#include "app/tileset/tileset.h"
#include "io/reference_system.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "labeling/costs/view_statistics.h"
#include "tests/app/tiles_job.h"
#include "tests/support/errors.h"
#include "visibility/visibility.h"

namespace gpvc::tiles {
namespace {

namespace fs = std::filesystem;

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
    for (const char* file : {"tileset.json", "tiles/0_0.glb", "obj/0/model.obj", "obj/0/metadata.xml"})
      files[mesh][file] = test::read_file(result / file);
    results::OutputFolder tileset(out.path() / "tileset", false, "tileset");
    io::PictureSource photos(scene, city_->pictures);
    const std::string placing =
        tileset::tileset_into({input, whole.texture, photos, observer_}, whole.tiles, tileset).placing;
    EXPECT_TRUE(placing.starts_with("EPSG:25832 says nothing of heights")) << placing;
    results::OutputFolder model(out.path() / "model", false, "texture");
    pipeline::texture_into({input, whole.texture, photos, observer_}, model);
    EXPECT_EQ(test::read_file(model.in_making() / "metadata.xml"), files[mesh]["obj/0/metadata.xml"]);
    for (const char* file : {"tileset.json", "tiles/0_0.glb"})
      files[mesh][std::string("by tileset/") + file] = test::read_file(tileset.in_making() / file);
  }
  for (const auto& [name, bytes] : files[&moved]) {
    EXPECT_FALSE(bytes.empty()) << name;
    const bool same = bytes == files[&city_->mesh][name];
    EXPECT_EQ(same, !name.starts_with("obj/")) << name;
  }
  EXPECT_TRUE(test::contains(files[&city_->mesh]["obj/0/metadata.xml"],
                             "<SRS>EPSG:25832</SRS>\n  <SRSOrigin>691000,5334000,0</SRSOrigin>"));
  EXPECT_TRUE(test::contains(files[&moved]["obj/0/metadata.xml"], "<SRS>EPSG:4326</SRS>\n  <SRSOrigin>0,0,0<"));
}

TEST_F(TilesJob, AMeshOfWhichHardlyAnythingIsSeenIsRefused) {
  Mesh large = city_->mesh;
  for (WorldPoint& p : large.positions) p = 1000.0 * p;
  const test::TemporaryFolder out;
  const JobFolder folder(out.path());
  JobSettings chosen = settings(1000);
  chosen.texture.allow_misfit = true;
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

}  // namespace
}  // namespace gpvc::tiles
