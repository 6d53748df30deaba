// Scenes written for other programs are read back by our readers of those formats, which have tests of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "io/images.h"
#include "io/scene_files.h"
#include "tests/support/scene_folder.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

constexpr WorldPoint kUtm{430000.125, 4587000.5, 212.25};

std::array<double, 9> rotation_about(double x, double y, double z, double angle) {
  const double n = std::sqrt(x * x + y * y + z * z), c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  x /= n;
  y /= n;
  z /= n;
  return {c + x * x * d,     x * y * d - z * s, x * z * d + y * s, y * x * d + z * s, c + y * y * d,
          y * z * d - x * s, z * x * d - y * s, z * y * d + x * s, c + z * z * d};
}

/// Views of all rotations (each branch of the quaternion), landscape and portrait, in UTM coordinates.
Scene scene_of(const std::vector<Camera>& cameras) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  Scene scene;
  for (std::size_t i = 0; i < 12; ++i) {
    View view;
    view.name = (i % 2 == 0 ? "north/photo " : "south/photo ") + std::to_string(10 + i) + ".jpg";
    view.camera = cameras[i % cameras.size()];
    limit_distortion(view.camera);
    view.pose.rotation = i < 4 ? rotation_about(i == 1, i == 2, i == 0 || i == 3, i == 0 ? 0.0 : 3.14)
                               : rotation_about(unit(random), unit(random), unit(random), 3 * unit(random));
    view.pose.centre = {kUtm.x + 100 * unit(random), kUtm.y + 100 * unit(random), kUtm.z + 50 * unit(random)};
    scene.views.push_back(view);
  }
  std::sort(scene.views.begin(), scene.views.end(), [](const View& a, const View& b) { return a.name < b.name; });
  return scene;
}

/// Written with blank photos, and read.
Scene written_and_read(io::SceneTarget target, const Scene& scene, const TemporaryFolder& folder) {
  const std::vector<ViewId> used = all_views(scene);
  const std::vector<fs::path> places = io::photo_places(target, scene, used);
  for (std::size_t i = 0; i < used.size(); ++i) {
    Image blank;
    blank.width = scene.views[i].camera.width;
    blank.height = scene.views[i].camera.height;
    blank.pixels.assign(static_cast<std::size_t>(blank.width) * static_cast<std::size_t>(blank.height) * 3, 90);
    fs::create_directories((folder.path() / places[i]).parent_path());
    io::write_image(folder.path() / places[i], blank, io::ImageFormat::jpg, 50);
  }
  if (target == io::SceneTarget::colmap) fs::create_directories(folder.path() / "sparse");
  io::write_scene(target, scene, used, places, folder.path());
  return io::read_scene(folder.path(), {});
}

void expect_same(const Scene& scene, const Scene& read) {
  ASSERT_EQ(scene.views.size(), read.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const View &a = scene.views[i], &b = read.views[i];
    SCOPED_TRACE(a.name + " / " + b.name);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(a.pose.rotation[k], b.pose.rotation[k], 1e-9);
    // t = -R C and back rounds at the size of UTM coordinates, 1e-9 m.
    EXPECT_NEAR(a.pose.centre.x, b.pose.centre.x, 4e-9);
    EXPECT_NEAR(a.pose.centre.y, b.pose.centre.y, 4e-9);
    EXPECT_NEAR(a.pose.centre.z, b.pose.centre.z, 4e-9);
    for (const PixelPoint p : {PixelPoint{20, 10}, PixelPoint{31, 60}, PixelPoint{70.5, 33.25}}) {
      // The frame may differ in nothing that a direction's place in the photo shows.
      const PixelPoint same{(p.x - a.camera.cx) / a.camera.fx * b.camera.fx + b.camera.cx,
                            (p.y - a.camera.cy) / a.camera.fy * b.camera.fy + b.camera.cy};
      const auto pa = photo_from_pixel(a.camera, p), pb = photo_from_pixel(b.camera, same);
      ASSERT_TRUE(pa && pb);
      EXPECT_NEAR(pa->x, pb->x, 1e-6);
      EXPECT_NEAR(pa->y, pb->y, 1e-6);
    }
  }
}

Camera pinhole() { return {96, 72, 80.25, 81.5, 47.125, 36.75, {}}; }
Camera portrait() { return {72, 96, 80.25, 79, 37.5, 46.25, {}}; }

Camera with(const Distortion& distortion) {
  Camera camera = pinhole();
  camera.distortion = distortion;
  return camera;
}

TEST(SceneWriter, ColmapStatesItsLenses) {
  const std::vector<Camera> cameras{
      pinhole(),
      portrait(),
      with({.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3, .p2 = -2e-3, .model = LensModel::brown}),
      with({.k1 = 0.1, .k2 = 0.02, .p1 = 1e-3, .k3 = 0.01, .model = LensModel::perspective, .d1 = 0.1, .d3 = 0.01}),
      with({.k1 = 0.05, .k2 = -0.01, .k3 = 0.002, .model = LensModel::equidistant, .k4 = 0.001}),
      with({.k1 = 0.05, .p1 = 1e-3, .p2 = 2e-3, .model = LensModel::equidistant, .s1 = 1e-3}),
      with({.model = LensModel::fov, .omega = 0.8}),
      with({.k1 = -0.2, .model = LensModel::division}),
      with({.model = LensModel::unified, .alpha = 0.6, .beta = 1.1}),
      with({.k1 = 0.05,
            .k2 = -0.01,
            .p1 = 1e-3,
            .p2 = 2e-3,
            .k3 = 0.002,
            .model = LensModel::fisheye_624,
            .k4 = 0.001,
            .s1 = 3e-3,
            .s2 = 4e-3,
            .k5 = 0.003,
            .k6 = -0.004,
            .s3 = 5e-3,
            .s4 = 6e-3})};
  const Scene scene = scene_of(cameras);
  const TemporaryFolder folder;
  expect_same(scene, written_and_read(io::SceneTarget::colmap, scene, folder));
}

TEST(SceneWriter, MvsStatesPinholes) {
  const Scene scene = scene_of({pinhole(), portrait()});
  const TemporaryFolder folder;
  expect_same(scene, written_and_read(io::SceneTarget::mvs, scene, folder));
}

TEST(SceneWriter, CamStatesPinholesAndRadialTerms) {
  Camera radial{96, 72, 80, 80, 48, 36, {}};
  radial.distortion.k1 = -0.1;
  radial.distortion.k2 = 0.02;
  Camera inverse = radial;
  inverse.distortion = {};
  inverse.distortion.model = LensModel::inverse_radial;
  inverse.distortion.k1 = -0.05;
  const Scene scene = scene_of({pinhole(), portrait(), radial, inverse});
  const TemporaryFolder folder;
  expect_same(scene, written_and_read(io::SceneTarget::cam, scene, folder));
}

TEST(SceneWriter, NvmStatesCentredSquarePinholesAndOneRadialTerm) {
  const Camera centred{96, 72, 80.25, 80.25, 48, 36, {}}, tall{71, 97, 80.1, 80.1, 35.5, 48.5, {}};
  Camera inverse = centred;
  inverse.distortion.model = LensModel::inverse_radial;
  inverse.distortion.k1 = -0.05;
  const Scene scene = scene_of({centred, tall, inverse});
  const TemporaryFolder folder;
  const Scene read = written_and_read(io::SceneTarget::nvm, scene, folder);
  expect_same(scene, read);
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_EQ(read.views[i].camera, scene.views[i].camera);
    EXPECT_EQ(read.views[i].pose.centre.x, scene.views[i].pose.centre.x);
  }
  EXPECT_TRUE(test::contains(test::read_file(folder.path() / "scene.nvm"), "images/north/photo\"10.jpg\t80.25 "));
  EXPECT_TRUE(test::read_file(folder.path() / "scene.nvm").ends_with(" 0\n\n0\n\n0\n"));
}

TEST(SceneWriter, NvmNamesWhatItCannotState) {
  const auto lost = [](const Camera& camera) {
    return io::lost_term(io::SceneTarget::nvm, camera).value_or("nothing");
  };
  Camera camera{96, 72, 80, 80, 48, 36, {}};
  EXPECT_EQ(lost(camera), "nothing");
  camera.fy = 81;
  EXPECT_EQ(lost(camera), "fx apart from fy");
  camera.fy = 80;
  camera.cy = 36.5;
  EXPECT_EQ(lost(camera), "a principal point off the middle");
  camera.cy = 36;
  camera.distortion.k1 = 0.1;
  EXPECT_EQ(lost(camera), "k1");
  camera.distortion.model = LensModel::inverse_radial;
  EXPECT_EQ(lost(camera), "nothing");
  camera.distortion.k2 = 0.1;
  EXPECT_EQ(lost(camera), "k2");
  camera.distortion = {.model = LensModel::equidistant};
  EXPECT_EQ(lost(camera), "the equidistant (fisheye) projection");

  Scene scene = scene_of({pinhole()});
  for (const char* name : {"a\"b.jpg", "a\\b.jpg", "a\nb.jpg"}) {
    scene.views[0].name = name;
    EXPECT_THROW(io::photo_places(io::SceneTarget::nvm, scene, all_views(scene)), OutputError) << name;
  }
}

TEST(SceneWriter, TransformsStateTheirLenses) {
  const Camera brown = with({.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3, .p2 = -2e-3, .k3 = 0.01, .model = LensModel::brown});
  const Camera four = with({.k1 = -0.1, .model = LensModel::perspective, .k4 = 0.01});
  const Camera fisheye = with({.k1 = 0.05, .k2 = -0.01, .k3 = 0.002, .model = LensModel::equidistant, .k4 = 0.001});
  for (const Scene& scene : {scene_of({pinhole(), portrait(), brown, four, fisheye}), scene_of({brown})}) {
    const TemporaryFolder folder;
    expect_same(scene, written_and_read(io::SceneTarget::transforms, scene, folder));
  }
}

TEST(SceneWriter, OpensfmStatesItsLensesAndReference) {
  const Camera brown = with({.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3, .p2 = -2e-3, .k3 = 0.01, .model = LensModel::brown});
  const Camera fisheye = with({.k1 = 0.05, .k2 = -0.01, .k3 = 0.002, .model = LensModel::equidistant, .k4 = 0.001});
  Scene scene = scene_of({pinhole(), portrait(), brown, fisheye});
  scene.srs = "ENU:50.8225,-0.1372";
  scene.offset = {0, 0, 12.5};
  const TemporaryFolder folder;
  const Scene read = written_and_read(io::SceneTarget::opensfm, scene, folder);
  expect_same(scene, read);
  EXPECT_EQ(read.views[0].name, scene.views[0].name);
  EXPECT_EQ(read.srs, scene.srs);
  EXPECT_EQ(read.offset, scene.offset);
}

TEST(SceneWriter, JsonRefusesNamesThatAreNotUtf8) {
  Scene scene = scene_of({pinhole()});
  scene.views[0].name = "photo \xE9.jpg";
  const TemporaryFolder folder;
  const std::vector<ViewId> used = all_views(scene);
  for (const io::SceneTarget target : {io::SceneTarget::transforms, io::SceneTarget::opensfm}) {
    EXPECT_THROW(io::write_scene(target, scene, used, io::photo_places(target, scene, used), folder.path()),
                 OutputError);
    EXPECT_TRUE(fs::is_empty(folder.path()));
  }
}

TEST(SceneWriter, NamesTheTermThatWouldBeLost) {
  const auto lost = [](io::SceneTarget target, const Camera& camera) {
    return io::lost_term(target, camera).value_or("nothing");
  };
  const Camera brown = with({.p1 = 1e-3, .model = LensModel::brown});
  EXPECT_EQ(lost(io::SceneTarget::mvs, brown), "p1");
  EXPECT_EQ(lost(io::SceneTarget::cam, brown), "p1");
  EXPECT_EQ(lost(io::SceneTarget::colmap, brown), "nothing");
  const Camera k1 = with({.k1 = 1e-3, .model = LensModel::brown});
  EXPECT_EQ(lost(io::SceneTarget::cam, k1), "k1 without k2");
  const Camera metashape = with({.k1 = 0.1, .model = LensModel::perspective, .p3 = 1e-3});
  EXPECT_EQ(lost(io::SceneTarget::colmap, metashape), "p3");
  const Camera equisolid = with({.model = LensModel::equisolid});
  EXPECT_EQ(lost(io::SceneTarget::colmap, equisolid), "the equisolid (fisheye) projection");
  // OpenSfM's fisheye62 and fisheye624: COLMAP's model with these terms takes the tangential ones elsewhere.
  const Camera six = with({.k1 = 0.1, .model = LensModel::equidistant, .k6 = 1e-3});
  EXPECT_EQ(lost(io::SceneTarget::colmap, six), "k6");
  const Camera prism = with({.model = LensModel::equidistant, .s4 = 1e-3});
  EXPECT_EQ(lost(io::SceneTarget::colmap, prism), "s4");
  EXPECT_EQ(lost(io::SceneTarget::transforms, metashape), "p3");
  EXPECT_EQ(lost(io::SceneTarget::transforms, equisolid), "the equisolid (fisheye) projection");
  EXPECT_EQ(lost(io::SceneTarget::opensfm, six), "k6");
  EXPECT_EQ(lost(io::SceneTarget::opensfm, with({.model = LensModel::perspective, .k4 = 0.1})), "k4");
  const Camera division = with({.k1 = -0.2, .model = LensModel::division});
  EXPECT_EQ(lost(io::SceneTarget::cam, division), "the division projection");

  const Scene scene = scene_of({brown});
  const TemporaryFolder folder;
  const std::vector<ViewId> used = all_views(scene);
  EXPECT_THROW(io::write_scene(io::SceneTarget::mvs, scene, used, io::photo_places(io::SceneTarget::mvs, scene, used),
                               folder.path()),
               OutputError);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(SceneWriter, CamRefusesPhotosThatMeetInOneName) {
  Scene scene = scene_of({pinhole()});
  scene.views.resize(2);
  scene.views[0].name = "a/b.jpg";
  scene.views[1].name = "a_b.png";
  const std::vector<ViewId> used = all_views(scene);
  EXPECT_THROW(io::photo_places(io::SceneTarget::cam, scene, used), OutputError);
  EXPECT_NO_THROW(io::photo_places(io::SceneTarget::mvs, scene, used));
}

// Links of the folder that the program runs in are not those of the folder that is written.
TEST(SceneWriter, ColmapNamesPhotosAlikeWhereverItRuns) {
  Scene scene = scene_of({pinhole()});
  const std::vector<ViewId> used = all_views(scene);
  const TemporaryFolder folder, elsewhere;
  fs::create_directories(folder.path() / "sparse");
  fs::create_directories(elsewhere.path() / "city");
  fs::create_directories(elsewhere.path() / "images");
  fs::create_directory_symlink(elsewhere.path() / "city", elsewhere.path() / "images/north");
  const test::WorkingFolder running(elsewhere.path());
  io::write_scene(io::SceneTarget::colmap, scene, used, io::photo_places(io::SceneTarget::colmap, scene, used),
                  folder.path());
  const std::string images = test::read_file(folder.path() / "sparse/images.bin");
  EXPECT_TRUE(test::contains(images, std::string("north/photo 10.jpg") + '\0'));
}

TEST(SceneWriter, NamesOfOneFileAreOneName) {
  Scene scene = scene_of({pinhole(), pinhole()});
  scene.views[0].name = "./a//photo.jpg";
  scene.views[1].name = "b.jpg";
  const std::vector<ViewId> used = all_views(scene);
  EXPECT_EQ(io::photo_places(io::SceneTarget::colmap, scene, used).front(), "images/a/photo.jpg");
  scene.views[1].name = "a/photo.jpg";
  EXPECT_THROW(io::photo_places(io::SceneTarget::colmap, scene, used), OutputError);
}

}  // namespace
}  // namespace gpvc
