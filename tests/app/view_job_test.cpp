// Runs in the background of gpvc view, and the rules and faces that its page sends.
#include "app/view/job.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "app/view/paths.h"
#include "app/view/pictures.h"
#include "app/view/selection.h"
#include "app/view/tileset_files.h"
#include "io/error.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::view {
namespace {

using evaluate::Json;
using test::TemporaryFolder;

// What a job has reported so far.
struct Reports {
  std::mutex mutex;
  std::vector<Json> lines;
  Tell tell() {
    return [this](const std::string& line) {
      const std::lock_guard lock(mutex);
      lines.push_back(Json::parse(line));
    };
  }
  Json end() {
    for (int tries = 0; tries < 500; ++tries) {
      {
        const std::lock_guard lock(mutex);
        if (!lines.empty() && lines.back().contains("ended")) return lines.back();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return nullptr;
  }
};

TEST(ViewJob, ReportsStagesAndEnds) {
  Reports reports;
  Job job(reports.tell());
  EXPECT_TRUE(job.start([](results::Observer& observer) {
    observer.begin({"bake", "photos"});
    observer.progress(2, 7);
    observer.warning("b\x01 is odd");
    observer.end("");
  }));
  EXPECT_EQ(reports.end(), (Json{{"ended", "done"}}));
  ASSERT_EQ(reports.lines.size(), 4u);
  EXPECT_EQ(reports.lines[1], (Json{{"stage", "bake"}, {"done", 2}, {"total", 7}, {"unit", "photos"}}));
  EXPECT_EQ(reports.lines[2]["warning"], "b\\x01 is odd");
}

TEST(ViewJob, OneRunsAtATimeAndIsCancelled) {
  Reports reports;
  Job job(reports.tell());
  EXPECT_TRUE(job.start([](results::Observer& observer) {
    for (;;) {
      observer.check_cancelled();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }));
  EXPECT_FALSE(job.start([](results::Observer&) {}));
  job.cancel();
  EXPECT_EQ(reports.end()["ended"], "cancelled");
  reports.lines.clear();
  EXPECT_TRUE(job.start([](results::Observer&) { throw Error("nothing goes"); }));
  EXPECT_EQ(reports.end()["why"], "nothing goes");
}

TEST(ViewSelection, FacesAreListedAsRulesListThem) {
  const std::vector<std::uint32_t> faces{1, 3, 4, 5, 9};
  EXPECT_EQ(faces_json(faces), Json::parse("[1, [3, 5], 9]"));
  EXPECT_EQ(faces_from(faces_json(faces), 10, "question"), faces);
  EXPECT_EQ(faces_from(Json::parse("[9, [3, 5], 1, 4]"), 10, "question"), faces);
  for (const char* wrong : {"{}", "[10]", "[-1]", "[1.5]", "[[5, 3]]", "[[0, 4000000000]]", "[\"1\"]", "[[1, 2, 3]]"})
    EXPECT_THROW(faces_from(Json::parse(wrong), 10, "question"), InputError) << wrong;
}

TEST(ViewSelection, AChartEndsWhereThePhotoChanges) {
  // A row of faces: 0-1-2-3-4, and 5 beside 2 alone.
  labeling::FaceGraph graph;
  graph.edges = {{0, 1}, {1, 2}, {2, 3}, {2, 5}, {3, 4}};
  const std::vector<std::int32_t> labels{7, 7, 7, 8, 7, 7};
  EXPECT_EQ(chart_around(FaceId{1}, labels, graph), (std::vector<std::uint32_t>{0, 1, 2, 5}));
  EXPECT_EQ(chart_around(FaceId{4}, labels, graph), (std::vector<std::uint32_t>{4}));
  EXPECT_EQ(chart_around(FaceId{0}, std::vector<std::int32_t>(6, -1), graph), (std::vector<std::uint32_t>{0}))
      << "no photo";
}

TEST(ViewSelection, RulesBeginWithThoseOfTheResult) {
  const TemporaryFolder folder;
  const auto own = folder.path() / "rules.json", earlier = folder.path() / "allow.json",
             table = folder.path() / "allow.csv";
  std::ofstream(earlier) << R"({"rules": [{"faces": [1], "forbid": "a.jpg"}]})";
  const RuleFile rules(own, earlier);
  ASSERT_EQ(rules.read().size(), 1u);
  Json more = rules.read();
  more.push_back({{"faces", {2}}, {"allow", "b.jpg"}});
  rules.write(more);
  EXPECT_EQ(RuleFile(own, earlier).read(), more);
  EXPECT_THROW(rules.write(Json::parse(R"([{"faces": [1]}])")), InputError);
  EXPECT_EQ(rules.read(), more) << "what is refused changes nothing";
  rules.write(Json::array());
  EXPECT_EQ(rules.read(), Json::array()) << "not those of the earlier file again";
  std::ofstream(table) << "faces,7,forbid,a.jpg\n";
  EXPECT_THROW(RuleFile(folder.path() / "none.json", table).read(), InputError) << "a table cannot be edited here";
}

TEST(ViewTileset, OnlyFilesOfTheTilesetCount) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "a.glb") << "a";
  std::ofstream(folder.path() / "secret.glb") << "not named";
  std::ofstream(folder.path() / "tileset.json") << R"({"root": {"content": {"uri": "a.glb"}, "children": [
    {"content": {"uri": "../outside.glb"}}, {"content": {"uri": "/etc/x.glb"}}, {"content": {"uri": "missing.glb"}}]}})";
  EXPECT_EQ(tileset_files(folder.path()), (std::set<std::string>{"a.glb", "tileset.json"}));
  std::ofstream(folder.path() / "tileset.json") << R"({"root": {"content": {"uri": "tile.b3dm"}}})";
  EXPECT_THROW(tileset_files(folder.path()), InputError);
  std::ofstream(folder.path() / "tileset.json") << "[]";
  EXPECT_THROW(tileset_files(folder.path()), InputError);
}

TEST(ViewPictures, ScratchOfKilledProcessesGoes) {
  const auto temporary = std::filesystem::temp_directory_path();
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  const auto abandoned = temporary / ("gpvc-view-" + std::to_string(child) + "-abcdef"),
             alive = temporary / ("gpvc-view-" + std::to_string(getpid()) + "-abcdef");
  for (const auto& folder : {abandoned, alive}) std::filesystem::create_directories(folder);
  std::filesystem::path own;
  {
    const ScratchFolder scratch;
    own = scratch.path();
    EXPECT_TRUE(std::filesystem::is_directory(own));
  }
  EXPECT_FALSE(std::filesystem::exists(own));
  EXPECT_FALSE(std::filesystem::exists(abandoned));
  EXPECT_TRUE(std::filesystem::remove(alive)) << "another one may still be in use";
}

TEST(ViewPaths, NumbersAreWholeAndBelowTheCount) {
  EXPECT_EQ(number_behind("pages/12", "pages/", 13), 12u);
  for (const char* path :
       {"pages/13", "pages/", "pages/-1", "pages/1x", "pages/1/2", "page/1", "pages/99999999999999999999"})
    EXPECT_FALSE(number_behind(path, "pages/", 13)) << path;
}

}  // namespace
}  // namespace gpvc::view
