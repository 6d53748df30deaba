#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

constexpr const char* kFormat = "RealityCapture CSV";

const std::string kHeader = "#name,x,y,alt,yaw,pitch,roll,f_35mm,px_norm,py_norm,k1,k2,k3,k4,t1,t2\r\n";
const std::string kOlder = "#cameras 1\n#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n";
const std::string kLens = ",32.4,0.01,-2e-002,-0.1,0.02,0.03,-0.04,0.005,-0.006\r\n";
const std::string kDown = "down.jpg,10,20,100,0,0,0" + kLens;
const std::string kNoLens = ",32.4,0.01,-0.02,0,0,0,0,0,0\n";

const std::string kMatrices =
    "#name,tx,ty,tz,R00,R01,R02,R10,R11,R12,R20,R21,R22,f_pix,px_pix,py_pix,k1,k2,t2,t1,k3,k4 (R = [Rij] in row major "
    "ordering and t = (tx,ty,tz) of the pose (R,t))\n"
    "down.jpg,-10,20,100,1,0,0,0,-1,0,0,0,-1,360,204,142,-0.1,0.02,-0.006,0.005,0.03,-0.04\n";

SceneFile parse(const std::string& text) { return test::parse_as(kFormat, text); }

/// The view of a photo of 400 x 300.
View sized(const SceneFile& scene, const char* name) {
  View view = view_named(scene, name);
  scene.size_camera(view.camera, 400, 300);
  return view;
}

TEST(RealityCsv, ProjectsAKnownPointWithEveryHeader) {
  const double x = 0.3, y = -0.2, r2 = 0.13, r4 = r2 * r2;
  const double radial = 1 - 0.1 * r2 + 0.02 * r4 + 0.03 * r4 * r2 - 0.04 * r4 * r4;
  const double u = x * radial + 0.005 * (r2 + 2 * x * x) + 2 * -0.006 * x * y;
  const double v = y * radial + -0.006 * (r2 + 2 * y * y) + 2 * 0.005 * x * y;
  // At yaw, pitch and roll 0 the camera looks down, the upper edge of the photo to the north, y.
  for (const std::string& text : {kHeader + kDown, kOlder + kDown, "\xEF\xBB\xBF" + kHeader + kDown, kMatrices})
    expect_photo_point(sized(parse(text), "down.jpg"), {10 + 50 * x, 20 - 50 * y, 50}, 360 * u + 204, 360 * v + 142);
}

TEST(RealityCsv, TurnsByYawPitchAndRoll) {
  const SceneFile scene =
      parse(kHeader + "east.jpg,10,20,100,90,0,0" + kNoLens + "ahead.jpg,10,20,100,0,90,0" + kNoLens +
            "banked.jpg,10,20,100,0,0,90" + kNoLens + "both.jpg,10,20,100,90,90,0" + kNoLens);
  const double u = 360 * 0.3 + 204, v = 360 * -0.2 + 142;  // 0.3 to the right, 0.2 up
  // Yaw: the nose, and with it the photo's upper edge, from north to east; the right is south.
  expect_photo_point(sized(scene, "east.jpg"), {10 + 50 * 0.2, 20 - 50 * 0.3, 50}, u, v);
  // Pitch: the nose up; the camera that looked down looks ahead, north, with the photo upright.
  expect_photo_point(sized(scene, "ahead.jpg"), {10 + 50 * 0.3, 70, 100 + 50 * 0.2}, u, v);
  // Roll: the right wing down; the camera looks to the left, west, the photo's upper edge north and its right down.
  expect_photo_point(sized(scene, "banked.jpg"), {-40, 20 + 50 * 0.2, 100 - 50 * 0.3}, u, v);
  // Both: looks ahead, and ahead is east.
  expect_photo_point(sized(scene, "both.jpg"), {60, 20 - 50 * 0.3, 100 + 50 * 0.2}, u, v);
}

TEST(RealityCsv, AgreesWithTheMatrixOfTheSameCamera) {
  // The program's own figures for one camera in both forms, as a user published them.
  const SceneFile scene = parse(kHeader + "a.jpg,0,0,0,163.736597399311,83.4154313461628,174.386496244756" + kNoLens);
  const auto& r = scene.views.at(0).pose.rotation;
  constexpr double kMatrix[] = {0.982594073038806, 0.185426733553445,  -0.0112166890261935, -0.032113633044729,
                                0.11008102707942,  -0.993403685341366, -0.18296885582437,   0.976472781986697};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(r[i], kMatrix[i], 1e-12);
}

TEST(RealityCsv, TakesColumnsInAnyOrderAndWithoutALens) {
  const SceneFile scene = parse("#name,alt,y,x,roll,pitch,yaw,f,note\na, b.jpg,100,20,10,0,0,0,32.4,later\n");
  expect_photo_point(sized(scene, "a, b.jpg"), {10 + 50 * 0.3, 20 - 50 * 0.2, 50}, 360 * 0.3 + 200, 360 * 0.2 + 150);
}

TEST(RealityCsv, WarnsOfProjectedCoordinates) {
  EXPECT_TRUE(parse(kHeader + kDown).warnings.empty());
  const SceneFile scene = parse(kHeader + replaced(kDown, "10,20,100", "652000,6863000,100"));
  ASSERT_EQ(scene.warnings.size(), 1);
  EXPECT_TRUE(contains(scene.warnings[0], "the coordinates seem to be projected"));
}

TEST(RealityCsv, LeavesOutTheDivisionModel) {
  const std::string division = "wide.jpg,10,20,100,0,0,0,16,0,0,-0.3,0,0,0,0,0\n";
  EXPECT_TRUE(contains(input_error([&] { parse(kHeader + division); }),
                       "line 2: k1 stands alone: the lens model Division is not supported"));
  const SceneFile scene = parse(kHeader + division + kDown);
  EXPECT_EQ(scene.views.size(), 1);
  EXPECT_EQ(scene.warnings.at(0), "1 photos are left out: their lens, 'division', is not supported");
}

TEST(RealityCsv, RefusesWithLineAndExpectation) {
  const auto error = [](const std::string& text) { return input_error([&] { parse(text); }); };
  EXPECT_TRUE(contains(error("#name,x,y\n"), "line 1: expected the columns #name,x,y,alt"));
  EXPECT_TRUE(contains(error(""), "expected the columns"));
  EXPECT_TRUE(contains(error(kHeader + kDown + "b.jpg,1,2\n"), "line 3: expected 16 values, found 3"));
  EXPECT_TRUE(contains(error(kHeader + replaced(kDown, ",20,", ",nan,")),
                       "line 2: expected a finite number as y, found 'nan'"));
  EXPECT_TRUE(contains(error(kHeader + replaced(kDown, "down.jpg", "")), "line 2: expected the name of a photo"));
  EXPECT_TRUE(contains(error(kHeader + replaced(kDown, "32.4", "0")), "line 2: the focal length is not positive"));
  EXPECT_TRUE(
      contains(error(replaced(kMatrices, ",1,0,0,0,-1", ",1,0,0,0,1")), "the matrix R00 .. R22 is no rotation"));
}

TEST(RealityCsv, SurvivesCutsAndChanges) {
  // A last number cut short is a number.
  const std::string last = "0.006\r\n";
  test::expect_changes_survived(kFormat, kHeader + kDown);
  test::expect_changes_survived(kFormat, kMatrices);
  const std::string good = kHeader + kDown;
  for (std::size_t size = kHeader.size() + 1; size + last.size() < good.size(); ++size)
    EXPECT_THROW(parse(good.substr(0, size)), InputError) << size;
}

TEST(RealityCsv, IsRecognizedByItsHeader) {
  test::TemporaryFolder folder;
  folder.write("points.csv", "#name,x,y,alt\na,1,2,3\n");
  folder.write("cameras.CSV", kHeader + kDown);
  test::write_photo(folder.path() / "images/down.jpg", 400, 300);
  const Scene scene = read_scene(folder.path(), {});
  EXPECT_EQ(scene.format, "RealityCapture CSV");
  EXPECT_EQ(scene.views.at(0).camera.cy, 142);
}

}  // namespace
}  // namespace gpvc::io
