#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// As Meshroom writes it, by hand: the first camera looks down from (10, 20, 100); the second, at the same place, looks
// along x, with y to the right and z down. Matrices stand column by column.
const std::string kSfm = R"({
 "version": ["1", "2", "8"],
 "featuresFolders": "",
 "views": [
  {"viewId": "11", "poseId": "4", "intrinsicId": "4294967295", "path": "D:\/photos\/a.jpg", "width": "400", "height": "300",
   "metadata": {"Make": "DJI"}},
  {"viewId": "12", "poseId": "5", "intrinsicId": "8", "path": "D:\/photos\/b.jpg", "width": "200", "height": "220",
   "metadata": ""},
  {"viewId": "13", "intrinsicId": "8", "path": "D:\/photos\/lost.jpg", "width": "200", "height": "220"}
 ],
 "intrinsics": [
  {"intrinsicId": "4294967295", "width": "400", "height": "300", "sensorWidth": "40", "sensorHeight": "30",
   "type": "pinhole", "focalLength": "36", "pixelRatio": "1.25", "principalPoint": ["1", "-2.5"],
   "distortionType": "brown", "undistortionType": "none",
   "distortionParams": ["-0.1", "0.02", "0.003", "0.004", "-0.002"]},
  {"intrinsicId": "8", "width": "200", "height": "220", "sensorWidth": "20", "sensorHeight": "22",
   "type": "pinhole", "focalLength": "8", "principalPoint": ["0.5", "-3.5"],
   "distortionType": "fisheye", "undistortionType": "none", "distortionParams": ["0.01", "-0.002", "0.003", "-0.0004"]}
 ],
 "poses": [
  {"poseId": "4", "pose": {"transform": {"rotation": ["1", "0", "0", "0", "-1", "0", "0", "0", "-1"],
   "center": ["10", "20", "100"]}, "locked": "0"}},
  {"poseId": "5", "pose": {"transform": {"rotation": ["0", "0", "1", "1", "0", "0", "0", "1", "0"],
   "center": ["10", "20", "100"]}, "locked": "0"}}
 ],
 "structure": [{"landmarkId": "0"}]
}
)";

SceneFile parse(const std::string& text) { return test::parse_as("AliceVision", text); }

View first_of(const std::string& text) { return view_named(parse(text), "D:/photos/a.jpg"); }

// The middle of the photo is (200, 150) from the first pixel's centre, (200.5, 150.5) from its corner.
TEST(AliceVision, ProjectsAKnownPointWithEveryLens) {
  const SceneFile scene = parse(kSfm);
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.warnings.at(0), "1 images without a pose are left out");
  const double x = 0.3, y = -0.2, r2 = 0.13, brown = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
  const WorldPoint p{10 + 50 * x, 20 - 50 * y, 50};
  expect_photo_point(view_named(scene, "D:/photos/a.jpg"), p,
                     360 * (x * brown + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x)) + 201.5,
                     450 * (y * brown - 2 * 0.002 * x * y + 0.004 * (r2 + 2 * y * y)) + 148);
  const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
  const double bent = t * (1 + 0.01 * t2 - 0.002 * t2 * t2 + 0.003 * std::pow(t2, 3) - 0.0004 * std::pow(t2, 4)) / r;
  expect_photo_point(view_named(scene, "D:/photos/b.jpg"), {60, 20 + 50 * x, 100 + 50 * y}, 80 * x * bent + 101,
                     80 * y * bent + 107);
  const std::string terms =
      "\"brown\", \"undistortionType\": \"none\",\n   \"distortionParams\": [\"-0.1\", \"0.02\", \"0.003\", \"0.004\", "
      "\"-0.002\"]";
  const auto with = [&](const std::string& other) { return first_of(replaced(kSfm, terms, other)); };
  expect_photo_point(with("\"radialk3\", \"distortionParams\": [\"-0.1\", \"0.02\", \"0.003\"]"), p,
                     360 * x * brown + 201.5, 450 * y * brown + 148);
  expect_photo_point(with("\"radialk1\", \"distortionParams\": [\"-0.1\"]"), p, 360 * x * (1 - 0.1 * r2) + 201.5,
                     450 * y * (1 - 0.1 * r2) + 148);
  expect_photo_point(with("\"none\", \"distortionParams\": \"\""), p, 360 * x + 201.5, 450 * y + 148);
  expect_photo_point(with("\"radialk1\", \"distortionParams\": \"\""), p, 360 * x + 201.5, 450 * y + 148);
  const double fov = std::atan(2 * r * std::tan(0.45)) / 0.9 / r;
  expect_photo_point(with("\"fisheye1\", \"distortionParams\": [\"0.9\"]"), p, 360 * x * fov + 201.5,
                     450 * y * fov + 148);
}

TEST(AliceVision, ReadsTheCamerasOfEveryVersion) {
  const std::string version = "[\"1\", \"2\", \"8\"]", type = "\"type\": \"pinhole\", \"focalLength\": \"36\"";
  const auto camera = [&](const std::string& to, const std::string& focal) {
    const std::string text =
        replaced(replaced(replaced(kSfm, version, to), type, focal), "\"type\": \"pinhole\", \"focalLength\": \"8\"",
                 "\"type\": \"equidistant\", \"focalLength\": \"8\"");
    return first_of(text).camera;
  };
  const Camera v120 = camera("[\"1\", \"1\", \"0\"]", "\"type\": \"brown\", \"pxFocalLength\": \"361.5\"");
  EXPECT_EQ(v120.fx, 361.5);
  EXPECT_EQ(v120.fy, 361.5);
  EXPECT_EQ(v120.cx, 1.5);  // from the corner's pixel in those days
  EXPECT_EQ(v120.cy, -2);
  const Camera v121 = camera("[\"1\", \"2\", \"1\"]", "\"type\": \"brown\", \"pxFocalLength\": [\"361.5\", \"362\"]");
  EXPECT_EQ(v121.fy, 362);
  EXPECT_EQ(v121.cx, 201.5);
  EXPECT_EQ(camera("[\"1\", \"2\", \"4\"]", "\"type\": \"brown\", \"focalLength\": \"36\"").fy, 288);
  EXPECT_EQ(camera("[\"1\", \"2\", \"5\"]", "\"type\": \"brown\", \"focalLength\": \"36\"").fy, 450);
  const Camera v1211 = camera("[\"1\", \"2\", \"11\"]", type);
  EXPECT_EQ(v1211.fx, 288);
  EXPECT_EQ(v1211.fy, 360);
  EXPECT_EQ(v1211.distortion.k1, -0.1);
}

TEST(AliceVision, LeavesOutWhatItDoesNotKnow) {
  const std::string type = "\"type\": \"pinhole\", \"focalLength\": \"8\"";
  const SceneFile scene = parse(replaced(kSfm, type, "\"type\": \"equidistant\""));
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_EQ(scene.warnings.at(0), "1 images are left out: their lens, 'equidistant', is not supported");
  EXPECT_EQ(
      parse(replaced(kSfm, "\"undistortionType\": \"none\", \"dis", "\"undistortionType\": \"3deanamorphic4\", \"dis"))
          .warnings.at(0),
      "1 images are left out: their lens, '3deanamorphic4', is not supported");
  EXPECT_EQ(parse(replaced(kSfm, "\"poseId\": \"5\", \"int",
                           "\"poseId\": \"5\", \"rigId\": \"1\", \"isPoseIndependant\": \"false\", \"int"))
                .warnings.at(1),
            "1 images are left out: their pose is that of a rig");
}

TEST(AliceVision, IsReadFromAFolderOfMeshroom) {
  const test::TemporaryFolder folder;
  test::write_photo(folder.path() / "images/a.jpg", 400, 300);
  test::write_photo(folder.path() / "images/b.jpg", 200, 220);
  folder.write("cameraInit.sfm", R"({"version": ["1", "2", "8"], "views": []})");
  for (const char* name : {"sfm.json", "cameras.sfm"}) {
    folder.write(name, kSfm);
    for (const auto& source : {folder.path(), folder.path() / name}) {
      if (std::string_view(name) == "sfm.json" && source == folder.path()) continue;
      const Scene scene = read_scene(source, {.whole_fisheyes = true});
      EXPECT_EQ(scene.format, "AliceVision");
      ASSERT_EQ(scene.views.size(), 2);
      EXPECT_EQ(scene.views[0].name, "a.jpg");
    }
  }
}

TEST(AliceVision, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kSfm, from, to)); });
  };
  EXPECT_TRUE(contains(error("\"focalLength\": \"36\"", "\"focalLength\": \"long\""),
                       "intrinsic 4294967295: expected a number as 'focalLength'"));
  EXPECT_TRUE(
      contains(error("\"focalLength\": \"36\"", "\"focalLength\": \"-36\""), "the focal length is not positive"));
  EXPECT_TRUE(contains(
      error("\"width\": \"400\", \"height\": \"300\", \"sen", "\"width\": \"4.5\", \"height\": \"300\", \"sen"),
      "expected a whole number of 1 to 2^24 pixels as 'width'"));
  EXPECT_TRUE(contains(error("[\"1\", \"-2.5\"]", "\"1\""), "expected 2 numbers as 'principalPoint'"));
  EXPECT_TRUE(contains(error("[\"10\", \"20\", \"100\"]", "[\"10\", \"nan\", \"100\"]"),
                       "a.jpg': the camera centre is not finite"));
  EXPECT_TRUE(contains(error("[\"1\", \"0\", \"0\", \"0\", \"-1\"", "[\"1\", \"0\", \"0\", \"0\", \"1\""),
                       "a.jpg': its rotation is none"));
  EXPECT_TRUE(contains(error("\"path\": \"D:\\/photos\\/a.jpg\", ", ""), "views: has no 'path'"));
  EXPECT_TRUE(contains(error("[\"1\", \"2\", \"8\"]", "[\"1\", \"2\"]"), "expected 3 numbers as 'version'"));
  EXPECT_TRUE(contains(input_error([] { parse("[]"); }), "expected an object with 'views'"));
}

TEST(AliceVision, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("AliceVision", kSfm, 1);
  test::expect_changes_survived("AliceVision", kSfm);
}

}  // namespace
}  // namespace gpvc::io
