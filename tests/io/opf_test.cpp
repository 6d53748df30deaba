#include <cmath>
#include <map>

#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;

// A project of two photos, by hand after the specification. Ids go beyond 2^53, where doubles have gaps of 2.
const std::map<std::string, std::string> kProject{
    {"project.opf", R"({"format": "application/opf-project+json", "version": "1.0", "name": "", "items": [
      {"id": "a", "type": "camera_list", "sources": [],
       "resources": [{"uri": "./cameras%20of%201.json", "format": "application/opf-camera-list+json"}]},
      {"id": "b", "type": "input_cameras", "sources": [],
       "resources": [{"uri": "input.json", "format": "application/opf-input-cameras+json"}]},
      {"id": "c", "type": "calibration", "sources": [], "resources": [
        {"uri": "tracks.gltf", "format": "model/gltf+json"},
        {"uri": "calibrated.json", "format": "application/opf-calibrated-cameras+json"}]},
      {"id": "d", "type": "scene_reference_frame", "sources": [],
       "resources": [{"uri": "frame.json", "format": "application/opf-scene-reference-frame+json"}]}]})"},
    {"cameras of 1.json", R"({"format": "application/opf-camera-list+json", "version": "1.0", "cameras": [
      {"id": 18446744073709551614, "uri": "photos/a%20%231.jpg"},
      {"id": 18446744073709551615, "uri": "photos/b.jpg#page=0"}]})"},
    {"input.json", R"({"format": "application/opf-input-cameras+json", "version": "1.0", "captures": [], "sensors": [
      {"id": 9007199254740992, "name": "x", "image_size_px": [400, 300]},
      {"id": 9007199254740993, "name": "y", "image_size_px": [200, 220]}]})"},
    {"calibrated.json", R"({"format": "application/opf-calibrated-cameras+json", "version": "1.0", "sensors": [
      {"id": 9007199254740992, "internals": {"type": "perspective", "focal_length_px": 360,
       "principal_point_px": [201.5, 148], "radial_distortion": [-0.1, 0.02, 0.003],
       "tangential_distortion": [0.004, -0.002]}},
      {"id": 9007199254740993, "internals": {"type": "perspective", "focal_length_px": 80,
       "principal_point_px": [101, 107], "radial_distortion": [0, 0, 0], "tangential_distortion": [0, 0]}}],
      "cameras": [
      {"id": 18446744073709551614, "sensor_id": 9007199254740992, "position": [10, 20, 100],
       "orientation_deg": [0, 0, 0]},
      {"id": 18446744073709551615, "sensor_id": 9007199254740993, "position": [10, 20, 100],
       "orientation_deg": [30, -20, 70], "rolling_shutter": [0, 0, 1]}]})"},
    {"frame.json", R"({"format": "application/opf-scene-reference-frame+json", "version": "1.0",
      "crs": {"definition": "EPSG:2056+5728"},
      "base_to_canonical": {"scale": [1.0, 1.0, 1.0], "shift": [-2600000.5, -1200000, 0], "swap_xy": true}})"}};

class Opf : public testing::Test {
 protected:
  Opf() {
    test::write_photo(folder_.path() / "photos/a #1.jpg", 400, 300);
    test::write_photo(folder_.path() / "photos/b.jpg", 200, 220);
    for (const auto& file : kProject) folder_.write(file.first, file.second);
  }
  /// With a text of one of the files replaced.
  Scene read(const std::string& file, std::string_view from, std::string_view to) {
    folder_.write(file, replaced(kProject.at(file), from, to));
    const Restore restore{*this, file};
    return read_scene(folder_.path() / "project.opf", {});
  }
  std::string error(const std::string& file, std::string_view from, std::string_view to) {
    return input_error([&] { read(file, from, to); });
  }

  test::TemporaryFolder folder_;

 private:
  struct Restore {
    Opf& test;
    const std::string& file;
    ~Restore() { test.folder_.write(file, kProject.at(file)); }
  };
};

// With angles of 0 the axes of image and world agree: x to the right, y up, and the camera looks along -z.
TEST_F(Opf, ProjectsAKnownPoint) {
  const Scene scene = read_scene(folder_.path(), {});
  EXPECT_EQ(scene.format, "OPF");
  ASSERT_EQ(scene.views.size(), 2);
  const View &a = scene.views[0], &b = scene.views[1];
  EXPECT_EQ(a.name, "photos/a #1.jpg");
  EXPECT_EQ(a.camera.width, 400);
  EXPECT_EQ(b.camera.height, 220);
  const double x = 0.3, y = -0.2, r2 = 0.13, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
  expect_photo_point(a, {10 + 50 * x, 20 - 50 * y, 50},
                     360 * (x * radial + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x)) + 201.5,
                     360 * (y * radial - 2 * 0.002 * x * y + 0.004 * (r2 + 2 * y * y)) + 148);
  // A point of the image's axes (right, up, back), turned about z by kappa, about y by phi, then about x by omega.
  const double d = std::acos(-1) / 180, o = 30 * d, p = -20 * d, k = 70 * d;
  const double r = 50 * x, u = -50 * y, back = -50;
  const double x1 = std::cos(k) * r - std::sin(k) * u, y1 = std::sin(k) * r + std::cos(k) * u;
  const double x2 = std::cos(p) * x1 + std::sin(p) * back, z2 = -std::sin(p) * x1 + std::cos(p) * back;
  const double y3 = std::cos(o) * y1 - std::sin(o) * z2, z3 = std::sin(o) * y1 + std::cos(o) * z2;
  expect_photo_point(b, {10 + x2, 20 + y3, 100 + z3}, 80 * x + 101, 80 * y + 107);
  EXPECT_EQ(scene.warnings.at(0),
            "1 cameras moved while their photos were read out (rolling_shutter), which is not modelled");
}

constexpr const char* kSecondLens =
    R"("perspective", "focal_length_px": 80,
       "principal_point_px": [101, 107], "radial_distortion": [0, 0, 0], "tangential_distortion": [0, 0]})";

// rho = t + 0.02 t^2 - 0.15 t^3 with t = 2 / pi times the angle, then the affine matrix.
TEST_F(Opf, ProjectsThroughAFisheye) {
  const std::string fisheye =
      R"("fisheye", "affine": [150, 3, -2, 151], "is_p0_zero": true, "is_symmetric_affine": false,
       "polynomial": [0, 1, 0.02, -0.15], "principal_point_px": [101, 107]})";
  std::string text = replaced(kProject.at("calibrated.json"), kSecondLens, fisheye);
  folder_.write("calibrated.json", replaced(text, "[30, -20, 70]", "[0, 0, 0]"));
  const Scene scene = read_scene(folder_.path(), {});
  const double pi = std::acos(-1), t = 2 / pi * std::atan(0.5), rho = t + 0.02 * t * t - 0.15 * t * t * t;
  // Right and down of the axis: (0.3, -0.4) of the image's axes is (0.6, 0.8) of the photo's.
  expect_photo_point(scene.views[1], {10 + 50 * 0.3, 20 - 50 * 0.4, 50}, (150 * 0.6 + 3 * 0.8) * rho + 101,
                     (-2 * 0.6 + 151 * 0.8) * rho + 107);
  for (const auto& [from, to] :
       {std::pair{"[0, 1, 0.02", "[0.1, 1, 0.02"}, {"[150, 3, -2, 151]", "[150, 3, -2, -151]"}}) {
    folder_.write("calibrated.json", replaced(text, from, to));
    EXPECT_TRUE(contains(input_error([this] { read_scene(folder_.path(), {}); }),
                         "calibrated.json: sensor 9007199254740993: the fisheye's"));
  }
}

TEST_F(Opf, TakesTheWorldFromTheReferenceFrame) {
  const Scene scene = read_scene(folder_.path(), {});
  EXPECT_EQ(scene.srs, "EPSG:2056+5728");
  EXPECT_EQ(scene.offset, (WorldPoint{2600000.5, 1200000, 0}));
  EXPECT_EQ(scene.other_frames.at(0).origin, (WorldPoint{-2600000.5, -1200000, 0}));
  EXPECT_EQ(scene.other_frames.at(0).srs, "EPSG:2056+5728");
  EXPECT_EQ(scene.files.size(), 5);
  const Scene feet = read("frame.json", "[1.0, 1.0, 1.0]", "[1.0, 1.0, 0.3048]");
  EXPECT_EQ(feet.srs, "");
  EXPECT_EQ(feet.offset, WorldPoint{});
  EXPECT_TRUE(contains(feet.warnings.at(0), "axes of different units"));
  EXPECT_EQ(read("frame.json", "EPSG:2056+5728", "ENGCRS[\\\"site\\\"]").srs, "");
  EXPECT_EQ(read("project.opf", "application/opf-scene-reference-frame+json", "text/plain").srs, "");
}

TEST_F(Opf, FindsPhotosByTheirUri) {
  for (const char* uri : {"file:///C:/Users/x/photos/b.jpg", "file://localhost/home/x/photos/b.jpg",
                          "https://example.org/photos/b.jpg", "../elsewhere/b.jpg"}) {
    folder_.write("cameras of 1.json", replaced(kProject.at("cameras of 1.json"), "photos/b.jpg#page=0", uri));
    SceneOptions options;
    options.images_dir = folder_.path() / "photos";
    const Scene scene = read_scene(folder_.path() / "project.opf", options);
    ASSERT_EQ(scene.views.size(), 2) << uri;
    const View& b = scene.views[scene.views[0].camera.width == 200 ? 0 : 1];
    EXPECT_TRUE(std::filesystem::equivalent(b.photo, folder_.path() / "photos/b.jpg")) << uri;
  }
}

TEST_F(Opf, LeavesOutWhatItCannotRead) {
  const Scene lens = read("calibrated.json", "\"type\": \"perspective\", \"focal_length_px\": 80",
                          "\"type\": \"spherical\", \"focal_length_px\": 80");
  EXPECT_EQ(lens.views.size(), 1);
  EXPECT_EQ(lens.warnings.at(0), "1 images are left out: their lens, 'spherical', is not supported");
  const Scene page = read("cameras of 1.json", "#page=0", "#page=1");
  EXPECT_EQ(page.views.size(), 1);
  EXPECT_EQ(page.warnings.at(0), "1 images are left out: they are further pages of a file");
  const Scene unlisted = read("cameras of 1.json", "18446744073709551615", "18446744073709551613");
  ASSERT_EQ(unlisted.views.size(), 1);
  EXPECT_EQ(unlisted.views[0].name, "photos/a #1.jpg");
  EXPECT_EQ(unlisted.warnings.at(0), "1 cameras are left out: they are in no camera list, so their photos are unknown");
}

TEST_F(Opf, RefusesWithPlaceAndExpectation) {
  EXPECT_TRUE(contains(error("project.opf", "\"items\"", "\"things\""), "project.opf: has no 'items'"));
  EXPECT_TRUE(contains(error("project.opf", "input.json", "../input.json"),
                       "items 1: there is no file '../input.json' beside the project"));
  EXPECT_TRUE(contains(error("project.opf", "application/opf-calibrated-cameras+json", "text/plain"),
                       "project.opf: has no calibrated cameras: its photos have no poses yet"));
  EXPECT_TRUE(contains(error("input.json", "\"1.0\"", "\"2.0\""), "input.json: is of version '2.0', expected 1"));
  EXPECT_TRUE(
      contains(error("input.json", "opf-input", "opf-output"), "'format' is application/opf-input-cameras+json"));
  EXPECT_TRUE(contains(error("input.json", "[400, 300]", "[400, 0.5]"),
                       "sensor 9007199254740992: expected whole numbers of 1 to 2^24 pixels as 'image_size_px'"));
  EXPECT_TRUE(contains(error("input.json", "9007199254740993", "9007199254740994"),
                       "camera 18446744073709551615: its sensor 9007199254740993 is in no file of input cameras"));
  const std::string& list = kProject.at("cameras of 1.json");
  const std::string cameras = list.substr(list.find("[\n"));
  EXPECT_TRUE(
      contains(error("cameras of 1.json", cameras, "[]}"), "camera 18446744073709551615: is in no camera list"));
  EXPECT_TRUE(contains(error("cameras of 1.json", "18446744073709551615", "\"b\""), "expected a whole number as 'id'"));
  EXPECT_TRUE(contains(error("calibrated.json", "\"sensor_id\": 9007199254740993", "\"sensor_id\": 7"),
                       "its sensor 7 is not among 'sensors'"));
  EXPECT_TRUE(contains(error("calibrated.json", "[30, -20, 70]", "[30, -20]"),
                       "camera 18446744073709551615: expected 3 numbers as 'orientation_deg'"));
  EXPECT_TRUE(contains(error("calibrated.json", "\"focal_length_px\": 360", "\"focal_length_px\": 0"),
                       "sensor 9007199254740992: the focal length is not positive"));
  EXPECT_TRUE(
      contains(error("frame.json", "-1200000, 0]", "-1200000]"), "base_to_canonical: expected 3 numbers as 'shift'"));
}

TEST_F(Opf, RefusesCutFiles) {
  for (const auto& file : kProject) {
    for (std::size_t size = 0; size < file.second.size(); ++size) {
      folder_.write(file.first, file.second.substr(0, size));
      EXPECT_THROW(read_scene(folder_.path() / "project.opf", {}), InputError)
          << file.first << ", " << size << " bytes";
    }
    folder_.write(file.first, file.second);
  }
}

// E-books have an .opf, too.
TEST_F(Opf, LeavesTheDescriptionsOfEBooksAlone) {
  folder_.write("content.opf", "<?xml version=\"1.0\"?><package/>");
  EXPECT_EQ(read_scene(folder_.path(), {}).views.size(), 2);
}

}  // namespace
}  // namespace gpvc::io
