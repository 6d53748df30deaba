// gpvc ortho, from a scene or a result to files.
#include <random>

#include "app/pipeline/render_model.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/textured_model.h"
#include "tests/app/app_fixture.h"
#include "tests/support/raster_file.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

class OrthoCommand : public App {
 protected:
  std::vector<std::string> ortho(const fs::path& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = texture(out, more);
    words[0] = "ortho";
    return words;
  }
  std::vector<std::string> ortho_of(const fs::path& from, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"ortho", "--from", from.string(), "-o", out_.string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  /// The scene textured.
  fs::path textured() const {
    const fs::path out = folder_.path() / "textured";
    EXPECT_EQ(run(texture(out, {"--texture", "png"})).exit_code, 0);
    return out;
  }
  void expect_refused_ortho(const std::vector<std::string>& words, const std::string& where,
                            const std::string& why) const {
    expect_one_sentence(run(words), where, why);
    EXPECT_FALSE(fs::exists(out_)) << why;
  }
};

// The height of a mesh over a place, face by face.
double height_at(const Mesh& mesh, double x, double y) {
  double highest = -1e300;
  for (const auto& [a, b, c] : mesh.faces) {
    const WorldPoint &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
    const double area = (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    const double v = ((x - p.x) * (r.y - p.y) - (y - p.y) * (r.x - p.x)) / area;
    const double w = ((q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)) / area;
    if (area != 0 && v >= 0 && w >= 0 && v + w <= 1)
      highest = std::max(highest, p.z + v * (q.z - p.z) + w * (r.z - p.z));
  }
  return highest;
}

TEST_F(OrthoCommand, APhotographedCityLiesWhereItsMeshIs) {
  const Outcome outcome = run(ortho(out_, {"--gsd", "0.1"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, (out_ / "ortho.tif").string() + "\n");
  EXPECT_EQ(run_json(out_)["counts"]["gsd"], 0.1);
  const RasterFile heights = read_raster(out_ / "ortho_height.tif"), colors = read_raster(out_ / "ortho.tif"),
                   photos = read_raster(out_ / "ortho_photo.tif");
  EXPECT_EQ(colors.layout, "COG");
  EXPECT_TRUE(colors.software.starts_with("gpvc "));
  const Mesh mesh = io::read_mesh(scene_ / "mesh.ply");
  std::mt19937 random(5);
  int wrong = 0, compared = 0;
  for (int i = 0; i < 300; ++i) {
    const int x = static_cast<int>(random() % static_cast<unsigned>(heights.width));
    const int y = static_cast<int>(random() % static_cast<unsigned>(heights.height));
    if (heights.at(x, y) == -9999) continue;
    ++compared;
    const double truth = height_at(mesh, heights.place[0] + (x + 0.5) * 0.1, heights.place[3] - (y + 0.5) * 0.1);
    if (std::abs(truth - heights.at(x, y)) > 1e-3) ++wrong;
  }
  EXPECT_GT(compared, 200);
  EXPECT_LE(wrong, compared / 50) << "but for the fiftieth of a pixel that outlines are rounded by";
  for (int y = 0; y < colors.height; ++y)
    for (int x = 0; x < colors.width; ++x)
      ASSERT_EQ(colors.mask_at(x, y) == 0, photos.at(x, y) == 65535) << "each pixel that is shown is from a photo";
}

// By how many pixels b is shifted against a, by the least squares of one step; NaN: nothing to tell by.
std::array<double, 2> shift_between(const RasterFile& a, const Image& b, const std::vector<std::uint8_t>& b_shown) {
  const auto luma = [&](int x, int y) { return a.at(x, y, 0) + a.at(x, y, 1) + a.at(x, y, 2); };
  double xx = 0, xy = 0, yy = 0, xt = 0, yt = 0;
  for (int y = 1; y + 1 < a.height; ++y)
    for (int x = 1; x + 1 < a.width; ++x) {
      bool whole = b_shown[pixel_index(x, y, a.width)] != 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) whole = whole && a.mask_at(x + dx, y + dy) != 0;
      if (!whole) continue;
      const std::uint8_t* rgb = b.at(x, y);
      const double gx = (luma(x + 1, y) - luma(x - 1, y)) / 2, gy = (luma(x, y + 1) - luma(x, y - 1)) / 2;
      const double t = luma(x, y) - (rgb[0] + rgb[1] + rgb[2]);
      xx += gx * gx, xy += gx * gy, yy += gy * gy, xt += gx * t, yt += gy * t;
    }
  const double determinant = xx * yy - xy * xy;
  return {(yy * xt - xy * yt) / determinant, (xx * yt - xy * xt) / determinant};
}

TEST_F(OrthoCommand, IsAlignedWithARenderFromFarAbove) {
  const fs::path from = textured();
  ASSERT_EQ(run(ortho_of(from, {"--gsd", "0.1", "--unseen", "fill"})).exit_code, 0);
  const RasterFile colors = read_raster(out_ / "ortho.tif");
  io::LoadedModel model = io::read_textured_model(from / "model.obj");
  model.model.mesh = &model.mesh;
  constexpr double kHigh = 1e6;  // pixels are shifted by a hundredth where the ground is 20 m higher
  constexpr int kFiner = 5;      // pixels of the render to one of the orthophoto
  Camera camera;
  camera.width = kFiner * colors.width;
  camera.height = kFiner * colors.height;
  camera.fx = camera.fy = kHigh / (0.1 / kFiner);
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  Pose pose;
  pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  pose.centre = {colors.place[0] + 0.05 * colors.width, colors.place[3] - 0.05 * colors.height, kHigh};
  const pipeline::RenderResult render = pipeline::render_model(model.model, model.pages, camera, pose);
  const Image reduced = io::reduce_image(render.image, kFiner);
  std::vector<std::uint8_t> shown(colors.mask.size());
  for (int y = 0; y < colors.height; ++y)
    for (int x = 0; x < colors.width; ++x)
      shown[pixel_index(x, y, colors.width)] =
          render.textured[pixel_index(kFiner * x + 2, kFiner * y + 2, camera.width)];
  const auto [dx, dy] = shift_between(colors, reduced, shown);
  EXPECT_LT(std::abs(dx), 0.05);
  EXPECT_LT(std::abs(dy), 0.05);
  double apart = 0, count = 0;
  for (int y = 0; y < colors.height; ++y)
    for (int x = 0; x < colors.width; ++x)
      if (shown[pixel_index(x, y, colors.width)] != 0 && colors.mask_at(x, y) != 0)
        for (int c = 0; c < 3; ++c, ++count) apart += std::abs(colors.at(x, y, c) - reduced.at(x, y)[c]);
  EXPECT_LT(apart / count, 1) << "grey levels in the mean";
}

TEST_F(OrthoCommand, AResultGivesWhatItsSceneGives) {
  const fs::path from = textured();
  ASSERT_EQ(run(ortho_of(from)).exit_code, 0);
  const fs::path whole = folder_.path() / "whole";
  ASSERT_EQ(run(ortho(whole)).exit_code, 0);
  for (const char* name : {"ortho_height.tif", "ortho_photo.tif", "ortho_photos.csv"})
    EXPECT_TRUE(read_file(out_ / name) == read_file(whole / name)) << name;
  const RasterFile read = read_raster(out_ / "ortho.tif"), made = read_raster(whole / "ortho.tif");
  ASSERT_EQ(read.place, made.place);
  EXPECT_TRUE(read.mask == made.mask);
  ASSERT_EQ(read.values.size(), made.values.size());
  for (std::size_t i = 0; i < read.values.size(); ++i)
    ASSERT_NEAR(read.values[i], made.values[i], 1)
        << "texture coordinates of an OBJ run the other way, and are rounded there";
  // A model of any program.
  const fs::path glb = folder_.path() / "glb";
  fs::create_directory(glb);
  fs::copy_file(from / "model.glb", glb / "some.glb");
  ASSERT_EQ(
      run(ortho_of(glb / "some.glb", {"--force", "--mesh-crs", "EPSG:32632", "--gsd", "0.5", "--compress", "jpeg"}))
          .exit_code,
      0);
  EXPECT_FALSE(fs::exists(out_ / "ortho_photo.tif"));
  const RasterFile colors = read_raster(out_ / "ortho.tif");
  EXPECT_EQ(colors.system, "EPSG:32632");
  EXPECT_EQ(colors.compression, "YCbCr JPEG");
  EXPECT_TRUE(colors.has_mask);
  // One whose place another program has stated.
  std::ofstream(glb / "metadata.xml")
      << "<ModelMetadata version=\"1\"><SRS>EPSG:32631</SRS><SRSOrigin>500000,4000000,100</SRSOrigin>"
         "</ModelMetadata>";
  ASSERT_EQ(run(ortho_of(glb / "some.glb", {"--force", "--gsd", "0.5"})).exit_code, 0);
  const RasterFile moved = read_raster(out_ / "ortho.tif");
  EXPECT_EQ(moved.system, "EPSG:32631");
  EXPECT_NEAR(moved.place[0], colors.place[0] + 500000, 1e-6);
  EXPECT_NEAR(moved.place[3], colors.place[3] + 4000000, 1e-6);
}

TEST_F(OrthoCommand, SaysWhatToDoWhereMemoryDoesNotSuffice) {
  const Outcome outcome = run(ortho(out_, {"--memory", "10M"}));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(contains(outcome.err, "gpvc tiles and gpvc unit texture it in parts"));
  EXPECT_FALSE(fs::exists(out_ / "ortho.tif"));
}

TEST_F(OrthoCommand, TilesOfAJobAreOnePicture) {
  const fs::path job = folder_.path() / "job";
  auto words = texture(job, {"--tile-faces", "1500", "--no-levels"});
  words[0] = "tiles";
  ASSERT_EQ(run(words).exit_code, 0);
  ASSERT_EQ(run({"unit", job.string(), "--all"}).exit_code, 0);
  ASSERT_EQ(run(ortho_of(job / "result", {"--gsd", "0.1"})).exit_code, 0);
  const fs::path whole = folder_.path() / "whole";
  ASSERT_EQ(run(ortho(whole, {"--gsd", "0.1"})).exit_code, 0);
  const RasterFile tiles = read_raster(out_ / "ortho_height.tif"), all = read_raster(whole / "ortho_height.tif");
  double apart = 0;
  for (int y = 20; y < 400; ++y)
    for (int x = 20; x < 400; ++x) {
      const auto [u, v] = all.pixel_of(tiles.place[0] + (x + 0.5) * 0.1, tiles.place[3] - (y + 0.5) * 0.1);
      apart = std::max(apart, std::abs(tiles.at(x, y) - all.at(u, v)));
    }
  EXPECT_LT(apart, 1e-3);
}

TEST_F(OrthoCommand, RefusesBadInputInASentence) {
  const fs::path from = textured();
  expect_refused_ortho(ortho_of(folder_.path() / "none"), "none", "does not exist");
  expect_refused_ortho(ortho_of(scene_ / "images"), "images", "holds no textured model");
  expect_refused_ortho(ortho_of(scene_ / "mesh.ply"), "mesh.ply", "has no textured face");
  expect_refused_ortho(ortho_of(from, {"--crs", "EPSG:25832"}), "model.obj", "is in no known reference system");
  expect_refused_ortho(ortho_of(from, {"--crs", "nowhere", "--mesh-crs", "EPSG:25832"}), "nowhere",
                       "is no coordinate reference system");
  expect_refused_ortho(ortho_of(from, {"--bounds", "900,900,901,901"}), "model.obj", "beside the bounds");
  expect_refused_ortho(ortho_of(from, {"--gsd", "1e-7"}), "model.obj", "expected 10000000 along an edge at most");
  std::ofstream(from / "offset.txt") << "0 0 0\nsrs_offset 1 2\nsrs EPSG:25832\n";
  expect_refused_ortho(ortho_of(from), "offset.txt", "line 2: expected three numbers");
  std::ofstream(from / "offset.txt") << "0 0 0\nsrs EPSG:25832\n";
  expect_refused_ortho(ortho_of(from, {"--mesh-crs", "EPSG:32633"}), "textured", "has the coordinates of EPSG:25832");
  fs::remove(from / "offset.txt");
  fs::resize_file(from / "tags.npy", fs::file_size(from / "tags.npy") - 1);
  expect_refused_ortho(ortho_of(from), "tags.npy", "");
  fs::remove(from / "model_0.png");
  expect_refused_ortho(ortho_of(from), "model.obj", "texture");
}

TEST_F(OrthoCommand, RefusesBadUsage) {
  const auto complaint = [&](const std::vector<std::string>& words) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_FALSE(fs::exists(out_));
    return outcome.err;
  };
  EXPECT_TRUE(contains(complaint({"ortho", "-o", out_.string()}), "SCENE and MESH are missing"));
  EXPECT_TRUE(
      contains(complaint({"ortho", (scene_ / "colmap").string(), "-o", out_.string()}), "MESH is missing after SCENE"));
  EXPECT_TRUE(contains(complaint(ortho(out_, {"--bounds", "1,2,0,3"})), "'1,2,0,3' is not WEST,SOUTH,EAST,NORTH"));
  EXPECT_TRUE(contains(complaint(ortho(out_, {"--compress", "gif"})), "'gif' is none of deflate|lzw|zstd|jpeg|webp"));
  EXPECT_TRUE(contains(complaint(ortho(out_, {"--gsd", "0"})), "--gsd: '0' is not a number from"));
}

}  // namespace
}  // namespace gpvc
