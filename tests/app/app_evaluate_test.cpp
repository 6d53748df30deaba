// gpvc evaluate and what gpvc texture leaves for it.
#include <fmt/format.h>

#include <algorithm>

#include "io/images.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "io/vector.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST_F(App, EvaluateWantsATexturedModel) {
  ASSERT_EQ(run(texture(out_, {"--quiet"})).exit_code, 0);
  const std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string()};
  const Outcome scored = run(evaluate);
  EXPECT_EQ(scored.exit_code, 0) << scored.err;
  EXPECT_TRUE(contains(scored.out, "mean"));
  fs::remove(out_ / "model.mtl");
  expect_one_sentence(run(evaluate), "model.obj", "no textured face");
  std::ofstream(out_ / "model.obj", std::ios::trunc).close();
  expect_one_sentence(run(evaluate), "model.obj", "is no mesh that can be read");
}

// Two programs' worth of code for the same figure; masks hide the middle of every photo.
TEST_F(App, CompareScoresAsEvaluateDoesUnderMasks) {
  Image mask;
  mask.width = 240;
  mask.height = 160;
  mask.pixels.assign(std::size_t{240} * 160 * 3, 255);
  for (int y = 40; y < 120; ++y) std::fill_n(mask.at(60, y), 120 * 3, std::uint8_t{0});
  fs::create_directories(scene_ / "masks");
  for (const auto& photo : fs::directory_iterator(scene_ / "images"))
    io::write_image(scene_ / "masks" / (photo.path().filename().string() + ".mask.png"), mask, io::ImageFormat::png, 0);
  const std::vector<std::string> masks{"--masks", (scene_ / "masks").string(), "--hold-out", "2"};
  ASSERT_EQ(run(texture(out_, masks)).exit_code, 0);
  const fs::path scores = folder_.path() / "scores", compared = folder_.path() / "compared";
  ASSERT_EQ(run({"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string(), "--mesh",
                 (scene_ / "mesh.ply").string(), "--masks", masks[1], "--reduction", "1", "-o", scores.string()})
                .exit_code,
            0);
  auto compare = texture(compared, masks);
  compare[0] = "compare";
  compare.insert(compare.end(), {"--modes", "gpvc", "--oracle-views", "0", "--crops", "0", "--reduction", "1",
                                 "--external", "same=" + (out_ / "model.glb").string()});
  const Outcome outcome = run(compare);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json mean = nlohmann::json::parse(read_file(scores / "evaluate.json"))["mean"];
  const nlohmann::json report = nlohmann::json::parse(read_file(compared / "report.json"));
  for (const auto& mode : report["modes"])
    EXPECT_NEAR(mode["score"]["one_minus_ncc"].get<double>(), mean["one_minus_ncc"].get<double>(), 0.01)
        << mode["name"];
  // The record tells what was compared and what it took.
  const nlohmann::json record = nlohmann::json::parse(read_file(compared / "run.json"));
  EXPECT_EQ(record["options"]["modes"], nlohmann::json::array({"gpvc"}));
  EXPECT_EQ(record["options"]["external"].size(), 1u);
  EXPECT_TRUE(std::any_of(record["stages"].begin(), record["stages"].end(), [](const nlohmann::json& stage) {
    return stage.value("mode", "") == "gpvc" && stage["name"] == "choose";
  }));
}

// nerfstudio turns and moves the cameras, lists them as it likes, and says how it moved them; meshes are made before.
class MovedCameras : public App {
 protected:
  void SetUp() override {
    App::SetUp();
    if (IsSkipped()) return;
    ASSERT_EQ(run({"convert", (scene_ / "colmap").string(), "-o", moved_.string(), "--format", "transforms"}).exit_code,
              0);
    nlohmann::json json = nlohmann::json::parse(read_file(moved_ / "transforms.json"));
    json["applied_transform"] = {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 300}};
    for (nlohmann::json& frame : json["frames"]) {
      nlohmann::json& rows = frame["transform_matrix"];
      const nlohmann::json y = rows[1];
      rows[1] = rows[2];
      for (std::size_t c = 0; c < 4; ++c) rows[2][c] = (c == 3 ? 300 : 0) - y[c].get<double>();
      frame["file_path"] = fs::path(frame["file_path"].get<std::string>()).filename().string();
    }
    std::reverse(json["frames"].begin(), json["frames"].end());
    std::ofstream(moved_ / "transforms.json") << json.dump();
  }
  fs::path moved_ = folder_.path() / "moved";
};

TEST_F(MovedCameras, AreWrittenForAMesh) {
  const std::vector<std::string> convert{"convert",  moved_.string(), "--images", (scene_ / "images").string(),
                                         "--format", "colmap",        "-o",       out_.string()};
  const Outcome alone = run(convert);
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_TRUE(contains(alone.err, "the coordinates before applied_transform: --mesh")) << alone.err;
  std::vector<std::string> for_mesh = convert;
  for_mesh.insert(for_mesh.end(), {"--force", "--mesh", (scene_ / "mesh.ply").string()});
  const Outcome placed = run(for_mesh);
  ASSERT_EQ(placed.exit_code, 0) << placed.err;
  EXPECT_FALSE(contains(placed.err, "--mesh")) << placed.err;
  const Scene right = io::read_scene(scene_ / "colmap", {}), written = io::read_scene(out_, {});
  ASSERT_EQ(written.views.size(), right.views.size());
  for (std::size_t v = 0; v < right.views.size(); ++v) {
    EXPECT_EQ(written.views[v].name, right.views[v].name);
    EXPECT_NEAR(length(written.views[v].pose.centre - right.views[v].pose.centre), 0, 1e-9);
  }
}

TEST_F(MovedCameras, StayWhereAMeshFitsThem) {
  const std::vector<std::string> convert{"convert",  moved_.string(), "--images", (scene_ / "images").string(),
                                         "--format", "colmap",        "-o",       out_.string(),
                                         "--mesh"};
  const Mesh mesh = io::read_mesh(scene_ / "mesh.ply");
  for (const double away : {0.0, 1e5}) {
    std::string obj;
    for (const WorldPoint& p : mesh.positions) obj += fmt::format("v {} {} {}\n", p.x + away, p.z, 300 - p.y);
    for (const Triangle& t : mesh.faces) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    std::vector<std::string> words = convert;
    words.push_back(folder_.write("moved.obj", obj).string());
    const Outcome outcome = run(words);
    if (away > 0) {
      expect_one_sentence(outcome, "moved.obj", "no photo sees any face");
      continue;
    }
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_FALSE(contains(outcome.err, "warning")) << outcome.err;
    fs::remove_all(out_);
  }
}

TEST_F(MovedCameras, ShowModelsThatWereTexturedWithoutTheMove) {
  ASSERT_EQ(run(texture(out_)).exit_code, 0);

  std::map<std::string, nlohmann::json> means, origins;
  for (const fs::path& cameras : {scene_ / "colmap", moved_}) {
    const fs::path scores = folder_.path() / "scores";
    fs::remove_all(scores);
    const Outcome outcome =
        run({"evaluate", (out_ / "model.obj").string(), cameras.string(), "--images", (scene_ / "images").string(),
             "--mesh", (scene_ / "mesh.ply").string(), "--truth", scene_.string(), "-o", scores.string()});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    means[cameras.filename()] = nlohmann::json::parse(read_file(scores / "evaluate.json"))["mean"];
    origins[cameras.filename()] = run_json(scores)["counts"]["truth"]["origin"]["all"];
  }
  for (const auto& [key, value] : means["colmap"].items()) {
    if (key == "windows") continue;
    EXPECT_NEAR(value.get<double>(), means["moved"][key].get<double>(), 1e-3) << key;
  }
  ASSERT_TRUE(origins["colmap"].contains("wrong"));
  for (const auto& [key, value] : origins["colmap"].items())
    EXPECT_NEAR(value.get<double>(), origins["moved"][key].get<double>(), 1e-3) << key;
}

TEST_F(App, CompareWithAModelElsewhereFailsAndDoesNotWin) {
  const fs::path away = folder_.path() / "away";
  ASSERT_EQ(run(texture(away)).exit_code, 0);
  std::ofstream(away / "offset.txt") << "1e6 0 0\n";
  auto compare = texture(out_);
  compare[0] = "compare";
  compare.insert(compare.end(), {"--modes", "gpvc", "--oracle-views", "0", "--crops", "0", "--external",
                                 "away=" + (away / "model.obj").string()});
  expect_one_sentence(run(compare), "1 of 2 models failed", "report.html");
  const nlohmann::json report = nlohmann::json::parse(read_file(out_ / "report.json"));
  EXPECT_TRUE(contains(report["modes"][1]["error"].get<std::string>(), "enough of it to compare"));
  EXPECT_TRUE(report["modes"][1]["score"]["one_minus_ncc"].is_null());
}

TEST_F(App, CompareWithAFailedModelFailsButReports) {
  const fs::path broken = folder_.write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  auto compare = texture(out_);
  compare[0] = "compare";
  compare.insert(compare.end(),
                 {"--modes", "none", "--oracle-views", "0", "--crops", "0", "--external", "broken=" + broken.string()});
  expect_one_sentence(run(compare), "1 of 2 models failed", "report.html");
  const nlohmann::json report = nlohmann::json::parse(read_file(out_ / "report.json"));
  EXPECT_EQ(report["modes"][0]["status"], "ok");
  EXPECT_EQ(report["modes"][1]["status"], "failed");
  EXPECT_TRUE(contains(report["modes"][1]["error"].get<std::string>(), "no textured face"));
}

TEST_F(App, SummariesTakeWholeReportsAndNothingElse) {
  const std::string good =
      R"({"format": "gpvc-compare/1", "scene": {"name": "a"}, "modes": [{"name": "gpvc", "epsilon": null}]})";
  for (const std::string& text :
       {std::string("{"), std::string("[]"), std::string(R"({"format": "gpvc-compare/1"})"),
        std::string(R"({"format": "gpvc-compare/1", "modes": [{}]})"),
        std::string(R"({"format": "gpvc-compare/1", "scene": {"name": "a"}, "modes": [{}]})"), good}) {
    const fs::path report = folder_.write("report.json", text);
    expect_one_sentence(run({"compare", "--summarize", report.string(), "-o", out_.string()}), "report.json", "");
    EXPECT_FALSE(fs::exists(out_));
  }
  for (const std::string option : {"--modes", "--views", "--external"})
    EXPECT_EQ(run({"compare", "--summarize", "report.json", "-o", out_.string(), option, "gpvc"}).exit_code, 2)
        << option;
}

TEST_F(App, HeldOutViewsAreLeftOutMarkedAndEvaluated) {
  ASSERT_EQ(run(texture(out_, {"--hold-out", "2"})).exit_code, 0);
  const nlohmann::json views = nlohmann::json::parse(read_file(out_ / "views.json"))["views"];
  ASSERT_EQ(views.size(), 5u);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(views[v]["held_out"], v % 2 == 1) << v;
    EXPECT_EQ(views[v]["used"], v % 2 == 0) << v;
  }
  for (const std::int32_t label : npy<std::int32_t>(out_ / "labels.npy"))
    EXPECT_TRUE(label == -1 || label % 2 == 0) << label;

  const fs::path scores = folder_.path() / "scores";
  const std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string(), "-o",
                                          scores.string()};
  ASSERT_EQ(run(evaluate).exit_code, 0);
  const nlohmann::json report = nlohmann::json::parse(read_file(scores / "evaluate.json"));
  ASSERT_EQ(report["views"].size(), 2u);
  for (const std::size_t v : {1u, 3u}) EXPECT_TRUE(report["views"].contains(views[v]["name"])) << v;

  std::vector<std::string> fewer = evaluate;
  fewer.insert(fewer.end(), {"--exclude-views", views[1]["name"], "--force"});
  ASSERT_EQ(run(fewer).exit_code, 0);
  const nlohmann::json rest = nlohmann::json::parse(read_file(scores / "evaluate.json"))["views"];
  EXPECT_EQ(rest.size(), 1u);
  EXPECT_TRUE(rest.contains(views[3]["name"]));
  fewer[fewer.size() - 2] = "*";
  EXPECT_EQ(run(fewer).exit_code, 2);
}

TEST_F(App, HoldOutTakesNamesAndRefusesNonsense) {
  ASSERT_EQ(run(texture(out_, {"--hold-out", "east*"})).exit_code, 0);
  const nlohmann::json views = nlohmann::json::parse(read_file(out_ / "views.json"))["views"];
  for (const auto& view : views)
    EXPECT_EQ(view["held_out"], view["name"].get<std::string>().starts_with("east")) << view["name"];
  const fs::path other = folder_.path() / "other";
  for (const char* wrong : {"1", "0", "7", "*", "nobody.jpg"}) {
    const Outcome outcome = run(texture(other, {"--hold-out", wrong}));
    EXPECT_EQ(outcome.exit_code, 2) << wrong;
    EXPECT_TRUE(contains(outcome.err, "--hold-out")) << wrong;
  }
  EXPECT_EQ(run(texture(other, {"--hold-out", "east_001.jpg", "--exclude-views", "east*"})).exit_code, 2);
  EXPECT_FALSE(fs::exists(other));
}

TEST_F(App, EvaluateOverwritesOnlyWhenForced) {
  ASSERT_EQ(run(texture(out_)).exit_code, 0);
  const fs::path scores = folder_.path() / "the scores";
  std::vector<std::string> evaluate{
      "evaluate",    (out_ / "model.glb").string(), (scene_ / "colmap").string(), "-o", scores.string(), "--views",
      "east_001.jpg"};
  ASSERT_EQ(run(evaluate).exit_code, 0);
  const auto before = files_of(scores);
  EXPECT_TRUE(before.contains("evaluate.json"));
  EXPECT_TRUE(before.contains("east_001.jpg.png"));
  expect_one_sentence(run(evaluate), "the scores", "--force");
  EXPECT_TRUE(files_of(scores) == before);
  evaluate.back() = "nadir_001.jpg";
  evaluate.push_back("--force");
  ASSERT_EQ(run(evaluate).exit_code, 0);
  EXPECT_FALSE(fs::exists(scores / "east_001.jpg.png"));
  EXPECT_TRUE(fs::exists(scores / "nadir_001.jpg.png"));
}

TEST_F(App, EvaluateScoresAgainstTheTruth) {
  ASSERT_EQ(run(texture(out_)).exit_code, 0);
  std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string(), "--truth",
                                    scene_.string()};
  const Outcome outcome = run(evaluate);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* word : {"seen whole by a view", "seen only in parts", "wrong"})
    EXPECT_TRUE(contains(outcome.out, word));
  EXPECT_FALSE(contains(outcome.out, "PSNR")) << "photos are compared when asked for";
  fs::remove(scene_ / "truth.json");
  expect_one_sentence(run(evaluate), "truth.json", "gpvc synth");
}

}  // namespace
}  // namespace gpvc
