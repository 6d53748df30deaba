#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// Written from the manual: cameras at (10, 20, 100) that look down, since z points back. North is up in the first photo,
// west in the third; the second has no pose.
const std::string kCameras = R"(# Bundle file v0.3
3 1
360 -0.1 0.02
1 0 0
0 1 0
0 0 1
-10 -20 -100
0 0 0
0 0 0
0 0 0
0 0 0
0 0 0
365.5 0 0
0 1 0
-1 0 0
0 0 1
-20 10 -100)";
const std::string kBundle = kCameras + "\n0 0 0\n1 2 3\n2 0 0 1.5 2.5 2 0 3 4\n";

SceneFile parse(const std::string& text) { return test::parse_as("Bundler", text); }

/// The view of a photo of 400 x 300.
View sized(const SceneFile& scene, const char* name) {
  View view = view_named(scene, name);
  scene.size_camera(view.camera, 400, 300);
  return view;
}

TEST(Bundler, ProjectsAKnownPoint) {
  const SceneFile scene = parse(kBundle);
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.warnings.at(0), "1 images without a pose are left out");
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2;
  expect_photo_point(sized(scene, "00000000"), {10 + 50 * x, 20 - 50 * y, 50}, 360 * x * radial + 200,
                     360 * y * radial + 150);
  // North points right in the photo, west up.
  expect_photo_point(sized(scene, "00000002"), {10 + 50 * y, 20 + 50 * x, 50}, 365.5 * x + 200, 365.5 * y + 150);
  EXPECT_EQ(view_named(scene, "00000002").pose.centre, (WorldPoint{10, 20, 100}));
}

class BundlerFolder {
 public:
  BundlerFolder(const std::string& bundle, const std::string& list, const std::string& names) {
    folder.write(bundle, kBundle);
    folder.write(list, names);
    test::write_photo(folder.path() / "images/a.jpg", 400, 300);
    test::write_photo(folder.path() / "images/c d 0 1.jpg", 300, 401);
  }
  test::TemporaryFolder folder;
};

TEST(Bundler, FindsItsList) {
  const std::string of_bundler = "./images/a.jpg 0 361.5\r\n./images/b.jpg\n\n./images/c d 0 1.jpg 0 360\n";
  const std::string of_colmap = "a.jpg\nb.jpg\nc d 0 1.jpg\n";
  const std::array<std::string, 3> layouts[] = {{"bundle/bundle.out", "list.txt", of_bundler},
                                                {"bundler/bundle_r000.out", "bundler/list_r000.out", of_colmap},
                                                {"bundle.out", "list.txt", of_colmap},
                                                {"x.bundle.out", "x.list.txt", of_colmap}};
  for (const auto& [bundle, list, names] : layouts) {
    const BundlerFolder data(bundle, list, names);
    data.folder.write(std::filesystem::path(bundle).parent_path() / "bundle_001.out",
                      bundle == "x.bundle.out" ? "" : kBundle);
    const auto root = data.folder.path();
    const bool of_opensfm = bundle.starts_with("bundler/");
    for (const auto& source : {of_opensfm ? root / "bundler/bundle_r000.out" : root, root / bundle}) {
      const Scene scene = read_scene(source, {});
      EXPECT_EQ(scene.format, "Bundler");
      ASSERT_EQ(scene.views.size(), 2) << bundle;
      EXPECT_TRUE(contains(scene.views[0].name, "a.jpg"));
      EXPECT_TRUE(contains(scene.views[1].name, "c d 0 1.jpg"));
      EXPECT_EQ(scene.views[0].camera.cx, 200);
      EXPECT_EQ(scene.views[1].camera.cy, 200.5);
      EXPECT_EQ(scene.files.size(), 2);
    }
  }
}

TEST(Bundler, TakesPhotosAsPmvsNumbersThem) {
  const test::TemporaryFolder folder;
  folder.write("bundle.rd.out", kBundle);
  test::write_photo(folder.path() / "visualize/00000000.jpg", 400, 300);
  test::write_photo(folder.path() / "visualize/00000002.jpg", 400, 300);
  const Scene scene = read_scene(folder.path(), {});
  EXPECT_EQ(scene.views.size(), 2);
  EXPECT_TRUE(contains(scene.warnings.back(), "the list of images is missing"));
}

TEST(Bundler, RefusesWithPlaceAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kBundle, from, to)); });
  };
  EXPECT_TRUE(contains(error("v0.3", "v0.4"), "line 1: expected '# Bundle file v0.3'"));
  EXPECT_TRUE(contains(error("3 1\n", "3.5 1\n"), "line 2: expected a number of cameras"));
  EXPECT_TRUE(contains(error("3 1\n", "three 1\n"), "the number of cameras: expected a number, found 'three'"));
  EXPECT_TRUE(contains(error("3 1\n", "30 1\n"), "camera 4: ends early"));
  EXPECT_TRUE(contains(error("360", "-360"), "camera 0: the focal length is not positive"));
  EXPECT_TRUE(contains(error("1 0 0", "2 0 0"), "camera 0: its matrix is no rotation"));
  EXPECT_TRUE(contains(error("-20 10", "-20 y"), "camera 2: expected a number, found 'y'"));
  const BundlerFolder data("bundle.out", "list.txt", "a.jpg\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(data.folder.path(), {}); }),
                       "list.txt: names 1 images, but bundle.out has 3 cameras"));
  const BundlerFolder nameless("bundle.out", "list.txt", "a.jpg\n\nimages/\nc.jpg\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(nameless.folder.path(), {}); }),
                       "list.txt: line 3: expected the name of a photo, found 'images/'"));
}

TEST(Bundler, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("Bundler", kCameras, 3);  // "-1" for -100 is a number as well
  test::expect_changes_survived("Bundler", kBundle);
}

}  // namespace
}  // namespace gpvc::io
