#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;

// Half a turn about x: looks down from (10, 20, 100); t = -R c = (-10, 20, 100).
const std::string kPose = "rotation = 1 0 0 0 -1 0 0 0 -1\ntranslation = -10 20 100\n";

WorldPoint world_of(double x, double y) { return {10 + 50 * x, 20 - 50 * y, 50}; }

class MveFolder {
 public:
  void add(const std::string& name, int id, const std::string& camera, const std::vector<std::string>& pictures) {
    const std::string view = "views/" + name + ".mve/";
    folder.write(view + "meta.ini", "# MVE view meta data\n\n[view]\nid = " + std::to_string(id) + "\nname = " + name +
                                        "\n\n[camera]\n" + camera);
    for (const std::string& picture : pictures) test::write_photo(folder.path() / (view + picture), 400, 300);
  }
  test::TemporaryFolder folder;
};

TEST(MveScene, ProjectsAKnownPointAndTakesTheEmbeddingThatIsAskedFor) {
  MveFolder files;
  const std::string camera = "focal_length = 0.9\npixel_aspect = 1\nprincipal_point = 0.5 0.5\n";
  files.add("view_0000", 7, camera + "radial_distortion = -0.1 0.02\n" + kPose, {"original.jpg", "undistorted.png"});
  files.add("view_0001", 3, "focal_length = 0.9\npixel_aspect = 1.1\nprincipal_point = 0.51 0.48\n" + kPose,
            {"undistorted.jpg", "thumbnail.png"});
  files.add("view_0002", 5, "focal_length = 0\n", {"original.jpg"});
  const Scene scene = read_scene(files.folder.path(), {});
  EXPECT_EQ(scene.format, "MVE");
  ASSERT_EQ(scene.views.size(), 2u);  // the third has no pose
  EXPECT_EQ(scene.views[0].photo.filename(), "undistorted.png");
  EXPECT_EQ(scene.views[0].number, 7u);
  EXPECT_EQ(scene.views[1].number, 3u);
  const double x = 0.3, y = -0.2, radial = 1 - 0.1 * 0.13 + 0.02 * 0.13 * 0.13;
  expect_photo_point(scene.views[0], world_of(x, y), 0.9 * 400 * x + 200, 0.9 * 400 * y + 150);
  expect_photo_point(scene.views[1], world_of(x, y), 0.9 * 400 * x + 0.51 * 400, 0.9 * 400 * 1.1 * y + 0.48 * 300);
  const Scene as_taken = read_scene(files.folder.path().string() + "::original", {});
  ASSERT_EQ(as_taken.views.size(), 1u);
  expect_photo_point(as_taken.views[0], world_of(x, y), 0.9 * 400 * x * radial + 200, 0.9 * 400 * y * radial + 150);
  EXPECT_TRUE(contains(as_taken.warnings.at(0), "1 views have no picture 'original'"));
  EXPECT_TRUE(contains(input_error([&] { read_scene(files.folder.path().string() + "::undist-L9", {}); }),
                       "no view has a picture 'undist-L9'; view_0000.mve has original, undistorted"));
}

TEST(MveScene, RefusesWithKeyAndExpectation) {
  const auto error = [](const std::string& camera) {
    MveFolder files;
    files.add("a", 0, camera, {"undistorted.jpg"});
    return input_error([&] { read_scene(files.folder.path(), {}); });
  };
  EXPECT_TRUE(contains(error("focal_length = x\n"), "camera.focal_length: expected a number, found 'x'"));
  EXPECT_TRUE(contains(error("focal_length = 1\n" + kPose.substr(0, 30)), "camera.translation: is missing"));
  EXPECT_TRUE(contains(error("focal_length = 1 2\n"), "camera.focal_length: expected 1 number"));
  EXPECT_TRUE(contains(error("focal_length\n"), "line 8: expected [SECTION] or KEY = VALUE"));
  EXPECT_TRUE(
      contains(error("focal_length = 1\nrotation = 1 0 0 0 1 0 0 0 -1\ntranslation = 0 0 0\n"), "is no rotation"));
  EXPECT_TRUE(contains(error("focal_length = 0\n"), "lists no image with a pose"));
}

}  // namespace
}  // namespace gpvc::io
