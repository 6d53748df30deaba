// gpvc evaluate and what gpvc texture leaves for it.
#include "app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST_F(App, EvaluateWantsATexturedModel) {
  ASSERT_EQ(run(texture(out_, {"--quiet"})).exit_code, 0);
  const std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(),
                                          (scene_ / "colmap").string()};
  const Outcome scored = run(evaluate);
  EXPECT_EQ(scored.exit_code, 0) << scored.err;
  EXPECT_TRUE(contains(scored.out, "mean"));
  fs::remove(out_ / "model.mtl");
  expect_one_sentence(run(evaluate), "model.obj", "no textured face");
  std::ofstream(out_ / "model.obj", std::ios::trunc).close();
  expect_one_sentence(run(evaluate), "model.obj", "no textured face");
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
  const std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(),
                                          (scene_ / "colmap").string(), "-o", scores.string()};
  ASSERT_EQ(run(evaluate).exit_code, 0);
  const nlohmann::json report = nlohmann::json::parse(read_file(scores / "evaluate.json"));
  ASSERT_EQ(report["views"].size(), 2u);
  for (const std::size_t v : {1u, 3u}) EXPECT_TRUE(report["views"].contains(views[v]["name"])) << v;
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
  std::vector<std::string> evaluate{"evaluate",
                                    (out_ / "model.glb").string(),
                                    (scene_ / "colmap").string(),
                                    "-o",
                                    scores.string(),
                                    "--views",
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
  std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string(),
                                    "--truth", scene_.string()};
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
