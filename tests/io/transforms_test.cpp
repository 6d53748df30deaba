#include <numbers>

#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

constexpr const char* kFormat = "transforms.json";

// Cameras above (10, 20) at height 100 that look down, written from the documentation: the first with north up in the
// photo, the others turned by a quarter, with east down.
const std::string kTransforms = R"({
  "w": 400.0, "h": 300, "fl_x": 360, "fl_y": 370, "cx": 201.5, "cy": 148, "camera_model": "OPENCV",
  "k1": -0.1, "k2": 0.02, "p1": 0.004, "p2": -0.002,
  "applied_transform": [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 3]], "applied_scale": 2,
  "frames": [
    {"file_path": "./images/p.jpg", "colmap_im_id": 1,
     "transform_matrix": [[1, 0, 0, 10], [0, 1, 0, 20], [0, 0, 1, 100], [0, 0, 0, 1]]},
    {"file_path": "images\\f.jpg", "camera_model": "OPENCV_FISHEYE", "w": 200, "h": 220, "fl_x": 80, "fl_y": 82,
     "cx": 101, "cy": 107, "k1": 0.01, "k2": -0.002, "k3": 0.003, "k4": -0.0004, "p1": 0, "p2": 0,
     "mask_path": "masks/f.png",
     "transform_matrix": [[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 100]]}
  ]
}
)";

SceneFile parse(const std::string& text) { return test::parse_as(kFormat, text); }

TEST(Transforms, ProjectsAKnownPointWithEveryLens) {
  const SceneFile scene = parse(kTransforms);
  ASSERT_EQ(scene.views.size(), 2);
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2;
  const double u = x * radial + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x);
  const double v = y * radial - 2 * 0.002 * x * y + 0.004 * (r2 + 2 * y * y);
  expect_photo_point(view_named(scene, "images/p.jpg"), {10 + 50 * x, 20 - 50 * y, 50}, 360 * u + 201.5, 370 * v + 148);
  const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
  const double bent = t * (1 + 0.01 * t2 - 0.002 * t2 * t2 + 0.003 * std::pow(t2, 3) - 0.0004 * std::pow(t2, 4)) / r;
  expect_photo_point(view_named(scene, "images/f.jpg"), {10 + 50 * y, 20 + 50 * x, 50}, 80 * x * bent + 101,
                     82 * y * bent + 107);
  EXPECT_EQ(view_named(scene, "images/f.jpg").mask, "masks/f.png");
  EXPECT_EQ(view_named(scene, "images/p.jpg").pose.centre, (WorldPoint{10, 20, 100}));
}

TEST(Transforms, TakesTermsFromAList) {
  const std::string list = "\"distortion_params\": [-0.1, 0.02, 0, 0, 0.004, -0.002], ";
  const SceneFile scene = parse(replaced(kTransforms, "\"k1\": -0.1, \"k2\": 0.02, \"p1\": 0.004, \"p2\": -0.002,",
                                         list + "\"k1\": 7, \"p1\": 8,"));
  EXPECT_EQ(view_named(scene, "images/p.jpg").camera.distortion,
            view_named(parse(kTransforms), "images/p.jpg").camera.distortion);
  EXPECT_TRUE(
      contains(input_error([&] { parse(replaced(kTransforms, "\"k1\": -0.1,", "\"distortion_params\": [1],")); }),
               "expected 6 numbers as 'distortion_params'"));
}

// Turned by 0.1 to either side about the line of sight, and moved from x = 9 to x = 11.
std::string matrix(double angle, const char* x) {
  const std::string c = std::to_string(std::cos(angle)), s = std::to_string(std::sin(angle)),
                    minus = std::to_string(-std::sin(angle));
  return "[[" + c + ", " + minus + ", 0, " + x + "], [" + s + ", " + c + ", 0, 20], [0, 0, 1, 100]]";
}
const std::string kStill = "\"transform_matrix\": [[1, 0, 0, 10], [0, 1, 0, 20], [0, 0, 1, 100], [0, 0, 0, 1]]";

SceneFile parse_moving(const std::string& shutter, double start = 0.1, const char* start_x = "9", double end = -0.1) {
  return parse(replaced(kTransforms, kStill,
                        shutter + "\"transform_matrix_start\": " + matrix(start, start_x) +
                            ", \"transform_matrix_end\": " + matrix(end, "11")));
}

TEST(Transforms, MovesCamerasWhileTheyAreReadOut) {
  const SceneFile before = parse(kTransforms), scene = parse_moving("\"rolling_shutter\": [0, 0, 1, 0], ");
  const View &expected = view_named(before, "images/p.jpg"), &view = view_named(scene, "images/p.jpg");
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(view.pose.rotation[i], expected.pose.rotation[i], 1e-6);
  EXPECT_EQ(view.pose.centre, expected.pose.centre);
  const Motion& motion = view.camera.distortion.motion;
  EXPECT_EQ(motion.across, 0);
  EXPECT_EQ(motion.down, 1);
  EXPECT_TRUE(before.warnings.empty() && scene.warnings.empty());
  EXPECT_FALSE(view_named(scene, "images/f.jpg").camera.distortion.motion.moves());
  // In the last row, half a unit of time later, it is where transform_matrix_end has it.
  const SceneFile last = parse(replaced(kTransforms, kStill, "\"transform_matrix\": " + matrix(-0.1, "11")));
  const WorldPoint p{15, 22, 40};
  const CameraPoint at_end = camera_from_world(view_named(last, "images/p.jpg").pose, p);
  CameraPoint c = camera_from_world(view.pose, p);
  c = {c.x - motion.step[0] / 2, c.y - motion.step[1] / 2, c.z - motion.step[2] / 2};
  EXPECT_NEAR(motion.turn[0], 0, 1e-12);
  EXPECT_NEAR(motion.turn[1], 0, 1e-12);
  const double turn = motion.turn[2] / 2;
  EXPECT_NEAR(std::cos(turn) * c.x - std::sin(turn) * c.y, at_end.x, 1e-4);
  EXPECT_NEAR(std::sin(turn) * c.x + std::cos(turn) * c.y, at_end.y, 1e-4);
  EXPECT_NEAR(c.z, at_end.z, 1e-9);
}

// A quarter of the way before the photo, another one of it for the middle of the exposure.
TEST(Transforms, TakesTheTimesThatRollingShutterStates) {
  const View view = view_named(parse_moving("\"rolling_shutter\": [0.25, -0.5, 0.25, 0.5], "), "images/p.jpg");
  EXPECT_NEAR(view.pose.centre.x, 9 + 2 * (0.25 + (-0.5 + 0.25 + 0.5) / 2), 1e-12);
  EXPECT_EQ(view.camera.distortion.motion.across, -0.5);
  EXPECT_EQ(view.camera.distortion.motion.down, 0.25);
  EXPECT_EQ(view_named(parse_moving("\"rolling_shutter\": [1, 0, 0], "), "images/p.jpg").pose.centre.x, 11);
  EXPECT_TRUE(contains(input_error([] { parse_moving("\"rolling_shutter\": [1, 0], "); }),
                       "expected 4 numbers as 'rolling_shutter'"));
  EXPECT_FALSE(view_named(parse_moving("\"rolling_shutter\": [0, 0, 1, 0], ", 0, "11", 0), "images/p.jpg")
                   .camera.distortion.motion.moves());
}

TEST(Transforms, TakesCamerasAtTheStartThatMoveAtNoStatedTime) {
  const SceneFile scene = parse_moving("");
  EXPECT_EQ(view_named(scene, "images/p.jpg").pose.centre.x, 9);
  EXPECT_FALSE(view_named(scene, "images/p.jpg").camera.distortion.motion.moves());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(contains(scene.warnings[0], "1 cameras moved while their photos were taken")) << scene.warnings[0];
  EXPECT_TRUE(parse_moving("", 0, "11", 0).warnings.empty());
}

TEST(Transforms, TakesAFieldOfView) {
  const std::string focal = "\"fl_x\": 360, \"fl_y\": 370, \"cx\": 201.5, \"cy\": 148";
  const auto camera = [&](const std::string& to) {
    return view_named(parse(replaced(kTransforms, focal, to)), "images/p.jpg").camera;
  };
  const Camera one = camera("\"camera_angle_x\": 1.5707963267948966");
  EXPECT_NEAR(one.fx, 200, 1e-9);
  EXPECT_NEAR(one.fy, 200, 1e-9);
  EXPECT_EQ(one.cx, 200);
  EXPECT_EQ(one.cy, 150);
  EXPECT_NEAR(camera("\"camera_angle_x\": 1, \"camera_angle_y\": 1.5707963267948966").fy, 150, 1e-9);
  EXPECT_EQ(camera("\"fl_x\": 360").fy, 360);
}

TEST(Transforms, TakesFisheyeOfInstantNgp) {
  const std::string named = "\"camera_model\": \"OPENCV\"";
  EXPECT_EQ(parse(replaced(kTransforms, named, "\"is_fisheye\": true")).views[0].camera.distortion.model,
            LensModel::equidistant);
  EXPECT_EQ(parse(replaced(kTransforms, named, "\"is_fisheye\": false")).views[0].camera.distortion.model,
            LensModel::brown);
}

// The point (5, 6, 7) of the original world is 2 (5, 7, -6 + 3) in the poses' world.
TEST(Transforms, KnowsTheOriginalWorld) {
  const SceneFile scene = parse(kTransforms);
  ASSERT_EQ(scene.other_frames.size(), 1);
  const auto& [name, r, origin, scale, srs] = scene.other_frames[0];
  const double x = 10 - origin.x, y = 14 - origin.y, z = -6 - origin.z;
  EXPECT_NEAR(scale * (r[0] * x + r[1] * y + r[2] * z), 5, 1e-12);
  EXPECT_NEAR(scale * (r[3] * x + r[4] * y + r[5] * z), 6, 1e-12);
  EXPECT_NEAR(scale * (r[6] * x + r[7] * y + r[8] * z), 7, 1e-12);
  const std::string without =
      replaced(kTransforms, "[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 3]", "[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]");
  EXPECT_EQ(parse(without).other_frames.size(), 1);
  EXPECT_TRUE(parse(replaced(without, ", \"applied_scale\": 2", "")).other_frames.empty());
}

// Files of nerfstudio before it stated applied_transform; it swapped x and y of COLMAP's world and turned z over.
TEST(Transforms, KnowsColmapsWorldWhereTheFileDoesNotStateIt) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "transforms.json";
  const std::string text = replaced(
      kTransforms, "\"applied_transform\": [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 3]], \"applied_scale\": 2,", "");
  const auto frames = [&] { return test::format_named(kFormat).parse(file, text).other_frames; };
  EXPECT_TRUE(frames().empty());
  folder.write("colmap/sparse/0/cameras.bin", "");
  ASSERT_EQ(frames().size(), 1u);
  EXPECT_EQ(frames()[0].rotation, (std::array<double, 9>{0, 1, 0, 1, 0, 0, 0, 0, -1}));
}

TEST(Transforms, KnowsTheCoordinatesOfATraining) {
  const test::TemporaryFolder folder;
  folder.write("data/transforms.json", kTransforms);
  const auto stated =
      folder.write("mesh/dataparser_transforms.json",
                   R"({"transform": [[0, 1, 0, 3], [-0.6, 0, 0.8, -2], [0.8, 0, 0.6, 1]], "scale": 0.5})");
  Scene scene = read_scene(folder.path() / "data", {.allow_missing_photos = true, .whole_fisheyes = true});
  const std::vector<SceneFrame> frames = read_parser_frames(scene, folder.path() / "mesh/mesh.ply");
  ASSERT_EQ(frames.size(), 2u);  // from the poses' world and from the one before applied_transform
  const auto taken = [](const SceneFrame& frame, const WorldPoint& p) {
    const WorldPoint moved =
        product(frame.rotation, WorldPoint{p.x - frame.origin.x, p.y - frame.origin.y, p.z - frame.origin.z});
    return WorldPoint{frame.scale * moved.x, frame.scale * moved.y, frame.scale * moved.z};
  };
  const auto expect_taken = [&](const SceneFrame& frame, const WorldPoint& from, const WorldPoint& p) {
    const WorldPoint to = taken(frame, from);
    EXPECT_NEAR(to.x, 0.5 * (p.y + 3), 1e-12);
    EXPECT_NEAR(to.y, 0.5 * (-0.6 * p.x + 0.8 * p.z - 2), 1e-12);
    EXPECT_NEAR(to.z, 0.5 * (0.8 * p.x + 0.6 * p.z + 1), 1e-12);
  };
  expect_taken(frames[0], {5, 6, 7}, {5, 6, 7});
  expect_taken(frames[1], {10, 14, -6}, {5, 6, 7});  // as KnowsTheOriginalWorld has it
  EXPECT_TRUE(contains(frames[0].name, stated.string()));
  EXPECT_TRUE(read_parser_frames(scene, folder.path() / "other/mesh.ply").empty());
  folder.write("data/dataparser_transforms.json",
               R"({"transform": [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 1, 0]], "scale": 1})");
  EXPECT_TRUE(contains(input_error([&] { read_parser_frames(scene, "other/mesh.ply"); }),
                       "dataparser_transforms.json: 'transform' has no rotation in it"));
  folder.write("data/dataparser_transforms.json",
               R"({"transform": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], "scale": 0})");
  EXPECT_TRUE(contains(input_error([&] { read_parser_frames(scene, "other/mesh.ply"); }),
                       "expected a positive number as 'scale'"));
}

TEST(Transforms, LeavesOutFramesOfLensesItDoesNotKnow) {
  const SceneFile scene = parse(replaced(kTransforms, "OPENCV_FISHEYE", "VR180_L"));
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_EQ(scene.warnings.at(0), "1 frames are left out: their lens, 'VR180_L', is not supported");
  EXPECT_TRUE(contains(
      input_error([&] { parse(replaced(kTransforms, "\"w\": 400.0", "\"orthographic\": true, \"w\": 400.0")); }),
      "'orthographic' is not supported"));
}

TEST(Transforms, TakesPanoramas) {
  const std::string fisheye =
      "\"OPENCV_FISHEYE\", \"w\": 200, \"h\": 220, \"fl_x\": 80, \"fl_y\": 82,\n     \"cx\": 101, \"cy\": 107,";
  const auto with = [&](const std::string& other) {
    return view_named(parse(replaced(kTransforms, fisheye, other)), "images/f.jpg");
  };
  const View view =
      with("\"EQUIRECTANGULAR\", \"w\": 200, \"h\": 100, \"fl_x\": 100, \"fl_y\": 90, \"cx\": 100.5, \"cy\": 50,");
  Camera expected = test::panorama_of(200, 100, 90 / std::numbers::pi);
  expected.cx = 100.5;
  EXPECT_EQ(view.camera, expected);
  EXPECT_EQ(with("\"\", \"latlong\": true, \"w\": 200, \"h\": 100,").camera,
            test::panorama_of(200, 100, 100 / std::numbers::pi));
  // Looks down, with east down in the photo; on the equator half a turn is 100 pixels.
  expect_photo_point(view, {10, 20, 50}, 100.5, 50);
  expect_photo_point(view, {10 + 50 * std::tan(0.2), 20, 50}, 100.5, 50 + 0.2 * 90 / std::numbers::pi);
  expect_photo_point(view, {10, 20 + 50 * std::tan(0.3), 50}, 100.5 + 0.3 * 100 / std::numbers::pi, 50);
  EXPECT_TRUE(
      contains(input_error([&] { with("\"EQUIRECTANGULAR\", \"w\": 200, \"h\": 100, \"fl_x\": 80,"); }),
               "frame 'images/f.jpg': expected half the photo's width, 100, as 'fl_x' of EQUIRECTANGULAR, found 80"));
  EXPECT_TRUE(
      contains(input_error([&] { with("\"EQUIRECTANGULAR\", \"w\": 200, \"h\": 100, \"fl_x\": 100, \"cx\": 50,"); }),
               "frame 'images/f.jpg': expected the principal point of a panorama in its middle"));
}

class NerfFolder {
 public:
  NerfFolder() {
    folder.write("transforms.json", kTransforms);
    test::write_photo(folder.path() / "images/p.jpg", 400, 300);
    test::write_photo(folder.path() / "images/f.jpg", 200, 220);
  }
  void write_colmap(const std::string& below) {
    folder.write(below + "/cameras.txt", "1 PINHOLE 400 300 360 360 200 150\n");
    folder.write(below + "/images.txt", "1 1 0 0 0 0 0 0 1 p.jpg\n\n");
  }
  test::TemporaryFolder folder;
};

TEST(Transforms, IsReadFromADataSetOfNerfstudio) {
  NerfFolder data;
  data.write_colmap("colmap/sparse/0");  // what the data set was made from
  const auto root = data.folder.path();
  for (const auto& source : {root, root / "transforms.json"}) {
    const Scene scene = read_scene(source, {.whole_fisheyes = true});
    EXPECT_EQ(scene.format, kFormat);
    ASSERT_EQ(scene.views.size(), 2);
    EXPECT_EQ(scene.views[0].name, "images/f.jpg");
    EXPECT_EQ(scene.views[1].photo, root / "./images/p.jpg");
  }
  data.write_colmap("sparse/0");
  EXPECT_TRUE(contains(input_error([&] { read_scene(root, {}); }), "name the one that is meant"));
  EXPECT_EQ(read_scene(root / "transforms.json", {.whole_fisheyes = true}).views.size(), 2);
}

TEST(Transforms, FindsPhotosOfNerfsOwnScenes) {
  const test::TemporaryFolder folder;
  folder.write("transforms_train.json",
               R"({"camera_angle_x": 1.5707963267948966, "frames": [{"file_path": "./train/r_0",
    "rotation": 0.1, "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]})");
  test::write_photo(folder.path() / "train/r_0.png", 80, 60);
  test::write_photo(folder.path() / "test/r_0.png", 80, 60);
  const Scene scene = read_scene(folder.path(), {});
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_EQ(scene.views[0].name, "train/r_0.png");
  const Camera& camera = scene.views[0].camera;
  EXPECT_NEAR(camera.fx, 40, 1e-9);
  EXPECT_NEAR(camera.fy, 40, 1e-9);
  EXPECT_EQ(camera.cx, 40);
  EXPECT_EQ(camera.cy, 30);
}

// instant-ngp's fox, for one, lists photos that were deleted as blurred.
TEST(Transforms, LeavesOutPhotosThatInstantNgpDeleted) {
  NerfFolder data;
  const auto file = data.folder.path() / "transforms.json";
  std::filesystem::remove(data.folder.path() / "images/f.jpg");
  EXPECT_TRUE(contains(input_error([&] { read_scene(file, {}); }), "1 of 2 photos are not in"));
  data.folder.write("transforms.json", replaced(kTransforms, "\"colmap_im_id\": 1", "\"sharpness\": 31.75"));
  const Scene scene = read_scene(file, {});
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_EQ(scene.views[0].name, "images/p.jpg");
  EXPECT_TRUE(contains(scene.warnings.at(0), "1 frames are left out: their photos are not there"));
  std::filesystem::remove(data.folder.path() / "images/p.jpg");  // moved elsewhere, rather
  EXPECT_TRUE(contains(input_error([&] { read_scene(file, {}); }), "2 of 2 photos are not in"));
}

TEST(Transforms, IsNotTakenForOtherJson) {
  const test::TemporaryFolder folder;
  for (const char* text : {"[{\"frames\": 1}]", "{\"views\": {\"frames\": 1}}", "{", "\"frames\""}) {
    folder.write("transforms.json", text);
    EXPECT_FALSE(test::format_named(kFormat).find(folder.path())) << text;
  }
  folder.write("transforms.json", "{\"a\": [[1], {\"b\": 2}], \"frames\": [");
  EXPECT_TRUE(test::format_named(kFormat).find(folder.path()));
}

TEST(Transforms, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kTransforms, from, to)); });
  };
  EXPECT_TRUE(contains(error("images/p.jpg", "images/."), "expected the name of a photo, found 'images/'"));
  EXPECT_TRUE(contains(error("\"w\": 400.0, ", ""), "frame 'images/p.jpg': has no 'w'"));
  EXPECT_TRUE(contains(error("\"w\": 400.0", "\"w\": 400.5"), "expected a whole number of 1 to 2^24 pixels as 'w'"));
  EXPECT_TRUE(contains(error("\"fl_x\": 360, ", ""), "has neither 'fl_x' nor 'camera_angle_x'"));
  EXPECT_TRUE(contains(error("\"fl_x\": 360", "\"fl_x\": -1"), "the focal length is not positive"));
  EXPECT_TRUE(contains(error("\"k1\": -0.1", "\"k1\": \"-0.1\""), "expected a number as 'k1'"));
  EXPECT_TRUE(contains(error("[1, 0, 0, 10]", "[1, 0, 10]"), "expected 4 rows of 4 numbers as 'transform_matrix'"));
  EXPECT_TRUE(contains(error("[1, 0, 0, 10]", "[2, 0, 0, 10]"), "its transform_matrix has no rotation in it"));
  EXPECT_TRUE(contains(error("[1, 0, 0, 10]", "[-1, 0, 0, 10]"), "its transform_matrix has no rotation in it"));
  EXPECT_TRUE(contains(error("\"file_path\": \"./images/p.jpg\", ", ""), "frame 0: has no 'file_path'"));
  EXPECT_TRUE(contains(error("[0, -1, 0, 3]", "[0, 1, 0, 3]"), "'applied_transform' has no rotation in it"));
  EXPECT_TRUE(contains(error("\"applied_scale\": 2", "\"applied_scale\": 0"), "expected a positive number"));
  EXPECT_TRUE(contains(input_error([] { parse("{}"); }), "has no 'frames'"));
  EXPECT_TRUE(contains(input_error([] { parse("[]"); }), "expected an object with a list 'frames'"));
  EXPECT_TRUE(contains(input_error([] { parse("{\"frames\": 3}"); }), "expected a list as 'frames'"));
  EXPECT_TRUE(contains(input_error([] { parse("{\"frames\": [3]}"); }), "frames 0: expected an object"));
}

TEST(Transforms, SurvivesCutsAndChanges) {
  test::expect_cuts_refused(kFormat, kTransforms, 1);
  test::expect_changes_survived(kFormat, kTransforms);
}

}  // namespace
}  // namespace gpvc::io
