// What the program says about input that cannot be used.
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <string>

#include "app/synth/synth_scene.h"
#include "io/mesh.h"
#include "io/vector.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST_F(App, RefusesAMissingImage) {
  fs::remove(scene_ / "images" / "nadir_001.jpg");
  expect_refused("nadir_001.jpg", "");
}

TEST_F(App, TexturesWithoutAnExcludedImageThatIsMissing) {
  fs::remove(scene_ / "images" / "nadir_001.jpg");
  for (const auto& choice : {std::vector<std::string>{"--exclude-views", "nadir_001.jpg"},
                             std::vector<std::string>{"--views", "east_001,[nsw]o*_001.jpg,west_001"}}) {
    const Outcome outcome = run(texture(out_, choice));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(run_json(out_)["counts"]["used_views"], 4);
    fs::remove_all(out_);
  }
}

TEST_F(App, APreviewTakesSmallerPhotosAndNoMoreThanItNeeds) {
  for (const auto& [more, reduction] : {std::pair{"4", 4}, {"2", 2}}) {
    std::vector<std::string> options{"--preview", "--force", "--allow-misfit"};
    if (reduction != 4) options.insert(options.end(), {"--downscale", more});
    const Outcome outcome = run(texture(out_, options));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "of 5 photos, in 1/" + std::string(more) + " of their width")) << outcome.err;
    const auto json = run_json(out_);
    EXPECT_EQ(json["options"]["downscale"], reduction);
    EXPECT_EQ(json["options"]["preview"], true);
    EXPECT_LE(json["counts"]["used_views"], 5);
  }
}

TEST_F(App, RefusesATruncatedImage) {
  const fs::path photo = scene_ / "images" / "nadir_001.jpg";
  fs::resize_file(photo, fs::file_size(photo) / 2);
  const Outcome outcome = run(texture(out_));
  expect_one_sentence(outcome, "nadir_001.jpg", "ends too early");
  EXPECT_EQ(outcome.err.find("drawing:"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out_));
}

/// Takes bytes out of the picture of a JPEG: its headers and its end are as they were.
void damage(const fs::path& photo) {
  std::string bytes = read_file(photo);
  bytes.erase(bytes.size() / 2, 200);
  std::ofstream(photo, std::ios::binary) << bytes;
}

TEST_F(App, NamesAllDamagedImagesAtOnce) {
  damage(scene_ / "images" / "east_001.jpg");
  damage(scene_ / "images" / "nadir_001.jpg");
  const Outcome outcome = run(texture(out_));
  expect_one_sentence(outcome, "2 photos cannot be decoded", "--skip-bad-photos");
  for (const char* name : {"east_001.jpg: cannot be decoded whole", "nadir_001.jpg: cannot be decoded whole"})
    EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(App, GoesOnWithoutBadImagesAndListsThem) {
  fs::remove(scene_ / "images" / "nadir_001.jpg");
  expect_one_sentence(run(texture(out_)), "nadir_001.jpg", "--skip-bad-photos");
  damage(scene_ / "images" / "east_001.jpg");
  const Outcome outcome = run(texture(out_, {"--skip-bad-photos"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto counts = run_json(out_)["counts"];
  EXPECT_EQ(counts["used_views"], 3);
  ASSERT_EQ(counts["bad_photos"].size(), 2);
  std::map<std::string, std::string> problems;
  for (const auto& photo : counts["bad_photos"]) problems[photo["view"]] = photo["problem"];
  EXPECT_EQ(problems, (std::map<std::string, std::string>{{"nadir_001.jpg", "missing"}, {"east_001.jpg", "damaged"}}));
  EXPECT_NE(outcome.err.find("left out: "), std::string::npos) << outcome.err;
}

TEST_F(App, ShowsNoControlCharactersOfNames) {
  const fs::path images = scene_ / "colmap" / "images.txt";
  std::string text = read_file(images);
  text.replace(text.find("nadir_001.jpg"), 13, "\x1B[31mred.jpg");
  std::ofstream(images) << text;
  for (const auto& words : {texture(out_), std::vector<std::string>{"inspect", (scene_ / "colmap").string()}}) {
    const Outcome outcome = run(words);
    EXPECT_EQ((outcome.out + outcome.err).find('\x1B'), std::string::npos) << outcome.err;
    EXPECT_NE((outcome.out + outcome.err).find("\\x1b[31mred.jpg"), std::string::npos) << outcome.out << outcome.err;
  }
}

TEST_F(App, RefusesCamerasCutInTheMiddle) {
  const fs::path cameras = scene_ / "colmap" / "cameras.txt";
  fs::resize_file(cameras, fs::file_size(cameras) - 40);
  expect_refused("cameras.txt", "");
}

TEST_F(App, RefusesImagesCutInTheMiddle) {
  const fs::path images = scene_ / "colmap" / "images.txt";
  const std::string text = read_file(images);
  fs::resize_file(images, text.find("nadir_001.jpg") - 20);
  expect_refused("images.txt", "");
}

// The library says what is wrong, the program which option helps.
TEST_F(App, NamesTheOptionThatTexturesAMeshOfWhichHardlyAnythingIsSeen) {
  Mesh large = io::read_mesh(scene_ / "mesh.ply");
  for (WorldPoint& p : large.positions) p = 1000.0 * p;
  synth::write_synth_mesh(scene_ / "mesh.ply", large, {});
  expect_one_sentence(run(texture(out_)), "photos see less than 5 % of the faces",
                      "; --allow-unseen textures all the same");
  std::vector<std::string> job = texture(out_);
  job[0] = "tiles";
  ASSERT_EQ(run(job).exit_code, 0);
  expect_one_sentence(run({"unit", out_.string(), "--all"}), "photos see less than 5 % of the faces",
                      "a job made with --allow-unseen textures all the same");
}

// Reading a pipe may wait for ever, and a device may have no end.
TEST_F(App, RefusesPipesAndDevicesAsInput) {
  const fs::path pipe = folder_.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  constexpr const char* kSaid = "is a pipe, socket or device";
  for (const fs::path& file : {pipe, fs::path("/dev/zero")}) {
    for (const char* name : {"mesh.ply", "colmap/images.txt", "colmap/cameras.txt"}) {
      fs::rename(scene_ / name, folder_.path() / "kept");
      fs::create_symlink(file, scene_ / name);
      expect_one_sentence(run(texture(out_)), fs::path(name).filename().string(), kSaid);
      fs::rename(folder_.path() / "kept", scene_ / name);
    }
    expect_one_sentence(run(texture(out_, {"--views", "@" + file.string()})), file.string(), kSaid);
    folder_.write("model/m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n");
    const std::vector<std::string> evaluate{"evaluate", (folder_.path() / "model/m.obj").string(),
                                            (scene_ / "colmap").string()};
    fs::create_symlink(file, folder_.path() / "model/m.mtl");
    expect_one_sentence(run(evaluate), "m.mtl", kSaid);
    fs::remove(folder_.path() / "model/m.mtl");
    folder_.write("model/m.mtl", "newmtl a\nmap_Kd page.png\n");
    fs::create_symlink(file, folder_.path() / "model/page.png");
    expect_one_sentence(run(evaluate), "page.png", kSaid);
    fs::remove_all(folder_.path() / "model");
  }
}

// A GIF of 65535 x 65535 pixels in a few bytes.
TEST_F(App, RefusesAGif) {
  folder_.write("scene/images/nadir_001.jpg", std::string("GIF89a\xFF\xFF\xFF\xFF\x80\0\0", 13));
  expect_refused("nadir_001.jpg", "is a GIF, expected JPEG");
}

TEST_F(App, RefusesAMissingScene) {
  fs::remove_all(scene_ / "colmap");
  expect_refused("colmap", "");
}

TEST_F(App, RefusesAMeshWithNan) {
  std::ofstream(scene_ / "mesh.ply") << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                        "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                        "end_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n";
  expect_refused("mesh.ply", "");
}

TEST_F(App, RefusesAMeshWithIndicesOutOfRange) {
  std::ofstream(scene_ / "mesh.ply") << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                        "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                        "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n";
  expect_refused("mesh.ply", "3");
}

TEST_F(App, RefusesAMeshWithoutFaces) {
  std::ofstream(scene_ / "mesh.ply") << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                                        "property float z\nend_header\n0 0 0\n";
  expect_refused("mesh.ply", "face");
}

TEST_F(App, WarningsNameTheMeshOfSeveral) {
  folder_.write("scene/tiles/second.obj", "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\nf 1 2\n");
  fs::rename(scene_ / "mesh.ply", scene_ / "tiles/first.ply");
  const std::string second = (scene_ / "tiles/second.obj").string(),
                    expected = second + ": 1 faces of fewer than three vertices";
  const Outcome textured =
      run({"texture", (scene_ / "colmap").string(), (scene_ / "tiles").string(), "-o", out_.string()});
  EXPECT_EQ(textured.exit_code, 0) << textured.err;
  EXPECT_TRUE(contains(textured.err, expected)) << textured.err;
  EXPECT_TRUE(contains(run({"inspect", (scene_ / "colmap").string(), second}).err, expected));
}

TEST_F(App, RefusesAFolderWithTwoVersionsOfTheMesh) {
  const fs::path tiles = scene_ / "tiles";
  fs::create_directories(tiles);
  fs::copy_file(scene_ / "mesh.ply", tiles / "odm_25dmesh.ply");
  fs::copy_file(scene_ / "mesh.ply", tiles / "odm_mesh.ply");
  expect_one_sentence(run({"texture", (scene_ / "colmap").string(), tiles.string(), "-o", out_.string()}),
                      "odm_mesh.ply: fills the same place as", "odm_25dmesh.ply");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(App, ExplainsAMeshInAnotherFrame) {
  std::ofstream(scene_ / "mesh.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
         "property double z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n500000 5000000 0\n500001 5000000 0\n500000 5000001 0\n3 0 1 2\n";
  expect_one_sentence(run(texture(out_)), "no photo sees any face", "same coordinates");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(App, RulesAboutPhotosAreReadOrRefused) {
  const fs::path rules = folder_.write("rules.csv", "polygon,-40 -40 40 -40 40 40 -40 40,forbid,nadir_*;west_001\n");
  const Outcome outcome = run(texture(out_, {"--allow", rules.string()}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(run_json(out_)["options"]["allow"], rules.string());
  const std::vector<std::int32_t> labels = npy<std::int32_t>(out_ / "labels.npy");
  ASSERT_FALSE(labels.empty());
  // east_001, nadir_001, north_001, south_001, west_001
  for (const std::int32_t label : labels) EXPECT_TRUE(label != 1 && label != 4) << label;
  EXPECT_GT(std::ranges::count(labels, 0), 100);
  fs::remove_all(out_);

  folder_.write("rules.csv", "box,0 0 0 1 1 1,forbid,nadir_0001\n");
  expect_one_sentence(run(texture(out_, {"--allow", rules.string()})), "rules.csv: line 1",
                      "the scene has no view 'nadir_0001'; near are nadir_001.jpg");
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
}  // namespace gpvc
