// gpvc tiles, unit and plan, from a scene to a tileset.
#include <sys/file.h>

#include <map>
#include <set>

#include "io/images.h"
#include "io/textured_model.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;
using Json = nlohmann::json;

class TilesCommand : public App {
 protected:
  std::vector<std::string> tiles(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = texture(out_, {"--unit-views", "2"});
    words[0] = "tiles";
    words.insert(words.end(), more.begin(), more.end());
    if (std::ranges::count(words, "--tile-faces") == 0) words.insert(words.end(), {"--tile-faces", "1500"});
    return words;
  }
  Outcome unit(const std::vector<std::string>& words) const {
    std::vector<std::string> all{"unit", out_.string()};
    all.insert(all.end(), words.begin(), words.end());
    return run(all);
  }
  // Black in one corner.
  void write_mask() const {
    for (const auto& entry : fs::recursive_directory_iterator(scene_)) {
      if (entry.path().filename() != "east_001.jpg") continue;
      Image mask = io::read_image(entry.path());
      std::ranges::fill(mask.pixels, std::uint8_t{255});
      std::fill_n(mask.at(0, 0), 3, std::uint8_t{0});
      return io::write_image(entry.path().string() + ".mask.png", mask, io::ImageFormat::png, 0);
    }
    ADD_FAILURE() << "no photo";
  }
  // The result alone, by name.
  std::map<std::string, std::string> result() const { return files_of(out_ / "result"); }
};

TEST_F(TilesCommand, UnitsOneByOneGiveTheSameAsAllInOneProcess) {
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  const Json plan = Json::parse(read_file(out_ / "plan.json"));
  for (const Json& each : plan["units"]) {
    const std::string name = each["name"];
    ASSERT_EQ(unit({name, "--threads", "1"}).exit_code, 0) << name;
    EXPECT_TRUE(fs::exists(out_ / each["outputs"][0].get<std::string>()));
    EXPECT_GT(each["memory_mb"].get<double>(), 50);
  }
  const auto one_by_one = result();
  std::size_t faces = 0;
  for (int t = 0; t < 4; ++t)
    faces += io::read_textured_model(out_ / "result" / "obj" / std::to_string(t) / "model.obj").mesh.faces.size();
  EXPECT_EQ(faces, run_json(out_)["counts"]["faces"].get<std::size_t>()) << "every face is in one tile";

  ASSERT_EQ(run(tiles({"--no-levels", "--force"})).exit_code, 0);
  fs::remove_all(out_ / "units");
  fs::remove_all(out_ / "result");
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  EXPECT_TRUE(result() == one_by_one);

  // A job that is made again from the same input goes on with what is there.
  ASSERT_EQ(run(tiles({"--no-levels", "--force"})).exit_code, 0);
  const Outcome again = unit({"--all"});
  EXPECT_EQ(again.exit_code, 0);
  const std::string all = std::to_string(plan["units"].size());
  EXPECT_TRUE(contains(again.err, all + " of " + all + " units were complete")) << again.err;
}

// gpvc tiles moves a job's files into its folder one after the other, and may be killed between two of them.
TEST_F(TilesCommand, UnitsFinishAJobWhosePublicationWasKilled) {
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  const auto before = files_of(out_);
  kill_publication(out_, {"mesh/tile-1", "plan.json", "run.json"});
  EXPECT_EQ(run({"plan", out_.string()}).exit_code, 0);
  EXPECT_TRUE(files_of(out_) == before);
  kill_publication(out_, {"job.json", "mesh/tile-1", "plan.json", "run.json"});
  EXPECT_EQ(unit({"plan-0"}).exit_code, 2) << "no unit has this name";
  EXPECT_TRUE(files_of(out_) == before);
}

TEST_F(TilesCommand, AFinishedJobCanDropWhatUnitsLeft) {
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  EXPECT_EQ(unit({"finish", "--clean"}).exit_code, 2);
  ASSERT_EQ(unit({"--all", "--clean"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(out_ / "units"));
  const auto before = result();
  EXPECT_FALSE(before.empty());
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  EXPECT_TRUE(result() == before);
}

TEST_F(TilesCommand, AnotherJobInTheSameFolderLeavesNoTileOfTheFormerOne) {
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(out_ / "result" / "tiles" / "0_3.glb"));
  EXPECT_EQ(run(tiles({"--no-levels"})).exit_code, 1) << "a job is there, and no --force";
  ASSERT_EQ(run(tiles({"--no-levels", "--force", "--tile-faces", "100000"})).exit_code, 0);
  EXPECT_FALSE(fs::exists(out_ / "result"));
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(out_ / "result" / "tiles" / "0_0.glb"));
  EXPECT_FALSE(fs::exists(out_ / "result" / "tiles" / "0_3.glb"));
}

TEST_F(TilesCommand, AJobThatDiffersInAnythingStartsAnew) {
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  const auto is_replaced_by = [&](const std::vector<std::string>& words) {
    std::ofstream(out_ / "units" / "left") << "by a unit of the former job";
    EXPECT_EQ(run(words).exit_code, 0);
    return !fs::exists(out_ / "units");
  };
  const auto leave_unit = [&] { fs::create_directories(out_ / "units"); };
  leave_unit();
  EXPECT_FALSE(is_replaced_by(tiles({"--no-levels", "--force"}))) << "the same job";
  EXPECT_TRUE(is_replaced_by(tiles({"--force"}))) << "with levels";
  std::vector<std::string> words = tiles({"--force"});
  *std::next(std::ranges::find(words, "--unit-views")) = "3";
  leave_unit();
  EXPECT_TRUE(is_replaced_by(words)) << "other groups of views";
  write_mask();
  leave_unit();
  EXPECT_TRUE(is_replaced_by(words)) << "a mask more";
  words.push_back("--no-masks");
  leave_unit();
  EXPECT_TRUE(is_replaced_by(words)) << "without masks";
  leave_unit();
  std::ofstream(scene_ / "colmap" / "points3D.txt", std::ios::app) << "999999 1 1 1 9 9 9 0.5 1 1 2 1\n";
  EXPECT_TRUE(is_replaced_by(words)) << "with another tie point";
}

TEST_F(TilesCommand, EveryUnitIsOneThatTheLastWaitsFor) {
  // Most tiles are in no photo's frame.
  ASSERT_EQ(run(tiles({"--tile-faces", "200", "--views", "east_001.jpg", "--allow-misfit"})).exit_code, 0);
  const Json plan = Json::parse(read_file(out_ / "plan.json"));
  std::map<std::string, std::vector<std::string>> after;
  for (const Json& each : plan["units"]) after[each["name"]] = each["after"].get<std::vector<std::string>>();
  std::set<std::string> reached{"finish"};
  for (std::vector<std::string> open{"finish"}; !open.empty();) {
    const std::string name = open.back();
    open.pop_back();
    for (const std::string& before : after.at(name))
      if (reached.insert(before).second) open.push_back(before);
  }
  EXPECT_EQ(reached.size(), plan["units"].size());
}

TEST_F(TilesCommand, RemovesNothingThatNoJobMade) {
  for (const char* name : {"units", "result"}) {
    fs::create_directories(out_ / name);
    std::ofstream(out_ / name / "notes.txt") << "mine";
    expect_one_sentence(run(tiles()), (out_ / name).string(), "is not of a job");
    EXPECT_EQ(read_file(out_ / name / "notes.txt"), "mine");
    fs::remove_all(out_ / name);
  }
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  fs::create_directories(out_ / "result");
  fs::rename(scene_ / "mesh.ply", out_ / "result" / "mesh.ply");
  std::vector<std::string> words = tiles({"--force"});
  words[2] = (out_ / "result" / "mesh.ply").string();
  expect_one_sentence(run(words), "mesh.ply", "is read by this run");
  EXPECT_TRUE(fs::exists(out_ / "result" / "mesh.ply"));
}

TEST_F(TilesCommand, TilesOfLargeCoordinatesSayWhatToAdd) {
  const fs::path city = folder_.path() / "utm";
  ASSERT_EQ(run({"synth", "city", "-o", city.string(), "--faces", "1000", "--photos", "5", "--photo-size", "150x100",
                 "--size", "40", "--utm"})
                .exit_code,
            0);
  ASSERT_EQ(run({"tiles", (city / "colmap").string(), (city / "mesh.ply").string(), "-o", out_.string(), "--no-levels"})
                .exit_code,
            0);
  const Outcome units = unit({"--all", "--memory", "10M"});
  expect_one_sentence(units, "--memory", "10 MB");
  EXPECT_TRUE(contains(units.err, "unit see-0-0 may take")) << units.err;
  ASSERT_EQ(unit({"--all"}).exit_code, 0);
  const io::LoadedModel model = io::read_textured_model(out_ / "result" / "obj" / "0" / "model.obj");
  EXPECT_GT(model.offset.x, 1e5);
  EXPECT_LT(model.mesh.positions[0].x, 1e3);
}

TEST_F(TilesCommand, AKilledDriverGoesOn) {
  ASSERT_EQ(run(tiles()).exit_code, 0);
  Program killed({"unit", out_.string(), "--all", "--threads", "1"});
  while (killed.running() && !fs::exists(out_ / "units" / "judge" / "done.json")) usleep(1000);
  killed.send(SIGKILL);
  killed.wait();
  EXPECT_FALSE(fs::exists(out_ / "result" / "tileset.json"));
  // As a kill in the middle of a file leaves it.
  const fs::path unfinished = out_ / "result" / "obj" / "0" / "model.obj.part-1-2";
  fs::create_directories(unfinished.parent_path());
  std::ofstream(unfinished) << "v 1 2";
  const Outcome rest = unit({"--all"});
  EXPECT_FALSE(fs::exists(unfinished));
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_TRUE(contains(rest.err, "units were complete")) << rest.err;
  EXPECT_TRUE(fs::exists(out_ / "result" / "tileset.json"));
}

TEST_F(TilesCommand, PlanIsATableOrAScript) {
  ASSERT_EQ(run(tiles({"--no-levels"})).exit_code, 0);
  const Outcome table = run({"plan", out_.string()});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_TRUE(contains(table.out, "core hours"));
  EXPECT_FALSE(contains(table.out, "simplify  ") && contains(table.out, "simplify      1"));
  const Outcome script = run({"plan", out_.string(), "--sbatch"});
  EXPECT_TRUE(script.out.starts_with("#!/bin/bash")) << script.out;
  EXPECT_TRUE(contains(script.out, " finish\n"));
}

TEST_F(TilesCommand, RefusesWhatDoesNotFitTogether) {
  expect_one_sentence(run({"unit", scene_.string(), "--all"}), scene_.string(), "is no job");
  ASSERT_EQ(run(tiles()).exit_code, 0);
  EXPECT_EQ(unit({"see-0-99"}).exit_code, 2);
  EXPECT_EQ(unit({}).exit_code, 2) << "neither names nor --all";
  expect_one_sentence(unit({"judge"}), "unit judge", "see-0-0");
  fs::create_directories(out_ / "units");
  std::ofstream(out_ / "units" / "see-0-0") << "a file in the way";
  const Outcome in_the_way = unit({"see-0-0"});
  expect_one_sentence(in_the_way, (out_ / "units" / "see-0-0").string(), "ot a directory");
  EXPECT_FALSE(contains(in_the_way.err, "filesystem error")) << in_the_way.err;
  fs::remove(out_ / "units" / "see-0-0");

  const int lock = open((out_ / ".gpvc-lock").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(flock(lock, LOCK_EX), 0);
  expect_one_sentence(unit({"--all"}), out_.string(), "another run");
  close(lock);

  const Json job = Json::parse(read_file(out_ / "job.json"));
  replace_in(out_ / "job.json", job["program"], "0.0.0 (other)");
  expect_one_sentence(unit({"--all"}), "job.json", "was made by gpvc 0.0.0 (other)");
}

TEST_F(TilesCommand, NamesAreTextsOfAnyBytes) {
  ASSERT_EQ(run(tiles({"--copyright",
                       "\xe9"
                       "cole"}))
                .exit_code,
            0);
  const Outcome plan = run({"plan", out_.string()});
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
}

TEST_F(TilesCommand, TextureInTilesLeavesNoWorkWhereNoneIsToBeKept) {
  Program interrupted(texture(out_, {"--memory", "230M", "--no-resume"}));
  const auto has_begun = [&] {
    if (!fs::exists(out_)) return false;
    for (const auto& entry : fs::directory_iterator(out_))
      if (fs::exists(entry.path() / "new" / ".job" / "units")) return true;
    return false;
  };
  while (interrupted.running() && !has_begun()) usleep(1000);
  EXPECT_FALSE(fs::exists(out_ / ".work"));
  interrupted.send(SIGINT);
  EXPECT_EQ(interrupted.wait().exit_code, 130);
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(TilesCommand, TextureInTilesRefusesAFileInTheWayAtOnce) {
  fs::create_directories(out_);
  std::ofstream(out_ / "index.html") << "mine";
  expect_one_sentence(run(texture(out_, {"--memory", "230M"})), "index.html", "would be replaced");
  EXPECT_FALSE(fs::exists(out_ / ".work")) << "before any unit ran";
  EXPECT_EQ(read_file(out_ / "index.html"), "mine");
}

TEST_F(TilesCommand, TextureGoesOnInTilesWhereMemoryIsShort) {
  // Less than what the preview takes, which tiles have none of.
  const Outcome outcome = run(texture(out_, {"--memory", "230M"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "It goes on in tiles")) << outcome.err;
  const Json tileset = Json::parse(read_file(out_ / "tileset.json"));
  EXPECT_TRUE(fs::exists(out_ / tileset["root"]["content"]["uri"].get<std::string>()));
  EXPECT_FALSE(fs::exists(out_ / ".work")) << "the job is gone once its result is there";
  const Json run = run_json(out_);
  EXPECT_GT(run["counts"]["expose"]["energy"].get<double>(), 0);
  for (const Json& file : run["outputs"]) EXPECT_TRUE(fs::exists(out_ / file.get<std::string>())) << file;

  fs::remove_all(out_);
  expect_one_sentence(test::run(texture(out_, {"--memory", "20M"})), "even in tiles", "--downscale");
  EXPECT_FALSE(fs::exists(out_));
  // Rules about photos have.
  std::ofstream(folder_.path() / "rules.csv") << "box,-100 -100 -100 0 100 100,forbid,east_001.jpg\n";
  const Outcome ruled =
      test::run(texture(out_, {"--memory", "230M", "--allow", (folder_.path() / "rules.csv").string()}));
  EXPECT_EQ(ruled.exit_code, 0) << ruled.err;
  EXPECT_TRUE(contains(ruled.err, "rules about photos apply to")) << ruled.err;
  EXPECT_TRUE(fs::exists(out_ / "tileset.json"));
  // What has no meaning in tiles.
  fs::remove_all(out_);
  expect_one_sentence(test::run(texture(out_, {"--memory", "230M", "--editable"})), "--memory", "230 MB");
}

}  // namespace
}  // namespace gpvc
