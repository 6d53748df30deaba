#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;

// Half a turn about x: looks down from (10, 20, 100); t = -R c = (-10, 20, 100).
const std::string kPose = "-10 20 100 1 0 0 0 -1 0 0 0 -1\n";

WorldPoint world_of(double x, double y) { return {10 + 50 * x, 20 - 50 * y, 50}; }

class CamFolder {
 public:
  void add(const std::string& name, const std::string& intrinsics, int width, int height) {
    folder.write(name + ".cam", kPose + intrinsics + "\n");
    test::write_photo(folder.path() / (name + ".jpg"), width, height);
  }
  test::TemporaryFolder folder;
};

TEST(CamFolder, ProjectsAKnownPointWithEveryForm) {
  CamFolder files;
  files.add("a", "0.9 0 0 1.1 0.51 0.48", 400, 300);
  files.add("b portrait", "0.9 0 0 1.1 0.51 0.48", 300, 400);
  files.add("c", "0.9 -0.1 0.02 1 0.5 0.5", 400, 300);
  files.add("d", "0.9 0.15", 400, 300);
  files.add("e", "0.9", 400, 300);
  const Scene scene = read_scene(files.folder.path(), {});
  ASSERT_EQ(scene.views.size(), 5);
  EXPECT_EQ(scene.format, "mvs-texturing");
  EXPECT_EQ(scene.views[1].name, "b portrait.jpg");
  const double x = 0.3, y = -0.2, r2 = 0.13;
  expect_photo_point(scene.views[0], world_of(x, y), 0.9 * 400 * x + 0.51 * 400, 0.9 * 400 * 1.1 * y + 0.48 * 300);
  expect_photo_point(scene.views[1], world_of(x, y), 0.9 * 400 / 1.1 * x + 0.51 * 300, 0.9 * 400 * y + 0.48 * 400);
  const double radial = 1 - 0.1 * r2 + 0.02 * r2 * r2;
  expect_photo_point(scene.views[2], world_of(x, y), 0.9 * 400 * x * radial + 200, 0.9 * 400 * y * radial + 150);
  // The photo's (0.3, -0.2) comes from the plane's (0.3, -0.2) (1 + 0.15 r2).
  expect_photo_point(scene.views[3], world_of(x * (1 + 0.15 * r2), y * (1 + 0.15 * r2)), 0.9 * 400 * x + 200,
                     0.9 * 400 * y + 150);
  expect_photo_point(scene.views[4], world_of(x, y), 0.9 * 400 * x + 200, 0.9 * 400 * y + 150);
}

TEST(CamFolder, NamesWhatIsMissingOrAmbiguous) {
  CamFolder files;
  files.add("a", "0.9", 400, 300);
  files.folder.write("b.cam", kPose + "0.9\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(files.folder.path(), {}); }), "1 of 2 photos are not in"));
  test::write_photo(files.folder.path() / "b.png", 400, 300);
  EXPECT_EQ(read_scene(files.folder.path() / "a.cam", {}).views.size(), 2);
  test::write_photo(files.folder.path() / "b.jpg", 400, 300);
  EXPECT_TRUE(contains(input_error([&] { read_scene(files.folder.path(), {}); }), "'b' could be any of 2 files"));
}

TEST(CamFolder, RefusesWithLineAndExpectation) {
  const auto error = [](const std::string& text) {
    return input_error([&] { test::parse_as("mvs-texturing", text); });
  };
  EXPECT_TRUE(contains(error(""), "line 1: expected 12 numbers"));
  EXPECT_TRUE(contains(error(kPose), "line 2: expected 1 to 6 numbers"));
  EXPECT_TRUE(contains(error("1 " + kPose + "1\n"), "line 1: expected 12 numbers"));
  EXPECT_TRUE(contains(error(kPose + "x\n"), "line 2: expected a number, found 'x'"));
  EXPECT_TRUE(contains(error(kPose + "0\n"), "focal length"));
  EXPECT_TRUE(contains(error(kPose + "1 0.1 0 1 0.5 0.6\n"), "about the photo's middle"));
  EXPECT_TRUE(contains(error(kPose + "1 0 0 0 0.5 0.6\n"), "pixel's aspect"));
  EXPECT_TRUE(contains(error("0 0 0 1 0 0 0 1 0 0 0 -1\n1\n"), "is no rotation"));
}

TEST(CamFolder, SurvivesCutsAndChanges) {
  const std::string good = kPose + "0.9 -0.1 0.02 1 0.5 0.5\n";
  // A number cut short is a number: only the matrix and the focal length have to be there.
  test::expect_cuts_refused("mvs-texturing", kPose + "9", 0);
  test::expect_changes_survived("mvs-texturing", good);
}

}  // namespace
}  // namespace gpvc::io
