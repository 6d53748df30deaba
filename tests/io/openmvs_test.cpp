#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::bytes_of;
using test::contains;
using test::expect_photo_point;
using test::input_error;

std::string text_bytes(const std::string& text) { return bytes_of<std::uint64_t>(text.size()) + text; }

std::string doubles(const std::vector<double>& values) {
  std::string bytes;
  for (const double v : values) bytes += bytes_of(v);
  return bytes;
}

const std::vector<double> kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};
// Half a turn about x and a quarter about z.
const std::vector<double> kDown{1, 0, 0, 0, -1, 0, 0, 0, -1}, kQuarter{0, -1, 0, 1, 0, 0, 0, 0, 1};
const std::vector<double> kPixelK{350, 0.5, 201.25, 0, 351, 148.5, 0, 0, 1};
const std::vector<double> kUnitK{0.875, 0, 0.5, 0, 0.875, 0.375, 0, 0, 1};
// The same for 200 x 150 pixels as version 6 has it: (100 + 1/2) / 200 - 1/2 and (75 + 1/2) / 200 - 1/2.
const std::vector<double> kUnitK6{0.875, 0, 0.0025, 0, 0.875, -0.1225, 0, 0, 1};

std::string camera_bytes(std::uint32_t version, std::uint32_t width, std::uint32_t height, const std::vector<double>& k,
                         const std::vector<double>& r, const std::vector<double>& c) {
  return text_bytes("cam") + (version > 3 ? text_bytes("RGB") : "") + bytes_of(width) + bytes_of(height) + doubles(k) +
         doubles(r) + doubles(c);
}

std::string image_bytes(std::uint32_t version, const std::string& name, std::uint32_t camera, std::uint32_t pose,
                        const std::string& mask = "") {
  std::string bytes = text_bytes(name) + (version > 4 ? text_bytes(mask) : "") + bytes_of<std::uint32_t>(0) +
                      bytes_of(camera) + bytes_of(pose);
  if (version > 2) bytes += bytes_of<std::uint32_t>(77);
  if (version > 6) bytes += std::string(12, '\1') + bytes_of<std::uint64_t>(1) + std::string(24, '\2');
  return bytes;
}

/// One platform at (10, 20, 100) that looks down; its first camera sits a little off and turned on it, its second is
/// normalized. The points that follow are not read.
std::string archive(std::uint32_t version) {
  return "MVSI" + bytes_of(version) + bytes_of<std::uint32_t>(0) + bytes_of<std::uint64_t>(1) + text_bytes("platform") +
         bytes_of<std::uint64_t>(2) + camera_bytes(version, 400, 300, kPixelK, kQuarter, {0.5, 0.25, 0}) +
         camera_bytes(version, 0, 0, version < 6 ? kUnitK : kUnitK6, kIdentity, {0, 0, 0}) +
         bytes_of<std::uint64_t>(1) + doubles(kDown) + doubles({10, 20, 100}) + bytes_of<std::uint64_t>(3) +
         image_bytes(version, "images\\one two.jpg", 0, 0) + image_bytes(version, "images/b.jpg", 1, 0) +
         image_bytes(version, "images/lost.jpg", 0, 0xFFFFFFFFu);
}

SceneFile parse(const std::string& bytes) { return test::parse_as("OpenMVS", bytes); }

TEST(OpenMvs, ProjectsAKnownPointInEveryVersion) {
  for (std::uint32_t version = 1; version <= 7; ++version) {
    const SceneFile scene = parse(archive(version));
    ASSERT_EQ(scene.views.size(), 2);
    // The platform sees (x, -y, -z): its camera sits at (10.5, 19.75, 100) and is turned by (x, y) -> (-y,
    // x).
    const double px = 3 - 0.5, py = -(4 + 0.25), depth = 50;
    const double x = -py / depth, y = px / depth;
    expect_photo_point(scene.views[0], {13, 24, 50}, 350 * x + 0.5 * y + 201.25 + 0.5, 351 * y + 148.5 + 0.5);
    EXPECT_TRUE(contains(scene.warnings.at(0), "1 images without a pose"));
  }
}

TEST(OpenMvs, SaysThatMasksAreNotUsed) {
  std::string bytes = archive(7);
  const std::string plain = image_bytes(7, "images/b.jpg", 1, 0);
  bytes.replace(bytes.find(plain), plain.size(), image_bytes(7, "images/b.jpg", 1, 0, "images/b.mask.png"));
  const SceneFile scene = parse(bytes);
  EXPECT_EQ(scene.views.size(), 2);
  EXPECT_TRUE(contains(scene.warnings.at(0), "1 masks are not used: they hold labels"));
}

TEST(OpenMvs, SizesNormalizedCamerasByTheirPhotos) {
  const test::TemporaryFolder folder;
  test::write_photo(folder.path() / "images/one two.jpg", 400, 300);
  test::write_photo(folder.path() / "images/b.jpg", 200, 150);
  for (const std::uint32_t version : {5u, 6u, 7u}) {
    folder.write("scene.mvs", archive(version));
    const Scene scene = read_scene(folder.path(), {});
    ASSERT_EQ(scene.views.size(), 2);
    EXPECT_EQ(scene.format, "OpenMVS");
    EXPECT_EQ(scene.views[0].name, "images/b.jpg");
    const Camera& camera = scene.views[0].camera;
    EXPECT_EQ(camera.width, 200);
    EXPECT_EQ(camera.fx, 175);
    // Integers are pixel centres: half a pixel more for us.
    EXPECT_NEAR(camera.cx, 100.5, 1e-12);
    EXPECT_NEAR(camera.cy, 75.5, 1e-12);
  }
  std::string centred = archive(7);
  const std::string k = doubles(kUnitK6);
  centred.replace(centred.find(k), k.size(), doubles({0.875, 0, 0, 0, 0.875, 0, 0, 0, 1}));
  const Scene scene = read_scene(folder.write("scene.mvs", centred), {});
  EXPECT_EQ(scene.views[0].camera.cx, 100) << "0, 0 is the middle";
  EXPECT_EQ(scene.views[0].camera.cy, 75);
  folder.write("scene_dense.mvs", archive(7));
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path(), {}); }), "holds 2 scenes"));
}

TEST(OpenMvs, RefusesHostileCountsWithoutAllocatingThem) {
  const std::string good = archive(7);
  // The counts of platforms, cameras, poses, images and the length of the first name.
  const std::size_t platforms = 12, cameras = platforms + 8 + 8 + 8;
  const std::size_t poses = cameras + 8 + 2 * (8 + 3 + 8 + 3 + 8 + 168), images = poses + 8 + 96;
  for (const std::size_t at : {platforms, platforms + 8, cameras, poses, images, images + 8})
    for (const std::uint64_t count : {std::uint64_t{1000000000000000000}, ~std::uint64_t{0}}) {
      std::string bytes = good;
      bytes.replace(at, 8, bytes_of(count));
      EXPECT_TRUE(contains(input_error([&] { parse(bytes); }), "cannot hold so many")) << at;
    }
}

TEST(OpenMvs, RefusesWithPlaceAndExpectation) {
  EXPECT_TRUE(contains(input_error([] { parse("MVSJ"); }), "byte 4: expected 'MVSI'"));
  EXPECT_TRUE(contains(input_error([] { parse(archive(8)); }), "archive version 8, expected 1 to 7"));
  std::string bytes = archive(7);
  const std::string named = image_bytes(7, "images/b.jpg", 1, 0);
  bytes.replace(bytes.find(named), named.size(), image_bytes(7, "images/b.jpg", 2, 0));
  EXPECT_TRUE(contains(input_error([&] { parse(bytes); }), "image 'images/b.jpg': refers to a platform"));
  bytes = archive(7);
  bytes.replace(bytes.find(doubles(kDown)), 72, doubles({1, 0, 0, 0, 1, 0, 0, 0, -1}));
  EXPECT_TRUE(contains(input_error([&] { parse(bytes); }), "a rotation matrix is none"));
  bytes = archive(7);
  bytes.replace(bytes.find(doubles(kPixelK)), 8, bytes_of(std::nan("")));
  EXPECT_TRUE(contains(input_error([&] { parse(bytes); }), "not finite"));
}

TEST(OpenMvs, SurvivesCutsAndChanges) {
  for (const std::uint32_t version : {1u, 7u}) {
    test::expect_cuts_refused("OpenMVS", archive(version), 0);
    test::expect_changes_survived("OpenMVS", archive(version));
  }
}

}  // namespace
}  // namespace gpvc::io
