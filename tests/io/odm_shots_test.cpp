#include <nlohmann/json.hpp>
#include <numbers>

#include "io/scene_files.h"
#include "io/scenes/opensfm_scene.h"
#include "tests/support/scene_folder.h"
#include "tests/support/zip_archive.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;

const std::string kCameras = R"({
  "dji fc330 400 300 brown 0.9 rgb": {"projection_type": "brown", "width": 400, "height": 300, "focal_x": 0.9,
    "focal_y": 0.9, "c_x": 0.01, "c_y": -0.02, "k1": -0.1, "k2": 0.02, "p1": 0.003, "p2": -0.004, "k3": 0.005}
})";

// Half a turn about x: looks down from 100 m. The centre is stated in the projected system.
const std::string kShots = R"({"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"filename": "a.jpg", "camera": "v2 dji fc330 400 300 brown 0.9 rgb", "focal": 0.9,
    "width": 400, "height": 300, "translation": [482716.0, 1557481.0, 100.0],
    "rotation": [3.141592653589793, 0.0, 0.0]}, "geometry": {"type": "Point", "coordinates": [-87, 14, 100]}}]})";

const std::string kCoords = "WGS84 UTM 16N\n482706 1557461\n10 20 100\n";

SceneFile parse(const std::string& shots, const std::string& cameras = kCameras) {
  return parse_odm_shots("shots.geojson", shots, "cameras.json", cameras);
}

class OdmShots : public testing::Test {
 protected:
  OdmShots() {
    folder.write("cameras.json", kCameras);
    folder.write("odm_report/shots.geojson", kShots);
    folder.write("odm_georeferencing/coords.txt", kCoords);
    test::write_photo(folder.path() / "images/a.jpg", 400, 300);
  }
  Scene read(const std::string& name = "") const { return read_scene(folder.path() / name, {}); }
  test::TemporaryFolder folder;
};

TEST_F(OdmShots, ProjectsAKnownPoint) {
  const Scene scene = read();
  EXPECT_EQ(scene.format, "OpenDroneMap shots");
  ASSERT_EQ(scene.views.size(), 1);
  // Meshes of the run are less the offset.
  EXPECT_EQ(scene.views[0].pose.centre, (WorldPoint{10, 20, 100}));
  EXPECT_EQ(scene.offset, (WorldPoint{482706, 1557461, 0}));
  EXPECT_EQ(scene.srs, "EPSG:32616");
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.005 * r2 * r2 * r2;
  const double u = x * radial + 2 * 0.003 * x * y - 0.004 * (r2 + 2 * x * x);
  const double v = y * radial + 0.003 * (r2 + 2 * y * y) - 2 * 0.004 * x * y;
  expect_photo_point(scene.views[0], {10 + 50 * x, 20 - 50 * y, 50}, 360 * u + 204, 360 * v + 142);
  EXPECT_EQ(read("odm_report/shots.geojson").views.size(), 1);
}

TEST_F(OdmShots, LeavesARunWithAReconstructionToIt) {
  folder.write("opensfm/reconstruction.json", "[]");
  EXPECT_TRUE(contains(input_error([&] { read(); }), "reconstruction.json: expected a list of reconstructions"));
}

TEST_F(OdmShots, NeedsTheOffset) {
  std::filesystem::remove(folder.path() / "odm_georeferencing/coords.txt");
  EXPECT_TRUE(contains(input_error([&] { read(); }), "coords.txt: is missing"));
}

TEST_F(OdmShots, ReadsTheArchiveItself) {
  const Scene unpacked = read();
  // As NodeODM packs it, and a folder of it that somebody packed again. Photos lie beside it.
  for (const std::string below : {"", "project/"}) {
    const std::string bytes = test::zipped({{below + "cameras.json", kCameras},
                                            {below + "odm_georeferencing/coords.txt", kCoords},
                                            {below + "odm_georeferencing/proj.txt", "+proj=utm +zone=16"},
                                            {below + "odm_report/shots.geojson", kShots}});
    folder.write("all.zip", bytes);
    const Scene scene = read("all.zip");
    EXPECT_EQ(scene.format, "OpenDroneMap shots");
    EXPECT_EQ(scene.read_from, folder.path() / "all.zip");
    EXPECT_EQ(scene.files, std::vector{folder.path() / "all.zip"});
    EXPECT_EQ(scene.srs, "+proj=utm +zone=16");
    EXPECT_EQ(scene.offset, unpacked.offset);
    ASSERT_EQ(scene.views.size(), 1);
    EXPECT_EQ(scene.views[0].photo, folder.path() / "images/a.jpg");
    EXPECT_EQ(scene.views[0].camera, unpacked.views[0].camera);
    EXPECT_EQ(scene.views[0].pose.centre, unpacked.views[0].pose.centre);
    EXPECT_EQ(scene.views[0].pose.rotation, unpacked.views[0].pose.rotation);
  }
  folder.write("all.zip", test::zipped({{"cameras.json", kCameras}, {"odm_report/shots.geojson", kShots}}));
  EXPECT_TRUE(contains(input_error([&] { read("all.zip"); }), "all.zip/odm_georeferencing/coords.txt: is missing"));
  folder.write("all.zip", test::zipped({{"cameras.json", kCameras}, {"odm_report/shots.geojson", "{"}}));
  EXPECT_TRUE(contains(input_error([&] { read("all.zip"); }), "all.zip/odm_report/shots.geojson"));
}

TEST(OdmShotsFile, TurnsFromWorldToCamera) {
  // A quarter turn about z from the camera that looks down: x_camera = R x_world, R = Rz(90) Rx(180). The vector of the
  // product is half a turn about (1, 1, 0).
  const double half = std::numbers::pi / std::sqrt(2.0);
  const std::string text =
      replaced(kShots, "3.141592653589793, 0.0, 0.0", std::to_string(half) + "00, " + std::to_string(half) + "00, 0.0");
  const auto r = parse(text).views.at(0).pose.rotation;
  const std::array<double, 9> expected{0, 1, 0, 1, 0, 0, 0, 0, -1};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(r[i], expected[i], 1e-5) << i;
  const std::string quarter = replaced(kShots, "3.141592653589793, 0.0, 0.0", "0.0, 0.0, 1.5707963267948966");
  EXPECT_NEAR(parse(quarter).views.at(0).pose.rotation[3], 1, 1e-12);  // the world's x is the camera's y
}

TEST(OdmShotsFile, FindsTheCamerasOfOlderRuns) {
  const std::string older = replaced(kShots, "\"camera\": \"v2 dji fc330 400 300 brown 0.9 rgb\", ", "");
  EXPECT_EQ(parse(older).views.at(0).camera.fx, 360);
  const std::string two = replaced(kCameras, "{\n", R"({"other": {"width": 400, "height": 300, "focal": 0.8},)");
  EXPECT_EQ(parse(older, two).views.at(0).camera.fx, 360);
  const std::string same = replaced(two, "0.8", "0.9");
  EXPECT_TRUE(contains(input_error([&] { parse(older, same); }), "feature 0: its camera could be"));
  EXPECT_TRUE(
      contains(input_error([&] { parse(replaced(older, "0.9", "0.7"), two); }), "no camera in cameras.json has"));
}

// Shots state a focal length, panoramas have none.
TEST(OdmShotsFile, ReadsPanoramas) {
  const SceneFile scene = parse(kShots, replaced(kCameras, "\"brown\"", "\"spherical\""));
  EXPECT_EQ(scene.views.at(0).camera, test::panorama_of(400, 300, 400 / (2 * std::numbers::pi)));
  EXPECT_TRUE(scene.warnings.empty());
  const std::string plain = R"({"dji fc330 400 300 brown 0.9 rgb": {"projection_type": "equirectangular", "width": 400,
    "height": 200}})";
  EXPECT_EQ(parse(kShots, plain).views.at(0).camera.height, 200);
}

TEST(OdmShotsFile, WarnsOfSplitRuns) {
  EXPECT_TRUE(parse(kShots).warnings.empty());
  const SceneFile scene = parse(replaced(kShots, "\"focal\": 0.9", "\"focal\": 0.91"));
  EXPECT_TRUE(contains(scene.warnings.at(0), "1 shots state another focal length"));
}

// As OpenDroneMap merges three parts: photos of the overlap of the last two are listed for both.
TEST(OdmShotsFile, KeepsTheFirstShotOfAPhoto) {
  const nlohmann::json once = nlohmann::json::parse(kShots);
  nlohmann::json twice = once;
  twice["features"].push_back(once["features"][0]);
  twice["features"].back()["properties"]["translation"][0] = 1.0;
  const SceneFile scene = parse(twice.dump());
  EXPECT_EQ(scene.views.size(), parse(kShots).views.size());
  EXPECT_EQ(scene.views[0].pose.centre, parse(kShots).views[0].pose.centre);
  EXPECT_TRUE(contains(scene.warnings.at(0), "1 shots are left out: others have their photo"));
}

TEST(OdmShotsFile, WithoutItsCamerasIsNamed) {
  const test::TemporaryFolder folder;
  for (const auto& source : {folder.write("shots.geojson", kShots), folder.path()})
    EXPECT_TRUE(
        contains(input_error([&] { read_scene(source, {}); }), "cameras.json and odm_georeferencing/coords.txt"));
}

TEST(OdmShotsFile, RefusesWithPlaceAndExpectation) {
  const auto error = [](const std::string& from, const std::string& to) {
    return input_error([&] { parse(replaced(kShots, from, to)); });
  };
  EXPECT_TRUE(contains(error("features", "f"), "shots.geojson"));
  EXPECT_TRUE(contains(error("fc330", "fc331"), "feature 0: its camera 'dji fc331"));
  EXPECT_TRUE(contains(error("\"translation\": [482716.0, ", "\"translation\": ["), "feature 0"));
  EXPECT_TRUE(contains(error("\"rotation\"", "\"r\""), "rotation"));
  EXPECT_TRUE(contains(error("a.jpg", ""), "expected the name of a photo"));
  EXPECT_TRUE(contains(input_error([&] { parse(kShots, "{}"); }), "cameras.json: expected an object of cameras"));
  EXPECT_TRUE(contains(input_error([&] { parse(kShots, replaced(kCameras, "\"brown\"", "\"dual\"")); }),
                       "projection type 'dual' is not supported"));
}

TEST(OdmShotsFile, SurvivesCuts) {
  for (std::size_t size = 0; size < kShots.size(); ++size)
    EXPECT_THROW(parse(kShots.substr(0, size)), InputError) << size;
  for (std::size_t size = 0; size + 1 < kCameras.size(); ++size)
    EXPECT_THROW(parse(kShots, kCameras.substr(0, size)), InputError) << size;
}

}  // namespace
}  // namespace gpvc::io
