// Every visibility mode as its users meet it: a texture from photos to files, and what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/cli/app.h"
#include "app/compare/bias_sweep.h"
#include "app/compare/compare_modes.h"
#include "app/evaluate/oracle_check.h"
#include "io/mesh.h"
#include "io/npy.h"
#include "io/scene_files.h"
#include "tests/support/temporary_folder.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

int gpvc(std::vector<std::string> words) {
  words.insert(words.begin(), "gpvc");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return cli::run_command_line(static_cast<int>(argv.size()), argv.data());
}

class ModesTextureGl : public testing::Test {
 protected:
  void SetUp() override {
    if (visibility::list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    ASSERT_EQ(gpvc({"synth", "city", "-o", scene().string(), "--faces", "3000", "--size", "40", "--photos", "5",
                    "--photo-size", "240x160", "--quiet"}),
              0);
  }
  fs::path scene() const { return folder_.path() / "city"; }
  fs::path out() const { return folder_.path() / "out"; }
  int run(const std::string& command, const std::vector<std::string>& more) const {
    std::vector<std::string> words{
        command,  (scene() / "colmap").string(), (scene() / "mesh.ply").string(), "-o", out().string(), "--force",
        "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return gpvc(words);
  }
  /// Faces that some view was chosen for.
  std::size_t labelled() const {
    const auto labels = io::read_npy<std::int32_t>(out() / "labels.npy");
    return static_cast<std::size_t>(
        std::count_if(labels.values.begin(), labels.values.end(), [](std::int32_t v) { return v >= 0; }));
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(ModesTextureGl, WhatDrawsTheFacesChangesNoByte) {
  const auto bytes = [&](const std::string& drawing) {
    EXPECT_EQ(run("texture", {"--drawing", drawing}), 0);
    std::string all;
    for (const char* file : {"labels.npy", "tags.npy", "model.obj", "model.glb"}) all += test::read_file(out() / file);
    return all;
  };
  EXPECT_TRUE(bytes("native") == bytes("opengl"));
}

TEST_F(ModesTextureGl, ATextureComesOutOfEveryMode) {
  ASSERT_EQ(run("texture", {}), 0);
  const std::size_t usual = labelled();
  ASSERT_GT(usual, 1000U);
  for (const char* mode :
       {"gpvc:ves", "shadow-map:spc:0.001", "shadow-map:apc:1e-11", "ray:sparse:0.01", "ray:dense:0.01", "none"}) {
    SCOPED_TRACE(mode);
    ASSERT_EQ(run("texture", {"--visibility", mode}), 0);
    EXPECT_TRUE(fs::exists(out() / "model.obj"));
    const auto record = nlohmann::json::parse(test::read_file(out() / "run.json"));
    EXPECT_EQ(record["options"]["visibility"], mode);
    EXPECT_EQ(record["options"]["projection"], std::string(mode).find("spc") == std::string::npos ? "apc" : "spc");
    const auto tags = io::read_npy<std::uint8_t>(out() / "tags.npy");
    EXPECT_GT(std::count(tags.values.begin(), tags.values.end(), 0), 1000) << "faces seen whole";
    if (std::string(mode) == "none") {
      EXPECT_GT(labelled(), usual) << "what is hidden is taken for seen";
    } else {
      EXPECT_NEAR(static_cast<double>(labelled()), static_cast<double>(usual), 0.1 * static_cast<double>(usual));
    }
  }
  ASSERT_EQ(run("texture", {"--visibility", "gpvc", "--projection", "spc"}), 0);
  EXPECT_EQ(labelled(), usual);
  EXPECT_EQ(nlohmann::json::parse(test::read_file(out() / "run.json"))["options"]["projection"], "spc");
}

// Too small a bias makes faces hide themselves, too large a one shows hidden faces: by the oracle's classes, each sweep
// that `gpvc compare` tries by default holds a bias that is better than both of its ends.
TEST_F(ModesTextureGl, DefaultSweepsBracketTheBestBias) {
  const Mesh mesh = io::read_mesh(scene() / "mesh.ply");
  const Scene read = io::read_scene(scene() / "colmap", {});
  std::vector<ViewId> used;
  for (std::uint32_t v = 0; v < read.views.size(); ++v) used.push_back(ViewId{v});
  const Progress silent = [](std::size_t, std::size_t) {};
  const auto oracle = evaluate::oracle_views(mesh, read, used, used.size(), silent);
  const compare::BiasScale scale(mesh, read, used);
  visibility::GraphicsDevice device;
  for (const std::string family : {"shadow-map:spc", "shadow-map:apc", "ray:sparse", "ray:dense"}) {
    SCOPED_TRACE(family);
    std::vector<double> agreement;
    for (const compare::ComparedMode& mode :
         compare::compared_modes(family, [&](const std::string& name) { return scale.sweep(name); })) {
      visibility::VisibilityStage stage(mesh, mode.visibility, &device);
      evaluate::Confusion confusion;
      for (const auto& [id, truth] : oracle)
        confusion.add(stage.classify(read.views[index(id)], id, nullptr).classes, truth);
      agreement.push_back(confusion.accuracy());
    }
    const double best = *std::max_element(agreement.begin(), agreement.end());
    EXPECT_GT(best, agreement.front());
    EXPECT_GT(best, agreement.back());
  }
}

TEST_F(ModesTextureGl, RefusesModesAndProjectionsThatMeanNothing) {
  for (const char* mode : {"ray:dense", "ray:dense:0", "shadow-map:xyz:1", "occlusion", ""})
    EXPECT_EQ(run("visibility", {"--visibility", mode}), 2) << mode;
  EXPECT_EQ(run("visibility", {"--projection", "spc", "--visibility", "shadow-map:apc:0.1"}), 2);
  EXPECT_EQ(run("visibility", {"--projection", "sideways"}), 2);
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace gpvc
