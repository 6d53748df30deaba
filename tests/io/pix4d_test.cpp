#include <cmath>

#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

const std::string kHeader =
    "fileName imageWidth imageHeight \ncamera matrix K [3x3]\nradial distortion [3x1]\ntangential distortion [2x1]\n"
    "camera position t [3x1]\ncamera rotation R [3x3]\ncamera model m = K [R|-Rt] X\n\n";
// Looks down from (10, 20, 100), the photo's upper side to the north.
const std::string kDown =
    "DJI 1.JPG 400 300\n360 0 201.5\n0 350 148\n0 0 1\n-0.1 0.02 0.003\n0.004 -0.002\n10 20 100\n1 0 0\n0 -1 0\n"
    "0 0 -1\n";
// From the same place along x, with y to the right and z down.
const std::string kAlong = "b.jpg 200 220\n80 0 101\n0 80 107\n0 0 1\n0 0 0\n0 0\n10 20 100\n0 1 0\n0 0 1\n1 0 0\n";
const std::string kFisheye = "GRE.TIF 200 220\n10 20 100\n1 0 0\n0 -1 0\n0 0 -1\n";
const std::string kTwo = kHeader + kDown + kAlong;

SceneFile parse(const std::string& text) { return test::parse_as("Pix4D", text); }

TEST(Pix4d, ProjectsAKnownPoint) {
  const SceneFile scene = parse(kTwo);
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_TRUE(scene.warnings.empty());
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
  const View& down = view_named(scene, "DJI 1.JPG");
  EXPECT_EQ(down.camera.width, 400);
  EXPECT_EQ(down.camera.height, 300);
  expect_photo_point(down, {10 + 50 * x, 20 - 50 * y, 50},
                     360 * (x * radial + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x)) + 201.5,
                     350 * (y * radial - 2 * 0.002 * x * y + 0.004 * (r2 + 2 * y * y)) + 148);
  expect_photo_point(view_named(scene, "b.jpg"), {60, 20 + 50 * x, 100 + 50 * y}, 80 * x + 101, 80 * y + 107);
}

TEST(Pix4d, LeavesOutFisheyes) {
  const SceneFile scene = parse(kHeader + kFisheye + kDown + kFisheye);
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_EQ(scene.warnings.at(0), "2 images are left out: their lens, 'fisheye', is not supported");
  EXPECT_TRUE(contains(input_error([] { parse(kHeader + kFisheye); }),
                       "line 9, 'GRE.TIF': has no camera matrix: photos of fisheye lenses are not read"));
}

TEST(Pix4d, TakesTheWorldFromTheFilesBeside) {
  const test::TemporaryFolder folder;
  const std::string params = "project/1_initial/params/p_";
  folder.write(params + "calibrated_camera_parameters.txt", kTwo);
  folder.write(params + "calibrated_external_camera_parameters.txt", "imageName X Y Z Omega Phi Kappa\n");
  folder.write(params + "calibrated_internal_camera_parameters.cam", "camera_calibration_file 0\n");
  test::write_photo(folder.path() / "project/images/DJI 1.JPG", 400, 300);
  test::write_photo(folder.path() / "project/images/b.jpg", 200, 220);
  // The same names with other contents, which only their place tells.
  test::write_photo(folder.path() / "project/1_initial/images/undistorted_images/b.jpg", 200, 220);

  const auto read = [&](const char* below) { return read_scene(folder.path() / below, {}); };
  Scene scene = read("project");
  EXPECT_EQ(scene.format, "Pix4D");
  EXPECT_EQ(scene.srs, "");
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(std::filesystem::equivalent(scene.views[1].photo, folder.path() / "project/images/b.jpg"));

  folder.write(params + "wkt.prj", "PROJCS[\"x\",\r\n  UNIT[\"metre\",1]]\r\n");
  scene = read("project/1_initial/params");
  EXPECT_EQ(scene.srs, "");
  EXPECT_TRUE(contains(scene.warnings.at(0), "p_offset.xyz is missing"));

  folder.write(params + "offset.xyz", "368109.000 3956043.000 96.000");
  scene = read("project/1_initial/params/p_calibrated_camera_parameters.txt");
  EXPECT_EQ(scene.srs, "PROJCS[\"x\",UNIT[\"metre\",1]]");
  EXPECT_EQ(scene.offset, (WorldPoint{368109, 3956043, 96}));
  EXPECT_EQ(scene.views[0].pose.centre, (WorldPoint{10, 20, 100}));
  EXPECT_EQ(scene.other_frames.at(0).origin, (WorldPoint{-368109, -3956043, -96}));
  EXPECT_EQ(scene.other_frames.at(0).srs, scene.srs);
  EXPECT_EQ(scene.files.size(), 3);

  folder.write(params + "wkt.prj", "LOCAL_CS[\"Arbitrary (m)\"]");
  EXPECT_EQ(read("project").srs, "");
  folder.write(params + "offset.xyz", "368109.000 3956043.000");
  EXPECT_TRUE(contains(input_error([&] { read("project"); }), "p_offset.xyz: expected three numbers"));
}

TEST(Pix4d, SaysWhichFileIsMissing) {
  const test::TemporaryFolder folder;
  folder.write("p_calibrated_external_camera_parameters.txt", "imageName X Y Z Omega Phi Kappa\n");
  const auto error = [](const std::filesystem::path& source) { return input_error([&] { read_scene(source, {}); }); };
  EXPECT_TRUE(contains(error(folder.path()), "holds only part of Pix4Dmapper's parameters; give *_calibrated_camera_"));
  folder.write("p_calibrated_internal_camera_parameters.cam", "camera_calibration_file 0\n");
  EXPECT_TRUE(contains(error(folder.path() / "p_calibrated_internal_camera_parameters.cam"), "is only part of Pix4D"));
  folder.write("p.p4d", "<?xml version=\"1.0\"?><pix4uav/>");
  EXPECT_TRUE(contains(error(folder.path() / "p.p4d"), "is a Pix4Dmapper project; give the folder 1_initial/params"));
}

TEST(Pix4d, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kTwo, from, to)); });
  };
  EXPECT_TRUE(contains(error("fileName", "name"), "line 1: expected 'fileName imageWidth imageHeight'"));
  EXPECT_TRUE(contains(error("camera model", "model"), "do not end with its 'camera model'"));
  EXPECT_TRUE(
      contains(error("b.jpg 200", "b.jpg 0"), "line 19: expected the name of a photo, its width and its height"));
  EXPECT_TRUE(contains(error("DJI 1.JPG ", ""), "line 9: expected the name of a photo"));
  EXPECT_TRUE(contains(error("360 0 201.5", "360 1 201.5"), "line 9, 'DJI 1.JPG': the camera matrix is not fx 0 cx"));
  EXPECT_TRUE(contains(error("360 0 201.5", "-360 0 201.5"), "line 9, 'DJI 1.JPG': the focal length is not positive"));
  EXPECT_TRUE(contains(error("360 0 201.5", "360 0"), "line 10: expected 3 numbers: a row of the camera matrix"));
  EXPECT_TRUE(contains(error("0.02 0.003", "x 0.003"), "line 13: expected 3 numbers: the lens"));
  EXPECT_TRUE(contains(error("0.004 -0.002", "0.004"), "line 14: expected 2 numbers: the tangential distortion"));
  EXPECT_TRUE(contains(error("10 20 100", "10 nan 100"), "line 15: expected 3 numbers: the camera position"));
  EXPECT_TRUE(contains(error("0 -1 0", "0 1 0"), "line 9, 'DJI 1.JPG': the camera rotation is none"));
}

// A file cut between two cameras cannot be told from a shorter one.
TEST(Pix4d, SurvivesCutsAndChanges) {
  const std::string one = kHeader + kDown;
  for (std::size_t size = 0; size < kTwo.size() - 1; ++size) {
    if (size >= one.size() - 1 && size <= one.size()) continue;
    EXPECT_THROW(parse(kTwo.substr(0, size)), InputError) << size << " bytes";
  }
  EXPECT_EQ(parse(one).views.size(), 1);
  test::expect_changes_survived("Pix4D", kTwo + kFisheye);
}

}  // namespace
}  // namespace gpvc::io
