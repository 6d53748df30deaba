#include <numbers>

#include "io/lens/spherical.h"
#include "io/scene_files.h"
#include "io/scenes/panorama_views.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// As OpenMVG writes it, with its wrappers, by hand: the first camera looks down from (10, 20, 100); the second, at the
// same place, looks along x, with y to the right and z down.
const std::string kOpenmvg = R"({
 "sfm_data_version": "0.3", "root_path": "images",
 "views": [
  {"key": 0, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483649, "data": {
    "local_path": "sub\\", "filename": "a.jpg", "width": 400, "height": 300,
    "id_view": 0, "id_intrinsic": 7, "id_pose": 4}}}},
  {"key": 1, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483650, "data": {
    "local_path": "", "filename": "b.jpg", "width": 200, "height": 220,
    "id_view": 1, "id_intrinsic": 8, "id_pose": 5}}}},
  {"key": 2, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483651, "data": {
    "local_path": "", "filename": "lost.jpg", "width": 200, "height": 220,
    "id_view": 2, "id_intrinsic": 8, "id_pose": 4294967295}}}}
 ],
 "intrinsics": [
  {"key": 7, "value": {"polymorphic_id": 2147483649, "polymorphic_name": "pinhole_brown_t2", "ptr_wrapper": {
    "id": 2147483652, "data": {"width": 400, "height": 300, "focal_length": 360,
    "principal_point": [201, 147.5], "disto_t2": [-0.1, 0.02, 0.003, 0.004, -0.002]}}}},
  {"key": 8, "value": {"polymorphic_id": 2147483650, "polymorphic_name": "fisheye", "ptr_wrapper": {
    "id": 2147483653, "data": {"width": 200, "height": 220, "focal_length": 80,
    "principal_point": [100.5, 106.5], "fisheye": [0.01, -0.002, 0.003, -0.0004]}}}}
 ],
 "extrinsics": [
  {"key": 4, "value": {"rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "center": [10, 20, 100]}},
  {"key": 5, "value": {"rotation": [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "center": [10, 20, 100]}}
 ],
 "structure": [{"key": 0, "value": {"X": [0, 0, 0], "observations": []}}], "control_points": []
}
)";

SceneFile parse(const std::string& text) { return test::parse_as("OpenMVG", text); }

// A principal point of (201, 147.5) from the first pixel's centre is (201.5, 148) from its corner.
TEST(OpenMvg, ProjectsAKnownPointWithEveryLens) {
  const SceneFile scene = parse(kOpenmvg);
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.warnings.at(0), "1 images without a pose are left out");
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2;
  const WorldPoint p{10 + 50 * x, 20 - 50 * y, 50};
  const double brown = radial + 0.003 * r2 * r2 * r2;
  expect_photo_point(view_named(scene, "sub/a.jpg"), p,
                     360 * (x * brown + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x)) + 201.5,
                     360 * (y * brown - 2 * 0.002 * x * y + 0.004 * (r2 + 2 * y * y)) + 148);
  const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
  const double bent = t * (1 + 0.01 * t2 - 0.002 * t2 * t2 + 0.003 * std::pow(t2, 3) - 0.0004 * std::pow(t2, 4)) / r;
  expect_photo_point(view_named(scene, "b.jpg"), {60, 20 + 50 * x, 100 + 50 * y}, 80 * x * bent + 101,
                     80 * y * bent + 107);
  const std::string terms = "\"disto_t2\": [-0.1, 0.02, 0.003, 0.004, -0.002]";
  const auto with = [&](const std::string& other) {
    return view_named(parse(replaced(kOpenmvg, terms, other)), "sub/a.jpg");
  };
  expect_photo_point(with("\"disto_k3\": [-0.1, 0.02, 0.003]"), p, 360 * x * brown + 201.5, 360 * y * brown + 148);
  expect_photo_point(with("\"disto_k1\": [-0.1]"), p, 360 * x * (1 - 0.1 * r2) + 201.5, 360 * y * (1 - 0.1 * r2) + 148);
  expect_photo_point(with("\"x\": 0"), p, 360 * x + 201.5, 360 * y + 148);
}

TEST(OpenMvg, TakesWrappedMembersOfThePinhole) {
  const std::string before =
      "\"width\": 400, \"height\": 300, \"focal_length\": 360,\n    \"principal_point\": [201, 147.5]";
  const Camera camera =
      view_named(parse(replaced(kOpenmvg, before, "\"value0\": {" + before + "}")), "sub/a.jpg").camera;
  EXPECT_EQ(camera, view_named(parse(kOpenmvg), "sub/a.jpg").camera);
}

// The centre of the first pixel of 200 x 100 is longitude -180 degrees, latitude 90 degrees, as OpenMVG has it.
TEST(OpenMvg, TakesSphericalPhotos) {
  const std::string pinhole = "\"width\": 200, \"height\": 220, \"focal_length\": 80,",
                    sphere = "\"value0\": {\"width\": 200, \"height\": 100},";
  const View whole = view_named(parse(replaced(kOpenmvg, pinhole, sphere)), "b.jpg");
  Camera expected = test::panorama_of(200, 100, 200 / (2 * std::numbers::pi));
  expected.cx = 100.5;
  expected.cy = 50.5;
  EXPECT_EQ(whole.camera, expected);
  // 30 degrees to the right and 20 down of the way it looks, x
  const double longitude = std::numbers::pi / 6, latitude = std::numbers::pi / 9;
  const WorldPoint p{10 + 50 * std::cos(latitude) * std::cos(longitude),
                     20 + 50 * std::cos(latitude) * std::sin(longitude), 100 + 50 * std::sin(latitude)};
  int shown = 0;
  for (const View& view : views_of(whole)) {
    const CameraPoint at = camera_from_world(view.pose, p);
    if (!(at.z > 0)) continue;
    const PixelPoint pixel = pixel_from_camera(view.camera, at);
    if (!in_photo(view.camera, pixel)) continue;
    const PhotoPoint photo = *photo_from_pixel(view.camera, pixel);
    EXPECT_NEAR(photo.x - columns_before(200), 100 + 200.0 / 12 + 0.5, 1e-9) << view.name;
    EXPECT_NEAR(photo.y, 50 + 200.0 / 18 + 0.5, 1e-9) << view.name;
    ++shown;
  }
  EXPECT_GE(shown, 1);
  EXPECT_TRUE(contains(input_error([&] { parse(replaced(kOpenmvg, "\"focal_length\": 80,", "")); }),
                       "intrinsics 8: has no focal length, and is not as wide as a spherical photo"));
}

TEST(OpenMvg, FindsPhotosBelowItsRootAndElsewhere) {
  const test::TemporaryFolder folder;
  test::write_photo(folder.path() / "images/sub/a.jpg", 400, 300);
  test::write_photo(folder.path() / "images/b.jpg", 200, 220);
  for (const char* root : {"images", "/home/somebody/images", ""}) {
    folder.write("sfm_data.json",
                 replaced(kOpenmvg, "\"root_path\": \"images\"", "\"root_path\": \"" + std::string(root) + "\""));
    const Scene scene = read_scene(folder.path(), {.whole_fisheyes = true});
    EXPECT_EQ(scene.format, "OpenMVG");
    ASSERT_EQ(scene.views.size(), 2);
    EXPECT_EQ(scene.views[1].name, "sub/a.jpg");
    EXPECT_TRUE(std::filesystem::equivalent(scene.views[1].photo, folder.path() / "images/sub/a.jpg"));
  }
}

TEST(OpenMvg, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kOpenmvg, from, to)); });
  };
  EXPECT_TRUE(contains(error("\"focal_length\": 360", "\"focal_length\": \"360\""),
                       "intrinsics 7: expected a number as 'focal_length'"));
  EXPECT_TRUE(contains(error("\"focal_length\": 360", "\"focal_length\": 0"),
                       "intrinsics 7: the focal length is not positive"));
  EXPECT_TRUE(contains(error("0.004, -0.002]", "0.004]"), "expected 5 numbers as 'disto_t2'"));
  EXPECT_TRUE(contains(error("[201, 147.5]", "201"), "expected 2 numbers as 'principal_point'"));
  EXPECT_TRUE(contains(error("[0, -1, 0]", "[0, 1, 0]"), "extrinsics 4: its rotation is none"));
  EXPECT_TRUE(contains(error("[0, -1, 0]", "[0, -1]"), "extrinsics 4: expected 3 rows of 3 numbers as 'rotation'"));
  EXPECT_TRUE(contains(error("\"filename\": \"a.jpg\", ", ""), "views 0: has no 'filename'"));
  EXPECT_TRUE(contains(error("\"ptr_wrapper\": {\"id\": 2147483649, \"data\"", "\"ptr_wrapper\": {\"id\": 1, \"date\""),
                       "views 0: has no 'data'"));
  EXPECT_TRUE(contains(error("\"key\": 4, \"value\"", "\"key\": 4, \"pose\""), "extrinsics 4: has no 'value'"));
  EXPECT_TRUE(contains(error("\"extrinsics\"", "\"poses\""), "has no 'extrinsics'"));
  EXPECT_TRUE(contains(input_error([] { parse("[]"); }), "expected an object with 'views'"));
}

TEST(OpenMvg, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("OpenMVG", kOpenmvg, 1);
  test::expect_changes_survived("OpenMVG", kOpenmvg);
}

}  // namespace
}  // namespace gpvc::io
