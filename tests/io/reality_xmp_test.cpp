#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;

constexpr const char* kFormat = "RealityCapture";

// Written from the document: half a turn about x, so the camera looks down from (10, 20, 100).
const std::string kXmp = R"(<x:xmpmeta xmlns:x="adobe:ns:meta/">
  <rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
    <rdf:Description xcr:Version="3" xcr:PosePrior="locked" xcr:Coordinates="absolute"
       xcr:DistortionModel="brown4t2" xcr:FocalLength35mm="32.4"
       xcr:Skew="0" xcr:AspectRatio="1" xcr:PrincipalPointU="0.01"
       xcr:PrincipalPointV="-0.02" xcr:CalibrationPrior="exact" xcr:InTexturing="1"
       xmlns:xcr="http://www.capturingreality.com/ns/xcr/1.1#">
      <xcr:Rotation>1 0 0 0 -1 0 0 0 -1</xcr:Rotation>
      <xcr:Position>10 20 100</xcr:Position>
      <xcr:DistortionCoeficients>-0.1 0.02 0.03 -0.04 0.005 -0.006</xcr:DistortionCoeficients>
    </rdf:Description>
  </rdf:RDF>
</x:xmpmeta>
)";

WorldPoint world_of(double x, double y) { return {10 + 50 * x, 20 - 50 * y, 50}; }

/// The view of a photo of this size.
View sized(const std::string& text, int width, int height) {
  const SceneFile scene = test::parse_as(kFormat, text);
  View view = scene.views.at(0);
  scene.size_camera(view.camera, width, height);
  return view;
}

TEST(RealityXmp, ProjectsAKnownPointInLandscapeAndPortrait) {
  const double x = 0.3, y = -0.2, r2 = 0.13, r4 = r2 * r2;
  const double radial = 1 - 0.1 * r2 + 0.02 * r4 + 0.03 * r4 * r2 - 0.04 * r4 * r4;
  const double u = x * radial + 0.005 * (r2 + 2 * x * x) + 2 * -0.006 * x * y;
  const double v = y * radial + -0.006 * (r2 + 2 * y * y) + 2 * 0.005 * x * y;
  // 32.4 mm of 36 are 0.9 of the longer side, 400 pixels.
  expect_photo_point(sized(kXmp, 400, 300), world_of(x, y), 360 * u + 204, 360 * v + 142);
  expect_photo_point(sized(kXmp, 300, 400), world_of(x, y), 360 * u + 154, 360 * v + 192);
}

TEST(RealityXmp, TakesTheMatrixRowByRow) {
  // Looks along world x, with world -y to the right and world -z down.
  const View view =
      sized(replaced(replaced(kXmp, "1 0 0 0 -1 0 0 0 -1", "0 -1 0 0 0 -1 1 0 0"), "brown4t2", "none"), 400, 300);
  expect_photo_point(view, {60, 20 - 50 * 0.3, 100 - 50 * 0.1}, 360 * 0.3 + 204, 360 * 0.1 + 142);
}

TEST(RealityXmp, TakesAttributesForElements) {
  std::string text = replaced(kXmp, "<xcr:Rotation>1 0 0 0 -1 0 0 0 -1</xcr:Rotation>", "");
  text = replaced(text, "<xcr:Position>10 20 100</xcr:Position>", "");
  text = replaced(text, "<xcr:DistortionCoeficients>-0.1 0.02 0.03 -0.04 0.005 -0.006</xcr:DistortionCoeficients>", "");
  text = replaced(text, "xcr:Skew=\"0\"",
                  "xcr:Rotation=\"1 0 0 0 -1 0 0 0 -1\" xcr:Position=\"10 20 100\" "
                  "xcr:DistortionCoeficients=\"-0.1 0.02 0.03 -0.04 0.005 -0.006\"");
  const View view = sized(text, 400, 300);
  EXPECT_EQ(view.camera, sized(kXmp, 400, 300).camera);
  EXPECT_EQ(view.pose.centre, (WorldPoint{10, 20, 100}));
}

TEST(RealityXmp, HasNoDistortionWithoutAModelOrCoefficients) {
  for (const std::string& text :
       {replaced(kXmp, "brown4t2", "perspective"), replaced(kXmp, "xcr:DistortionModel=\"brown4t2\"", ""),
        replaced(replaced(kXmp, "brown4t2", "division"), "-0.1 0.02 0.03 -0.04 0.005 -0.006", "0 0 0 0 0 0")})
    EXPECT_TRUE(sized(text, 400, 300).camera.distortion.is_identity());
}

TEST(RealityXmp, RefusesWithTheFileAndTheExpectation) {
  const auto error = [](const std::string& from, const std::string& to) {
    return input_error([&] { test::parse_as(kFormat, replaced(kXmp, from, to)); });
  };
  EXPECT_TRUE(contains(error("0 0 -1</", "0 0</"), "scene.file: expected 9 numbers in xcr:Rotation, found 8"));
  EXPECT_TRUE(contains(error("10 20 100", "10 x 100"), "expected a finite number in xcr:Position, found 'x'"));
  EXPECT_TRUE(contains(error("10 20 100", ""), "expected 3 numbers in xcr:Position, found 0"));
  EXPECT_TRUE(contains(error("1 0 0 0 -1", "1 0 0 0 1"), "the matrix xcr:Rotation is no rotation"));
  EXPECT_TRUE(contains(error("xcr:FocalLength35mm=\"32.4\"", ""), "has no xcr:FocalLength35mm"));
  EXPECT_TRUE(contains(error("\"32.4\"", "\"-1\""), "the focal length is not positive"));
  EXPECT_TRUE(contains(error("-0.04 0.005 ", ""), "expected 6 numbers in xcr:DistortionCoeficients, found 4"));
  EXPECT_TRUE(contains(error("brown4t2", "division"), "the lens model Division is not supported"));
  EXPECT_TRUE(contains(error("brown4t2", "rationalP2D1"), "the lens model 'rationalP2D1' is not supported"));
  EXPECT_TRUE(contains(error("xcr:Skew=\"0\"", "xcr:Skew=\"0.1\""), "xcr:Skew other than 0"));
  EXPECT_TRUE(contains(error("AspectRatio=\"1\"", "AspectRatio=\"1.01\""), "xcr:AspectRatio other than 1"));
  EXPECT_TRUE(contains(error("<x:xmpmeta ", "<y "), "expected well-formed XML"));
}

TEST(RealityXmp, SurvivesCutsAndChanges) {
  test::expect_cuts_refused(kFormat, kXmp, 1);
  test::expect_changes_survived(kFormat, kXmp);
}

class RealityFolder : public testing::Test {
 protected:
  void add(const std::string& name, const std::string& text) {
    folder.write(name + ".xmp", text);
    test::write_photo(folder.path() / (name + ".JPG"), 400, 300);
  }
  Scene read(const std::string& name = "") const { return read_scene(folder.path() / name, {}); }
  test::TemporaryFolder folder;
};

// As raw converters write it beside photos.
const std::string kDevelopment =
    "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF><rdf:Description crs:Version=\"15\"/></rdf:RDF></x:xmpmeta>";

TEST_F(RealityFolder, ReadsThePhotosThatHaveAPose) {
  add("b", kXmp);
  add("a", replaced(kXmp, "10 20 100", "11 20 100"));
  add("developed", kDevelopment);
  add("lost", replaced(replaced(kXmp, "xcr:Rotation", "xcr:R"), "xcr:Rotation", "xcr:R"));
  folder.write("_common.xmp", kDevelopment);
  const Scene scene = read();
  EXPECT_EQ(scene.format, "RealityCapture");
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.views[0].name, "a.JPG");
  EXPECT_EQ(scene.views[0].pose.centre.x, 11);
  EXPECT_EQ(scene.views[1].photo, folder.path() / "b.JPG");
  EXPECT_EQ(scene.views[1].camera.cx, 204);
  EXPECT_EQ(scene.files.size(), 2);
  ASSERT_EQ(scene.warnings.size(), 1);
  EXPECT_EQ(scene.warnings[0], "1 photos without a pose are left out");
  EXPECT_EQ(read("b.xmp").views.size(), 2);
}

TEST_F(RealityFolder, KeepsTheLargestComponentAndThePhotosForTexturing) {
  const auto of = [](const std::string& component) {
    return replaced(kXmp, "\"absolute\"", "\"relative\" xcr:ComponentId=\"{" + component + "}\"");
  };
  add("a", of("A"));
  add("b", of("B"));
  add("c", of("B"));
  add("d", replaced(of("B"), "InTexturing=\"1\"", "InTexturing=\"0\""));
  const Scene scene = read();
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.views[0].name, "b.JPG");
  ASSERT_EQ(scene.warnings.size(), 2);
  EXPECT_EQ(scene.warnings[0], "1 photos of other components are left out; {B}, 3 photos, are read");
  EXPECT_EQ(scene.warnings[1], "1 photos are left out: they are marked as not for texturing (xcr:InTexturing)");
}

TEST_F(RealityFolder, LeavesOutLensesThatAreNotSupported) {
  add("a", replaced(kXmp, "brown4t2", "division"));
  EXPECT_TRUE(contains(input_error([&] { read(); }), "a.xmp: the lens model Division is not supported"));
  add("b", kXmp);
  EXPECT_EQ(read().views.size(), 1);
  EXPECT_EQ(read().warnings.at(0), "1 photos are left out: their lens, 'division', is not supported");
}

TEST_F(RealityFolder, IsNotOneForOtherMetadata) {
  add("a", kDevelopment);
  EXPECT_TRUE(contains(input_error([&] { read(); }), "is no scene: expected"));
  EXPECT_TRUE(contains(input_error([&] { read("a.xmp"); }), "is XML of another program, whose root is 'x:xmpmeta'"));
  folder.write("cameras.txt", "1 PINHOLE 400 300 360 360 200 150\n");
  folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.JPG\n\n");
  EXPECT_EQ(read_scene(folder.path(), {.images_dir = folder.path()}).format, "COLMAP");
  add("b", kXmp);
  EXPECT_TRUE(contains(input_error([&] { read(); }), "holds both a COLMAP scene"));
  EXPECT_EQ(read("b.xmp").format, "RealityCapture");
}

}  // namespace
}  // namespace gpvc::io
