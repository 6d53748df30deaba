// A mesh that is not where photos and tie points show it: refused in whatever way it is to be textured.
#include <fstream>

#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

using namespace test;

class MovedMesh : public App {
 protected:
  void SetUp() override {
    App::SetUp();
    ASSERT_EQ(run({"synth", "city", "-o", city_.string(), "--faces", "3000", "--size", "50", "--photos", "8",
                   "--photo-size", "480x320", "--quiet"})
                  .exit_code,
              0);
    std::string bytes = read_file(city_ / "mesh.ply");
    const std::size_t data = bytes.find("end_header\n") + 11;
    ASSERT_TRUE(contains(bytes, "property float x\nproperty float y\nproperty float z\nelement face"));
    const std::size_t count = bytes.find("element vertex ") + 15;
    const auto vertices = std::stoul(bytes.substr(count));
    for (std::size_t v = 0; v < vertices; ++v) {
      float x = 0;
      std::memcpy(&x, bytes.data() + data + 12 * v, sizeof x);
      x += 5;  // a tenth of the city
      std::memcpy(bytes.data() + data + 12 * v, &x, sizeof x);
    }
    std::ofstream(city_ / "moved.ply", std::ios::binary) << bytes;
  }
  std::vector<std::string> words(const std::string& command, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{command, (city_ / "colmap").string(), (city_ / "moved.ply").string(), "-o",
                                 out_.string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static constexpr const char* kFound = "the mesh is not where the photos show it: moved by (-";

  fs::path city_ = folder_.path() / "city";
};

TEST_F(MovedMesh, IsRefusedByTexture) { expect_one_sentence(run(words("texture")), "moved.ply", kFound); }

TEST_F(MovedMesh, IsRefusedByTileset) {
  expect_one_sentence(run(words("tileset", {"--tile-faces", "1000"})), "moved.ply", kFound);
}

TEST_F(MovedMesh, IsRefusedByAJob) {
  ASSERT_EQ(run(words("tiles", {"--tile-faces", "1000"})).exit_code, 0);
  expect_one_sentence(run({"unit", out_.string(), "--all"}), "moved.ply", kFound);
}

TEST_F(MovedMesh, IsRefusedByTextureThatGoesOnInTiles) {
  expect_one_sentence(run(words("texture", {"--memory", "230M"})), "moved.ply", kFound);
}

TEST_F(MovedMesh, IsRefusedAsAnEarlierResultsMesh) {
  auto right = words("texture", {"--editable"});
  right[2] = (city_ / "mesh.ply").string();
  const Outcome made = run(right);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_FALSE(contains(made.err, "warning")) << made.err;
  auto again = words("texture", {"--from", out_.string()});
  again[4] = (folder_.path() / "changed").string();
  expect_one_sentence(run(again), out_.string(), "was textured from another mesh; only");
}

TEST_F(MovedMesh, IsTexturedWhereThatIsWanted) {
  EXPECT_EQ(run(words("texture", {"--keep-odd-photos"})).exit_code, 1) << "that is about single photos";
  EXPECT_EQ(run(words("texture", {"--allow-misfit"})).exit_code, 0);
}

// Work of a run that was told to go on all the same says nothing about the mesh.
TEST_F(MovedMesh, IsRefusedThoughWorkOfAnAllowedRunIsKept) {
  Program allowed(words("texture", {"--allow-misfit", "--resume", "always"}));
  while (allowed.running() && !fs::exists(out_ / ".work" / "labels")) usleep(1000);
  allowed.send(SIGKILL);
  allowed.wait();
  ASSERT_TRUE(fs::exists(out_ / ".work" / "labels"));
  expect_one_sentence(run(words("texture", {"--resume", "always"})), "moved.ply", kFound);

  fs::remove_all(out_);
  ASSERT_EQ(run(words("tiles", {"--tile-faces", "1000", "--allow-misfit"})).exit_code, 0);
  ASSERT_EQ(run({"unit", out_.string(), "--all"}).exit_code, 0);
  ASSERT_EQ(run(words("tiles", {"--tile-faces", "1000", "--force"})).exit_code, 0);
  expect_one_sentence(run({"unit", out_.string(), "--all"}), "moved.ply", kFound);
}

}  // namespace
}  // namespace gpvc
