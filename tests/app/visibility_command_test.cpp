// gpvc visibility as its users start it: several meshes, and the oracle beside the stage.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>

#include "io/mesh.h"
#include "io/npy.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiff_photo.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code;
  std::string out, err;
};

class VisibilityCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (visibility::list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    ASSERT_TRUE(fs::exists(fs::path(GPVC_APP_SCENE) / "run.json")) << "ctest makes the scene: app_scene.synth";
  }

  Outcome run(const std::string& words) const {
    const fs::path out = folder_.path() / "stdout", err = folder_.path() / "stderr";
    const int status =
        std::system(("'" GPVC_BINARY "' " + words + " >'" + out.string() + "' 2>'" + err.string() + "'").c_str());
    return {WEXITSTATUS(status), test::read_file(out), test::read_file(err)};
  }

  static std::string scene() { return "visibility '" GPVC_APP_SCENE "/colmap' "; }
  static std::string whole_mesh() { return "'" GPVC_APP_SCENE "/mesh.ply'"; }

  static void write_part(const fs::path& file, const Mesh& mesh, std::size_t first, std::size_t end) {
    std::ofstream obj(file);
    obj << std::setprecision(17);
    for (const WorldPoint& p : mesh.positions) obj << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (std::size_t f = first; f < end; ++f) {
      const Triangle& t = mesh.faces[f];
      obj << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
  }

  nlohmann::json json(const fs::path& file) const { return nlohmann::json::parse(test::read_file(file)); }

  test::TemporaryFolder folder_;
};

TEST_F(VisibilityCommand, SeveralMeshesAreSeenTogetherAndWrittenApart) {
  const Mesh mesh = io::read_mesh(fs::path(GPVC_APP_SCENE) / "mesh.ply");
  const std::size_t faces = mesh.faces.size(), first = faces / 3;
  const fs::path a = folder_.path() / "a b.obj", b = folder_.path() / "b.obj";
  write_part(a, mesh, 0, first);
  write_part(b, mesh, first, faces);
  const fs::path one = folder_.path() / "one", two = folder_.path() / "two";
  const Outcome single = run(scene() + whole_mesh() + " --ivm -o '" + one.string() + "'");
  ASSERT_EQ(single.exit_code, 0) << single.err;
  // Options between, before and after the meshes.
  const Outcome both = run(scene() + "'" + a.string() + "' -o '" + two.string() + "' '" + b.string() + "' --ivm");
  ASSERT_EQ(both.exit_code, 0) << both.err;
  std::size_t views = 0;
  for (const auto& entry : fs::directory_iterator(one / "visibility")) {
    const std::string name = entry.path().filename().string();
    const auto whole = io::read_npy<std::uint8_t>(entry.path()).values;
    auto parts = io::read_npy<std::uint8_t>(two / "visibility" / "0" / name).values;
    EXPECT_EQ(parts.size(), first);
    const auto rest = io::read_npy<std::uint8_t>(two / "visibility" / "1" / name).values;
    parts.insert(parts.end(), rest.begin(), rest.end());
    EXPECT_EQ(whole, parts) << name;
    EXPECT_EQ(test::read_file(one / "ivm" / name), test::read_file(two / "ivm" / name));
    ++views;
  }
  EXPECT_EQ(views, 5U);
  const auto meshes = json(two / "run.json")["counts"]["meshes"];
  ASSERT_EQ(meshes.size(), 2U);
  EXPECT_EQ(meshes[0]["file"], a.string());
  EXPECT_EQ(meshes[0]["faces"], first);
  EXPECT_EQ(meshes[1]["first_face"], first);
  EXPECT_EQ(meshes[1]["faces"], faces - first);
  EXPECT_EQ(meshes[1]["first_vertex"], mesh.positions.size());
}

TEST_F(VisibilityCommand, AMissingSecondMeshIsNamed) {
  const fs::path out = folder_.path() / "out";
  const Outcome outcome = run(scene() + whole_mesh() + " no-such.ply -o '" + out.string() + "'");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("no-such.ply"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(VisibilityCommand, OracleCheckAgreesAndSaysSo) {
  const fs::path out = folder_.path() / "out";
  const Outcome outcome = run(scene() + whole_mesh() + " --oracle-check 3 -o '" + out.string() + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("0 disagreements"), std::string::npos) << outcome.out;
  const auto check = json(out / "oracle.json");
  EXPECT_EQ(check["views"].size(), 3U);
  EXPECT_EQ(check["disagreements"], 0);
  std::size_t counted = check["tied"];
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t count = check["confusion"][i][k];
      counted += count;
      EXPECT_TRUE(i == k || count == 0) << i << ", " << k;
    }
  EXPECT_EQ(counted, 3 * json(out / "run.json")["counts"]["faces"].get<std::size_t>());
  EXPECT_GT(check["confusion"][2][2], 100);
}

TEST_F(VisibilityCommand, OracleCheckOfAnotherModeReportsAndSucceeds) {
  const fs::path out = folder_.path() / "out";
  const Outcome outcome =
      run(scene() + whole_mesh() + " --oracle-check 100 --no-subpixel --visibility none -o '" + out.string() + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto check = json(out / "oracle.json");
  EXPECT_EQ(check["views"].size(), 5U) << "there are no more";
  EXPECT_GT(check["disagreements"], 100) << "what is behind something is called full";
  EXPECT_EQ(check["first_disagreements"].size(), 10U);
  for (const auto& disagreement : check["first_disagreements"])
    EXPECT_NE(disagreement["found"], "hidden") << "no test hides a face, it only sees too much";
}

TEST_F(VisibilityCommand, WrongUseEndsWithOneSentence) {
  EXPECT_EQ(run(scene() + whole_mesh() + " --oracle-check 0 -o x").exit_code, 2);
  EXPECT_EQ(run(scene() + whole_mesh() + " --oracle-check many -o x").exit_code, 2);
  EXPECT_EQ(run(scene() + "-o x").exit_code, 2);
}

// A square of two triangles that fill a photo, the left half of which declares to have no data.
TEST_F(VisibilityCommand, PixelsWithoutDataSeeNothing) {
  const fs::path root = folder_.path();
  folder_.write("colmap/cameras.txt", "1 PINHOLE 40 40 40 40 20 20\n");
  folder_.write("colmap/images.txt", "1 1 0 0 0 0 0 0 1 a.tif\n\n2 1 0 0 0 0 0 0 1 b.tif\n\n");
  folder_.write("mesh.obj",
                "v -0.6 -0.6 1\nv -0.1 -0.6 1\nv -0.6 0.6 1\nv 0.1 -0.4 1\nv 0.4 -0.4 1\nv 0.1 0.4 1\n"
                "f 1 3 2\nf 4 6 5\n");
  Samples samples{40, 40, 2, SampleType::f32, std::vector<std::byte>(std::size_t{8} * 40 * 40)};
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x)
      for (int band = 0; band < 2; ++band)
        store_sample(samples.at(x, y) + 4 * band, SampleType::f32, static_cast<float>(x + y + band) / 100);
  test::write_tiff(root / "images" / "b.tif", samples);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 20; ++x) store_sample(samples.at(x, y) + 4, SampleType::f32, -9999);
  test::write_tiff(root / "images" / "a.tif", samples, {.nodata = "-9999"});
  const Outcome outcome =
      run("visibility '" + (root / "colmap").string() + "' '" + (root / "mesh.obj").string() + "' --images '" +
          (root / "images").string() + "' --ivm -o '" + (root / "out").string() + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto classes = [&](const char* name) {
    return io::read_npy<std::uint8_t>(root / "out" / "visibility" / name).values;
  };
  // Both photos see the right face whole; the left one lies where only b.tif has data.
  EXPECT_EQ(classes("b.tif.npy")[1], 2);
  EXPECT_EQ(classes("a.tif.npy")[1], 2);
  EXPECT_EQ(classes("b.tif.npy")[0], 1);  // it reaches beyond the photo
  EXPECT_EQ(classes("a.tif.npy")[0], 0);
  const auto seen = io::read_npy<std::uint32_t>(root / "out" / "ivm" / "a.tif.npy").values;
  for (std::size_t y = 0; y < 40; ++y)
    for (std::size_t x = 0; x < 20; ++x) EXPECT_EQ(seen[40 * y + x], 0xFFFFFFFFU);
  EXPECT_EQ(json(root / "out" / "run.json").at("counts").at("excluded_pixels"), 800);
  EXPECT_TRUE(test::contains(outcome.err, "for want of data: 800 pixels of 1 photos"));
}

}  // namespace
}  // namespace gpvc
