// What the program says to commands as they are typed.
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

using MessagesOfARun = App;

TEST(Messages, MistypedWordsAreGuessed) {
  EXPECT_TRUE(contains(run({"textre", "a"}).err, "no command 'textre'; did you mean 'texture'?"));
  EXPECT_TRUE(
      contains(run({"texture", "a", "b", "-o", "c", "--view=x"}).err, "no option '--view=x'; did you mean '--views'?"));
  EXPECT_TRUE(contains(run({"texture", "a", "b", "x", "-o", "c"}).err, "'x' is one argument too many"));
  EXPECT_TRUE(contains(run({"synth"}).err, "a command is missing"));
  // The word that is wrong, rather than what follows it.
  EXPECT_TRUE(contains(run({"textur", "a", "b", "-o", "c"}).err, "no command 'textur'; did you mean 'texture'?"));
  EXPECT_TRUE(contains(run({"texure", "--help"}).err, "no command 'texure'; did you mean 'texture'?"));
  EXPECT_TRUE(contains(run({"synth", "cty", "-o", "c"}).err, "no command 'cty'; did you mean 'city'?"));
}

TEST(Messages, HelpIsACommandToo) {
  const Outcome outcome = run({"help", "synth", "city"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, run({"synth", "city", "--help"}).out);
  EXPECT_EQ(run({"help"}).out, run({"--help"}).out);
  EXPECT_EQ(run({"help", "texure"}).exit_code, 2);
}

TEST(Messages, ErrorsAreInOurWords) {
  const auto complaint = [](std::vector<std::string> words) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 2);
    return outcome.err.substr(0, outcome.err.find('\n'));
  };
  EXPECT_EQ(complaint({"texture", "a"}), "gpvc: error: MESH is missing");
  EXPECT_EQ(complaint({"texture", "a", "b"}), "gpvc: error: --output is missing");
  EXPECT_EQ(complaint({"texture", "a", "b", "-o"}), "gpvc: error: --output needs a value");
  EXPECT_EQ(complaint({"texture", "a", "b", "-o", "c", "--padding", "5", "--padding", "6"}),
            "gpvc: error: --padding is given more than once");
  EXPECT_EQ(complaint({"texture", "a", "b", "-o", "c", "-q", "-v"}),
            "gpvc: error: --quiet and --verbose exclude each other");
  EXPECT_EQ(complaint({"convert", "a", "-o", "c", "--frame", "all"}),
            "gpvc: error: --frame belongs to --undistort, which is missing");
}

TEST(Messages, AnEarlierNameWorksWithANote) {
  const Outcome outcome = run({"texture", "/nowhere", "/nowhere.ply", "-o", "/nowhere/out", "--keep-views"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(contains(outcome.err, "--keep-views is now --keep-odd-photos and --allow-misfit")) << outcome.err;
  EXPECT_FALSE(contains(run({"texture", "--help"}).out, "--keep-views"));
}

TEST_F(MessagesOfARun, SceneAndMeshInEachOthersPlacesAreNoticedByEveryCommand) {
  const std::string scene = (scene_ / "colmap").string(), mesh = (scene_ / "mesh.ply").string();
  for (const char* command : {"texture", "tileset", "tiles", "visibility", "compare"})
    expect_one_sentence(run({command, mesh, scene, "-o", out_.string()}), mesh,
                        "is a mesh, expected cameras and photos in its place: SCENE comes first, then MESH");
  expect_one_sentence(run({"inspect", mesh, scene}), mesh, "SCENE comes first, then MESH");
  expect_one_sentence(run({"convert", mesh, "-o", out_.string()}), mesh, "SCENE alone is converted");
  expect_one_sentence(run({"evaluate", scene, mesh}), mesh, "MODEL comes first, then SCENE");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(MessagesOfARun, AMissingMeshIsNamedBeforeAnythingIsRead) {
  fs::remove_all(scene_ / "images");  // which would be noticed first otherwise
  auto words = texture(out_);
  words[2] = (scene_ / "nowhere.ply").string();
  expect_one_sentence(run(words), "nowhere.ply", "does not exist");
}

TEST_F(MessagesOfARun, AFolderWithoutCamerasIsToldInOneLine) {
  const fs::path empty = folder_.path() / "empty";
  fs::create_directory(empty);
  const Outcome outcome = run({"texture", empty.string(), (scene_ / "mesh.ply").string(), "-o", out_.string()});
  expect_one_sentence(outcome, empty.string(), "is no scene");
  EXPECT_LE(outcome.err.size(), 400u) << "formats are listed by --help";
  expect_one_sentence(
      run({"texture", (scene_ / "images").string(), (scene_ / "mesh.ply").string(), "-o", out_.string()}),
      "images: is no scene", "colmap is one (COLMAP); give that");
}

TEST_F(MessagesOfARun, AnotherScenesMeshIsNotCalledInsideOut) {
  const fs::path other = folder_.path() / "other";
  ASSERT_EQ(run({"synth", "city", "-o", other.string(), "--faces", "2000", "--size", "40", "--photos", "4",
                 "--photo-size", "64x48", "--seed", "9", "-q"})
                .exit_code,
            0);
  auto words = texture(out_);
  words[2] = (other / "mesh.ply").string();
  const Outcome outcome = run(words);
  EXPECT_TRUE(contains(outcome.err, "tie points"));
  EXPECT_FALSE(contains(outcome.err, "inside out"));
}

TEST_F(MessagesOfARun, WhatDiffersFromTheEarlierResultIsNamedWithBothValues) {
  ASSERT_EQ(run(texture(out_, {"--editable"})).exit_code, 0);
  const auto complaint = [&](const std::vector<std::string>& options) {
    auto words = texture(folder_.path() / "again", options);
    words.insert(words.end(), {"--from", out_.string()});
    return run(words).err;
  };
  EXPECT_TRUE(contains(complaint({"--smoothness", "0.1"}), "was textured with smoothness 1, and 0.1 is asked for now"));
  EXPECT_TRUE(contains(complaint({"--views", "east_001.jpg"}),
                       "was textured with photos that are not among those given: nadir_001.jpg, "));
}

TEST_F(MessagesOfARun, PhotosThatNothingCanBeComparedWithAreNotJudged) {
  const Outcome outcome = run(texture(out_, {"-v", "--views", "east_001.jpg"}));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.err, "east_001.jpg: not judged, as it can be compared with other photos at "));
}

TEST_F(MessagesOfARun, TheShareOfBlendedFacesIsTold) {
  EXPECT_TRUE(contains(run(texture(out_)).err, " % of the faces blended with other photos"));
  EXPECT_FALSE(contains(run(texture(out_, {"--blend", "none", "--force"})).err, "blended"));
}

}  // namespace
}  // namespace gpvc
