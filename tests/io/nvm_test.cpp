#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// Written from the documentation: half a turn about x, so the first camera looks down from (10, 20, 100); the second, at
// the same place, looks along x, with y to the right and z down.
const std::string kHead = "NVM_V3 \r\n\r\n2\r\n";
const std::string kCameras =
    "images\\a.jpg\t360 0 2 0 0 10 20 100 -0.08 0 \r\n"
    "images/b\"c.jpg\t365.5 0.5 -0.5 -0.5 -0.5 10 20 100 0 0\r\n";
const std::string kPoints = "\r\n1\r\n0 0 0 1 2 3 2 0 0 1.5 2.5 1 0 3 4\r\n";
const std::string kNvm =
    kHead + kCameras + kPoints + "\r\n1\r\nd.jpg 300 1 0 0 0 0 0 0 0 0\r\n0\r\n\r\n0\r\n\r\n#the last part\r\n0\r\n";

SceneFile parse(const std::string& text) { return test::parse_as("NVM", text); }

/// The view of a photo of 400 x 300.
View sized(const SceneFile& scene, const char* name) {
  View view = view_named(scene, name);
  scene.size_camera(view.camera, 400, 300);
  return view;
}

TEST(Nvm, ProjectsAKnownPoint) {
  const SceneFile scene = parse(kNvm);
  ASSERT_EQ(scene.views.size(), 2);
  // The lens starts from the photo: what it shows at q lies at q (1 - 0.08 q^2).
  const double u = 0.3, v = -0.2, factor = 1 - 0.08 * (u * u + v * v), x = u * factor, y = v * factor;
  expect_photo_point(sized(scene, "images/a.jpg"), {10 + 50 * x, 20 - 50 * y, 50}, 360 * u + 200, 360 * v + 150);
  expect_photo_point(sized(scene, "images/b c.jpg"), {60, 20 + 50 * x, 100 + 50 * y}, 365.5 * x + 200, 365.5 * y + 150);
  EXPECT_EQ(view_named(scene, "images/a.jpg").pose.centre, (WorldPoint{10, 20, 100}));
}

TEST(Nvm, TakesTheLargestModel) {
  const std::string text =
      replaced(kNvm, "\r\n1\r\nd.jpg", "\r\n3\r\ne.jpg 9 1 0 0 0 0 0 0 0 0\r\nf.jpg 9 1 0 0 0 0 0 0 0 0\r\nd.jpg");
  EXPECT_EQ(parse(text).views.size(), 3);
  EXPECT_EQ(parse(text).warnings.at(0),
            "the file holds 2 models; the largest, of 3 photos, is read, the others cannot be brought into its frame");
  EXPECT_EQ(parse(kHead + kCameras).views.size(), 2);  // as programs without points write it
  EXPECT_TRUE(parse(kHead + kCameras).warnings.empty());
}

TEST(Nvm, TakesAFixedCalibration) {
  const SceneFile scene = parse(replaced(kNvm, "NVM_V3 ", "NVM_V3 FixedK 350 198 340 155 -0.05"));
  const double x = 0.3, y = -0.2, factor = 1 - 0.05 * (x * x + y * y);
  expect_photo_point(sized(scene, "images/b c.jpg"), {60, 20 + 50 * x * factor, 100 + 50 * y * factor}, 350 * x + 198,
                     340 * y + 155);
  EXPECT_EQ(view_named(scene, "images/a.jpg").camera.distortion.k1, -0.08);
  EXPECT_EQ(parse(replaced(kNvm, "NVM_V3 ", "NVM_V3 FixedK 350 198 340 155")).views[1].camera.distortion.k1, 0);
}

TEST(Nvm, TakesMatrices) {
  const SceneFile scene = parse("NVM_V3_R9T\n1\nan image.jpg 360 0 1 0 0 0 1 1 0 0 -20 -100 -10 0 0\n0\n");
  expect_photo_point(sized(scene, "an image.jpg"), {60, 20 + 50 * 0.3, 100 + 50 * -0.2}, 360 * 0.3 + 200,
                     360 * -0.2 + 150);
}

TEST(Nvm, TakesNamesBetweenQuotes) {
  const auto name = [](const std::string& written) {
    return parse(replaced(kNvm, "images\\a.jpg", written)).views.at(0).name;
  };
  EXPECT_EQ(name("\"images/batch2 1 (3).jpg\""), "images/batch2 1 (3).jpg");
  EXPECT_EQ(name("\"images/a.jpg\""), "images/a.jpg");
  EXPECT_EQ(name("images/1 (3).jpg"), "images/1 (3).jpg");
  EXPECT_EQ(name("images/a\"\"b.jpg"), "images/a  b.jpg") << "as VisualSFM writes two blanks";
}

TEST(Nvm, GetsItsPrincipalPointFromThePhotos) {
  const test::TemporaryFolder folder;
  folder.write("dense/scene.nvm", kHead + kCameras + "0\n");
  test::write_photo(folder.path() / "images/a.jpg", 400, 300);
  test::write_photo(folder.path() / "images/b c.jpg", 300, 401);
  const Scene scene = read_scene(folder.path() / "dense", {});
  EXPECT_EQ(scene.format, "NVM");
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.views[0].camera.cx, 200);
  EXPECT_EQ(scene.views[0].camera.cy, 150);
  EXPECT_EQ(scene.views[1].camera.cy, 200.5);
  EXPECT_EQ(scene.views[1].camera.width, 300);
}

TEST(Nvm, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kNvm, from, to)); });
  };
  EXPECT_TRUE(contains(error("NVM_V3", "NVM_V2"), "line 1: expected NVM_V3"));
  EXPECT_TRUE(contains(error("NVM_V3", "NVM_V3 FixedK 1 2 3"), "line 1: expected FixedK fx cx fy cy [r]"));
  EXPECT_TRUE(contains(error("2\r\nimages", "two\r\nimages"), "line 3: expected a number of cameras"));
  EXPECT_TRUE(contains(error("\t360", "\t-360"), "line 4: the focal length is not positive"));
  EXPECT_TRUE(contains(error("\t360", "\tf"), "line 4: expected the name of a photo and 10 numbers"));
  EXPECT_TRUE(contains(error("images\\a.jpg", ""), "line 4: expected the name of a photo and 10 numbers"));
  EXPECT_TRUE(contains(error("images\\a.jpg", "file:///"), "line 4: expected the name of a photo, found ''"));
  EXPECT_TRUE(contains(error("0 2 0 0", "0 0 0 0"), "line 4: the quaternion has no direction"));
  EXPECT_TRUE(contains(error("20 100 -0.08", "nan 100 -0.08"), "line 4: the camera centre is not finite"));
  EXPECT_TRUE(contains(error("\r\n1\r\n0 0 0", "\r\nmany\r\n0 0 0"), "line 7: expected a number of points"));
  EXPECT_TRUE(contains(error("\r\n1\r\n0 0 0", "\r\n100\r\n0 0 0"), "of 100 points"));
  EXPECT_TRUE(contains(input_error([] { parse("NVM_V3_R9T\n1\na.jpg 1 2 0 0 0 1 0 0 0 1 0 0 0 0 0\n"); }),
                       "line 3: the matrix is no rotation"));
}

TEST(Nvm, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("NVM", kHead + kCameras, 2);
  test::expect_changes_survived("NVM", kNvm);
}

}  // namespace
}  // namespace gpvc::io
