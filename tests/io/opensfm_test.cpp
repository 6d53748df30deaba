#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// One camera of each kind. Rotation: half a turn about x, the camera looks down; written from the documentation.
const std::string kReconstruction = R"([
 {"cameras": {"few": {"projection_type": "spherical", "width": 8, "height": 4}},
  "shots": {"lone.jpg": {"camera": "few", "rotation": [0, 0, 0], "translation": [0, 0, 0]}}, "points": {}},
 {
  "cameras": {
   "p": {"projection_type": "perspective", "width": 400, "height": 300, "focal": 0.9, "k1": -0.1, "k2": 0.02},
   "b": {"projection_type": "brown", "width": 300, "height": 400, "focal_x": 0.9, "focal_y": 0.91,
         "c_x": 0.01, "c_y": -0.02, "k1": -0.1, "k2": 0.02, "k3": 0.003, "p1": 0.004, "p2": -0.002},
   "f": {"projection_type": "fisheye", "width": 400, "height": 400, "focal": 0.4, "k1": 0.01, "k2": -0.002},
   "o": {"projection_type": "fisheye_opencv", "width": 400, "height": 400, "focal_x": 0.4, "focal_y": 0.41,
         "c_x": 0.01, "c_y": 0, "k1": 0.01, "k2": -0.002, "k3": 0.003, "k4": -0.0004},
   "unused": {"projection_type": "dual"}
  },
  "reference_lla": {"latitude": 46.5, "longitude": 8.25, "altitude": 600.5},
  "shots": {
   "p.jpg": {"camera": "p", "rotation": [3.141592653589793, 0, 0], "translation": [-10, 20, 100]},
   "b c.jpg": {"camera": "b", "rotation": [3.141592653589793, 0, 0], "translation": [-10, 20, 100]},
   "f.jpg": {"camera": "f", "rotation": [3.141592653589793, 0, 0], "translation": [-10, 20, 100]},
   "o.jpg": {"camera": "o", "rotation": [3.141592653589793, 0, 0], "translation": [-10, 20, 100]},
   "lost.jpg": {"camera": "p"}
  },
  "points": {"0": {"coordinates": [0, 0, 0], "color": [1, 2, 3]}}
 }
]
)";

SceneFile parse(const std::string& text) { return test::parse_as("OpenSfM", text); }

/// x_camera = (X, -Y, -Z) + (-10, 20, 100): the camera hangs at (10, 20, 100).
WorldPoint world_of(double x, double y) { return {10 + 50 * x, 20 - 50 * y, 50}; }

TEST(OpenSfm, ProjectsAKnownPointWithEveryLens) {
  const SceneFile scene = parse(kReconstruction);
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2;
  expect_photo_point(view_named(scene, "p.jpg"), world_of(x, y), 400 * 0.9 * x * radial + 200,
                     400 * 0.9 * y * radial + 150);
  const double more = radial + 0.003 * r2 * r2 * r2;
  const double u = x * more + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x);
  const double v = y * more + 2 * -0.002 * x * y + 0.004 * (r2 + 2 * y * y);
  expect_photo_point(view_named(scene, "b c.jpg"), world_of(x, y), 400 * (0.9 * u + 0.01) + 150,
                     400 * (0.91 * v - 0.02) + 200);
  const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
  const double bent = t * (1 + 0.01 * t2 - 0.002 * t2 * t2) / r;
  expect_photo_point(view_named(scene, "f.jpg"), world_of(x, y), 400 * 0.4 * x * bent + 200,
                     400 * 0.4 * y * bent + 200);
  const double opencv = bent + t * (0.003 * t2 * t2 * t2 - 0.0004 * t2 * t2 * t2 * t2) / r;
  expect_photo_point(view_named(scene, "o.jpg"), world_of(x, y), 400 * (0.4 * x * opencv + 0.01) + 200,
                     400 * 0.41 * y * opencv + 200);
}

// theta = atan(r), the point (x, y) theta / r, and all terms on that point.
TEST(OpenSfm, ProjectsAKnownPointWithSixRadialTerms) {
  const std::string two = "\"fisheye_opencv\"", k4 = "\"k4\": -0.0004";
  const std::string more = k4 + R"(, "k5": 0.03, "k6": -0.05, "p1": 0.004, "p2": -0.002, "s0": 0.006,
     "s1": -0.03, "s2": 0.011, "s3": 0.02)";
  const double x = 0.3, y = -0.2, r = std::hypot(x, y), theta = std::atan(r);
  const double u = x * theta / r, v = y * theta / r, t = theta * theta;
  const double radial = 1 + 0.01 * t - 0.002 * std::pow(t, 2) + 0.003 * std::pow(t, 3) - 0.0004 * std::pow(t, 4) +
                        0.03 * std::pow(t, 5) - 0.05 * std::pow(t, 6);
  const double eight_u = u * radial + 2 * 0.004 * u * v - 0.002 * (t + 2 * u * u);
  const double eight_v = v * radial - 2 * 0.002 * u * v + 0.004 * (t + 2 * v * v);
  // What OpenSfM's own functions give for this point.
  EXPECT_NEAR(400 * (0.4 * eight_u + 0.01) + 200, 249.9605370380, 1e-9);
  EXPECT_NEAR(400 * 0.41 * eight_v + 200, 168.6460030253, 1e-9);
  const auto expect = [&](const char* type, double px, double py) {
    const std::string text = replaced(replaced(kReconstruction, two, type), k4, more);
    expect_photo_point(view_named(parse(text), "o.jpg"), world_of(x, y), 400 * (0.4 * px + 0.01) + 200,
                       400 * 0.41 * py + 200);
  };
  expect("\"fisheye62\"", eight_u, eight_v);
  expect("\"fisheye624\"", eight_u + 0.006 * t - 0.03 * t * t, eight_v + 0.011 * t + 0.02 * t * t);
}

TEST(OpenSfm, TakesTermsThatAreNotStatedAsZero) {
  const std::string lens =
                        "\"c_x\": 0.01, \"c_y\": -0.02, \"k1\": -0.1, \"k2\": 0.02, \"k3\": 0.003, \"p1\": 0.004, "
                        "\"p2\": -0.002",
                    text = replaced(replaced(kReconstruction, ",\n         " + lens, ""),
                                    "\"projection_type\": \"perspective\", ", "");
  const SceneFile scene = parse(replaced(text, ", \"k1\": -0.1, \"k2\": 0.02", ""));
  for (const char* name : {"p.jpg", "b c.jpg"}) {
    const Camera& camera = view_named(scene, name).camera;
    EXPECT_TRUE(camera.distortion.is_identity()) << name;
    EXPECT_EQ(camera.cx, camera.width / 2.0);
    EXPECT_EQ(camera.cy, camera.height / 2.0);
  }
}

TEST(OpenSfm, TakesTheLargestReconstruction) {
  const SceneFile scene = parse(kReconstruction);
  EXPECT_EQ(scene.views.size(), 4);
  ASSERT_EQ(scene.warnings.size(), 2);
  EXPECT_TRUE(contains(scene.warnings[0], "2 reconstructions"));
  EXPECT_TRUE(contains(scene.warnings[1], "1 shots without a pose"));
  EXPECT_EQ(scene.srs, "ENU:46.5,8.25");
  EXPECT_EQ(scene.offset, (WorldPoint{0, 0, 600.5}));
}

TEST(OpenSfm, LeavesOutShotsOfLensesItDoesNotKnow) {
  const std::string dual = replaced(kReconstruction, "\"brown\"", "\"dual\"");
  const SceneFile scene = parse(replaced(dual, "\"fisheye_opencv\"", "\"cylindrical\""));
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(view_named(scene, "p.jpg").camera.width, 400);
  EXPECT_EQ(scene.warnings.at(1), "2 images are left out: their lenses, 'cylindrical', 'dual', are not supported");
}

// One that shows less than all latitudes has as many pixels a radian downwards as across.
TEST(OpenSfm, ReadsPanoramas) {
  for (const char* type : {"\"spherical\"", "\"equirectangular\""}) {
    const SceneFile scene = parse(replaced(kReconstruction, "\"perspective\"", type));
    const Camera& camera = view_named(scene, "p.jpg").camera;
    EXPECT_EQ(camera, test::panorama_of(camera.width, camera.height, camera.width / (2 * std::numbers::pi)));
  }
}

TEST(OpenSfm, TurnsBySmallAndZeroAngles) {
  const std::string half = "[3.141592653589793, 0, 0], \"translation\": [-10, 20, 100]";
  for (const double angle : {0.0, 1e-300, 1e-9, 0.5}) {
    char text[80];
    std::snprintf(text, sizeof text, "[0, 0, %.17g], \"translation\": [0, 0, 0]", angle);
    const auto r = view_named(parse(replaced(kReconstruction, half, text)), "p.jpg").pose.rotation;
    EXPECT_NEAR(r[0], std::cos(angle), 1e-15);
    EXPECT_NEAR(r[1], -std::sin(angle), 1e-15);
    EXPECT_NEAR(r[3], std::sin(angle), 1e-15);
  }
}

class OdmProject {
 public:
  explicit OdmProject(const std::string& reconstruction = kReconstruction) {
    folder.write("opensfm/reconstruction.json", reconstruction);
    test::write_photo(folder.path() / "images/p.jpg", 400, 300);
    test::write_photo(folder.path() / "images/b c.jpg", 300, 400);
    test::write_photo(folder.path() / "images/f.jpg", 400, 400);
    test::write_photo(folder.path() / "images/o.jpg", 400, 400);
  }
  test::TemporaryFolder folder;
};

TEST(OpenSfm, ReadsAnOpenDroneMapProject) {
  const OdmProject project;
  const auto root = project.folder.path();
  for (const auto& source : {root, root / "opensfm", root / "opensfm/reconstruction.json"}) {
    const Scene scene = read_scene(source, {.whole_fisheyes = true});
    EXPECT_EQ(scene.views.size(), 4) << source;
    EXPECT_EQ(scene.format, "OpenSfM");
    EXPECT_EQ(scene.srs, "ENU:46.5,8.25");
  }
  // With the topocentric model kept aside, the one read is in UTM less an offset.
  project.folder.write("opensfm/reconstruction.topocentric.json", "[]");
  EXPECT_TRUE(contains(read_scene(root, {}).warnings.back(), "coords.txt is missing"));
  project.folder.write("odm_georeferencing/coords.txt", "WGS84 UTM 32N\n567000 5150000\n");
  EXPECT_EQ(read_scene(root, {}).srs, "EPSG:32632");
  EXPECT_EQ(read_scene(root, {}).offset, (WorldPoint{567000, 5150000, 0}));
  project.folder.write("odm_georeferencing/proj.txt", "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs");
  EXPECT_EQ(read_scene(root, {}).srs, "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs");
  project.folder.write("odm_georeferencing/coords.txt", "WGS84 UTM 32N\n567000 north\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(root, {}); }), "coords.txt: line 2: expected easting"));
}

TEST(OpenSfm, TakesTheOffsetOfARunWithoutCoords) {
  for (const std::string folder : {"odm_georeferencing/", "odm_georeferencing_25d/"}) {
    const OdmProject project;
    project.folder.write("opensfm/reconstruction.topocentric.json", "[]");
    project.folder.write(folder + "odm_georeferencing_model_geo.txt", "WGS84 UTM 18S\n717623 8278698\n");
    const Scene scene = read_scene(project.folder.path(), {});
    EXPECT_EQ(scene.srs, "EPSG:32718") << folder;
    EXPECT_EQ(scene.offset, (WorldPoint{717623, 8278698, 0})) << folder;
  }
}

TEST(OpenSfm, KeepsTheNameOfASystemThatIsNoUtmZone) {
  const OdmProject project;
  project.folder.write("opensfm/reconstruction.topocentric.json", "[]");
  for (const std::string name : {"WGS84 UTM 61N", "WGS84 UTM 32", "ETRS89 / LAEA", "WGS84 UTM N"}) {
    project.folder.write("odm_georeferencing/coords.txt", name + "\n1 2\n");
    EXPECT_EQ(read_scene(project.folder.path(), {}).srs, name);
  }
}

// The photos beside the data set are not those of undistorted cameras: textured from them, a scene is off by tens of pixels.
TEST(OpenSfm, TakesNoDistortedPhotoForAnUndistortedCamera) {
  const OdmProject project;
  project.folder.write("opensfm/undistorted/reconstruction.json", kReconstruction);
  const auto undistorted = project.folder.path() / "opensfm/undistorted";
  const std::string error = input_error([&] { read_scene(undistorted, {}); });
  EXPECT_TRUE(contains(error, "the folder of the photos was not found")) << error;
  EXPECT_TRUE(contains(error, "undistorted/images")) << error;
}

TEST(OpenSfm, KnowsWhereUndistortedPhotosOfOpenDroneMapAre) {
  const OdmProject project;
  const auto undistorted = project.folder.path() / "opensfm/undistorted";
  project.folder.write("opensfm/undistorted/reconstruction.json", kReconstruction);
  SceneOptions options;
  options.images_dir = project.folder.path() / "images";
  EXPECT_EQ(read_scene(undistorted, options).srs, "ENU:46.5,8.25");
  project.folder.write("opensfm/reconstruction.topocentric.json", "[]");
  project.folder.write("odm_georeferencing/coords.txt", "WGS84 UTM 32N\n567000 5150000\n");
  for (const auto& source : {undistorted, undistorted / ".", undistorted / "reconstruction.json"}) {
    const Scene scene = read_scene(source, options);
    EXPECT_EQ(scene.srs, "EPSG:32632") << source;
    EXPECT_EQ(scene.offset, (WorldPoint{567000, 5150000, 0}));
  }
}

TEST(OpenSfm, ReadsTheReferenceBesideTheReconstruction) {
  const std::string embedded = "  \"reference_lla\": {\"latitude\": 46.5, \"longitude\": 8.25, \"altitude\": 600.5},\n";
  const OdmProject project(replaced(kReconstruction, embedded, ""));
  EXPECT_EQ(read_scene(project.folder.path(), {}).srs, "");
  project.folder.write("opensfm/reference_lla.json", "{\"latitude\": -33.125, \"longitude\": 151, \"altitude\": 0}");
  EXPECT_EQ(read_scene(project.folder.path(), {}).srs, "ENU:-33.125,151");
  project.folder.write("opensfm/reference_lla.json", "{\"latitude\": \"south\"}");
  EXPECT_TRUE(contains(input_error([&] { read_scene(project.folder.path(), {}); }), "reference_lla"));
}

TEST(OpenSfm, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kReconstruction, from, to)); });
  };
  std::string dual = kReconstruction;
  for (const char* type : {"perspective", "brown", "fisheye", "fisheye_opencv"})
    dual = replaced(dual, "\"" + std::string(type) + "\"", "\"dual\"");
  EXPECT_TRUE(contains(input_error([&] { parse(dual); }),
                       "camera 'b': projection type 'dual' is not supported; supported are perspective"));
  EXPECT_TRUE(contains(error("\"focal_x\": 0.9,", ""), "camera 'b': has no 'focal_x'"));
  EXPECT_TRUE(contains(error("\"k3\": 0.003, \"p1\"", "\"k3\": \"\", \"p1\""), "expected a number as 'k3'"));
  EXPECT_TRUE(contains(error("\"brown\"", "3"), "camera 'b': expected a text as 'projection_type'"));
  EXPECT_TRUE(contains(error("\"focal\": 0.9", "\"focal\": \"0.9\""), "camera 'p': expected a number as 'focal'"));
  EXPECT_TRUE(contains(error("\"focal\": 0.9", "\"focal\": 0"), "camera 'p': the focal length"));
  EXPECT_TRUE(contains(error("\"width\": 400", "\"width\": 1e18"), "camera 'p': expected a whole number"));
  EXPECT_TRUE(contains(error("\"camera\": \"p\", \"rot", "\"camera\": \"q\", \"rot"), "its camera 'q'"));
  EXPECT_TRUE(contains(error("[-10, 20, 100]", "[-10, 20]"), "expected 3 numbers as 'translation'"));
  EXPECT_TRUE(contains(error("[-10, 20, 100]", "[-10, 20, 1e999]"), "scene.file"));
  EXPECT_TRUE(contains(input_error([] { parse("[1]"); }), "reconstruction 0: expected the objects"));
  EXPECT_TRUE(contains(input_error([] { parse("{}"); }), "list of reconstructions"));
  EXPECT_TRUE(contains(input_error([] { parse("[{]"); }), "byte 3: expected well-formed JSON"));
  EXPECT_TRUE(contains(input_error([] { parse(std::string(100000, '[')); }), "well-formed JSON"));
}

TEST(OpenSfm, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("OpenSfM", kReconstruction, 1);
  test::expect_changes_survived("OpenSfM", kReconstruction);
}

}  // namespace
}  // namespace gpvc::io
