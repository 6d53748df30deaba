// Scenes written for other programs are read back by our readers of those formats, which have tests of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "app/cli/console.h"
#include "app/cli/options.h"
#include "app/pipeline/undistort.h"
#include "io/images.h"
#include "io/photos.h"
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

std::vector<ViewId> all_views(const Scene& scene) {
  std::vector<ViewId> used;
  for (std::uint32_t i = 0; i < scene.views.size(); ++i) used.push_back(ViewId{i});
  return used;
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

// --- gpvc convert

/// A COLMAP model with a distorted lens and its photos.
struct SmallProject {
  SmallProject() {
    folder.write("colmap/cameras.txt", "1 RADIAL 40 30 35 20 15 -0.1 0.01\n");
    folder.write("colmap/images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 0 0 1 b c.png\n\n");
    for (const char* name : {"a.png", "b c.png"}) test::write_photo(folder.path() / "images" / name, 40, 30);
  }
  /// What the command says; empty when it succeeds.
  std::string convert(io::SceneTarget target, bool undistort, const fs::path& out, bool force = false) {
    cli::ConvertOptions options;
    options.input.scene = folder.path() / scene;
    if (scene == "colmap") options.input.images_dir = folder.path() / "images";
    options.frame = frame;
    options.input.downscale = downscale;
    options.out = folder.path() / out;
    options.target = target;
    options.undistort = undistort;
    options.force = force;
    cli::Console console(cli::Loudness::quiet, {});
    try {
      cli::run_convert(options, console);
    } catch (const std::exception& error) {
      return error.what();
    }
    return {};
  }
  TemporaryFolder folder;
  fs::path scene = "colmap";
  pipeline::FrameRule frame = pipeline::FrameRule::keep;
  int downscale = 1;
};

TEST(Convert, WritesScenesThatReadBackWithoutDistortion) {
  SmallProject project;
  EXPECT_EQ(project.convert(io::SceneTarget::colmap, true, "for colmap"), "");
  EXPECT_EQ(project.convert(io::SceneTarget::cam, true, "for cam"), "");
  EXPECT_EQ(project.convert(io::SceneTarget::mvs, true, "for mvs"), "");
  EXPECT_EQ(project.convert(io::SceneTarget::transforms, true, "for nerfstudio"), "");
  EXPECT_EQ(project.convert(io::SceneTarget::opensfm, true, "for opensfm"), "");
  for (const char* out : {"for colmap", "for cam", "for mvs", "for nerfstudio", "for opensfm"}) {
    const Scene scene = io::read_scene(project.folder.path() / out, {});
    ASSERT_EQ(scene.views.size(), 2u) << out;
    EXPECT_TRUE(scene.views[1].camera.distortion.is_identity()) << out;
    EXPECT_NEAR(scene.views[1].camera.fx, 35, 1e-6) << out;
    EXPECT_NEAR(scene.views[1].pose.centre.x, -1, 1e-9) << out;
    EXPECT_EQ(io::read_image(scene.views[1].photo).width, 40) << out;
  }
  EXPECT_TRUE(test::contains(project.convert(io::SceneTarget::mvs, false, "other"), "cannot express"));
  EXPECT_FALSE(fs::exists(project.folder.path() / "other"));
}

// Photos in folders with their masks, which the reader finds without being told; undistorting moves a principal point to
// the middle.
TEST(Convert, WritesNvmOfCentredCameras) {
  SmallProject project;
  const fs::path root = project.folder.path();
  project.folder.write("colmap/images.txt", "1 1 0 0 0 0 0 0 1 north/a.png\n\n2 1 0 0 0 1 0 0 1 b c.png\n\n");
  fs::create_directories(root / "images/north");
  fs::rename(root / "images/a.png", root / "images/north/a.png");
  Image mask{40, 30, 1, std::vector<std::uint8_t>(40 * 30, 255)};
  *mask.at(20, 15) = 0;
  io::write_image(root / "images/north/a.mask.png", mask, io::ImageFormat::png, 0);
  ASSERT_EQ(project.convert(io::SceneTarget::nvm, true, "nvm"), "");
  for (const char* source : {"nvm", "nvm/scene.nvm"}) {
    const Scene scene = io::read_scene(root / source, {});
    ASSERT_EQ(scene.views.size(), 2u);
    EXPECT_EQ(scene.views[0].camera, (Camera{40, 30, 35, 35, 20, 15, {}}));
    EXPECT_EQ(scene.views[1].photo, root / "nvm/images/north/a.png");
    EXPECT_TRUE(io::read_exclusion(scene.views[1]));
    EXPECT_FALSE(io::read_exclusion(scene.views[0]));
  }
  EXPECT_TRUE(test::contains(project.convert(io::SceneTarget::nvm, false, "other"), "--undistort writes photos"));
  project.folder.write("colmap/cameras.txt", "1 RADIAL 40 30 35 20.5 15 -0.1 0.01\n");
  EXPECT_FALSE(fs::exists(root / "other"));
  ASSERT_EQ(project.convert(io::SceneTarget::nvm, true, "other"), "");
  const Scene moved = io::read_scene(root / "other", {});
  EXPECT_EQ(moved.views[0].camera, (Camera{40, 30, 35, 35, 20, 15, {}}));
}

// What follows a dot need not be an extension.
TEST(Convert, KeepsPhotosApartThatDifferBehindTheLastDot) {
  SmallProject project;
  const fs::path root = project.folder.path();
  const auto with_photos = [&](const std::vector<std::string>& names) {
    std::string images;
    for (std::size_t i = 0; i < names.size(); ++i) {
      images += std::to_string(i + 1) + " 1 0 0 0 " + std::to_string(i) + " 0 0 1 " + names[i] + "\n\n";
      Image photo{40, 30, 3, std::vector<std::uint8_t>(3 * 40 * 30, static_cast<std::uint8_t>(50 + 50 * i))};
      fs::create_directories((root / "images" / names[i]).parent_path());
      io::write_image(root / "images" / names[i], photo, io::ImageFormat::png, 0);
    }
    project.folder.write("colmap/images.txt", images);
  };
  with_photos({"cam.001", "cam.002", "north/cam.002", "x.tif", "y.JPG"});
  for (const int downscale : {1, 2}) {
    project.downscale = downscale;
    const std::string out = "out " + std::to_string(downscale);
    ASSERT_EQ(project.convert(io::SceneTarget::colmap, downscale == 1, out), "");
    const Scene scene = io::read_scene(root / out, {});
    ASSERT_EQ(scene.views.size(), 5u);
    EXPECT_EQ(scene.views[0].photo, root / out / "images/cam.001.png");
    EXPECT_EQ(scene.views[1].photo, root / out / "images/cam.002.png");
    EXPECT_EQ(scene.views[2].photo, root / out / "images/north/cam.002.png");
    EXPECT_EQ(scene.views[3].photo, root / out / "images/x.png");
    EXPECT_EQ(scene.views[4].photo, root / out / "images/y.JPG");
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(io::read_image(scene.views[i].photo).at(20 / downscale, 15 / downscale)[0], 50 + 50 * i) << i;
  }
  project.downscale = 1;
  EXPECT_EQ(project.convert(io::SceneTarget::cam, true, "cam"), "");
  with_photos({"a.tif", "a.png"});
  for (const io::SceneTarget target : {io::SceneTarget::colmap, io::SceneTarget::mvs})
    EXPECT_TRUE(
        test::contains(project.convert(target, true, "meeting"), "images/a.png: two photos would need this name"));
  EXPECT_FALSE(fs::exists(root / "meeting"));
  EXPECT_EQ(project.convert(io::SceneTarget::colmap, false, "copied"), "");
}

// The photos keep their names, so that a folder of the scene itself would lose its own.
TEST(Convert, ReplacesNothingThatItReads) {
  SmallProject project;
  const fs::path photo = project.folder.path() / "images" / "a.png";
  const std::string before = test::read_file(photo);
  const std::size_t files = project.folder.count();
  for (const bool force : {false, true}) {
    EXPECT_TRUE(test::contains(project.convert(io::SceneTarget::cam, true, "images", force), "belongs to the scene"));
    EXPECT_TRUE(test::contains(project.convert(io::SceneTarget::colmap, true, "", force), "belongs to the scene"));
  }
  EXPECT_EQ(test::read_file(photo), before);
  EXPECT_EQ(project.folder.count(), files);
}

TEST(Convert, NeverReplacesSomebodysFiles) {
  SmallProject project;
  const fs::path theirs = project.folder.write("out/scene.mvs", "theirs");
  for (const bool force : {false, true})
    EXPECT_TRUE(
        test::contains(project.convert(io::SceneTarget::mvs, true, "out", force), "scene.mvs: would be replaced"));
  EXPECT_EQ(test::read_file(theirs), "theirs");
}

/// Name and bytes of every file below a folder.
std::map<std::string, std::string> files_below(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().string()] = test::read_file(entry.path());
  return files;
}

// Neither by files of the same name, nor by the removal of what an earlier run has listed, nor by a second model in the
// folder of the first.
TEST(Convert, LeavesTheSceneItReadsAsItIs) {
  SmallProject project;
  ASSERT_EQ(project.convert(io::SceneTarget::mvs, true, "mvs"), "");
  ASSERT_EQ(project.convert(io::SceneTarget::cam, true, "cam"), "");
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, true, "model"), "");
  const auto before = files_below(project.folder.path());
  const auto refused = [&](const fs::path& scene, io::SceneTarget target, const fs::path& out) {
    project.scene = scene;
    return project.convert(target, true, out, true);
  };
  EXPECT_TRUE(test::contains(refused("mvs/scene.mvs", io::SceneTarget::mvs, "mvs"), "belongs to the scene"));
  EXPECT_TRUE(test::contains(refused("mvs", io::SceneTarget::colmap, "mvs"), "belongs to the scene"));
  EXPECT_TRUE(test::contains(refused("cam", io::SceneTarget::cam, "cam"), "would be written into the folder"));
  EXPECT_TRUE(test::contains(refused("cam", io::SceneTarget::mvs, "cam"), "would be written into the folder"));
  EXPECT_TRUE(test::contains(refused("model", io::SceneTarget::mvs, "model"), "belongs to the scene"));
  EXPECT_TRUE(test::contains(refused("model/sparse", io::SceneTarget::colmap, "model"), "would be written into"));
  project.scene = "colmap";
  fs::create_directory_symlink(project.folder.path() / "colmap", project.folder.path() / "sparse");
  EXPECT_TRUE(test::contains(project.convert(io::SceneTarget::colmap, true, "", true), "would be written into"));
  fs::remove(project.folder.path() / "sparse");
  EXPECT_EQ(files_below(project.folder.path()), before);
}

// --- frames of undistorted photos

std::vector<Camera> distorted_cameras() {
  std::vector<Camera> cameras;
  const auto add = [&](const Distortion& distortion) {
    cameras.push_back({400, 300, 350, 355, 210, 144, distortion});
    limit_distortion(cameras.back());
  };
  add({.k1 = -0.2, .k2 = 0.05, .model = LensModel::brown});
  add({.k1 = 0.15, .model = LensModel::brown});
  add({.k1 = -0.1, .p1 = 0.01, .p2 = -0.02, .model = LensModel::brown});
  add({.k1 = -0.9, .model = LensModel::brown});  // folds within the photo
  add({.k1 = -0.1, .model = LensModel::perspective, .d1 = 0.05, .skew = 0.01});
  add({.k1 = 0.02, .model = LensModel::equidistant});
  add({.model = LensModel::fov, .omega = 0.9});
  return cameras;
}

TEST(FrameWindow, InsideShowsThePhotoEverywhereAndNoMoreFits) {
  for (const Camera& camera : distorted_cameras()) {
    const pipeline::FrameWindow w = pipeline::frame_window(camera, pipeline::FrameRule::inside);
    ASSERT_GT(w.width, camera.width / 2);
    ASSERT_GT(w.height, camera.height / 2);
    for (int y = w.y; y < w.y + w.height; ++y)
      for (int x = w.x; x < w.x + w.width; ++x) ASSERT_TRUE(in_photo(camera, {x + 0.5, y + 0.5})) << x << ", " << y;
  }
  const Camera barrel = distorted_cameras()[0], pincushion = distorted_cameras()[1];
  const pipeline::FrameWindow wide = pipeline::frame_window(barrel, pipeline::FrameRule::inside),
                              narrow = pipeline::frame_window(pincushion, pipeline::FrameRule::inside);
  EXPECT_GT(wide.width, barrel.width);
  EXPECT_LT(narrow.width, pincushion.width);
  // One more column to the left is blank somewhere, though not at the corners alone.
  bool blank = false;
  for (int y = 0; y < barrel.height; ++y) blank = blank || !in_photo(barrel, {wide.x - 0.5, y + 0.5});
  EXPECT_TRUE(blank);
}

TEST(FrameWindow, AllKeepsEveryPixelOfThePhotoWithinBounds) {
  for (const Camera& camera : distorted_cameras()) {
    const pipeline::FrameWindow w = pipeline::frame_window(camera, pipeline::FrameRule::all);
    EXPECT_LE(w.width, 2 * camera.width);
    EXPECT_LE(w.height, 2 * camera.height);
    std::size_t beyond = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const auto p = pixel_from_photo(camera, {x + 0.5, y + 0.5});
        beyond += !p || p->x < w.x || p->y < w.y || p->x > w.x + w.width || p->y > w.y + w.height;
      }
    // Only what the model shows nowhere, behind its fold, is left out.
    if (camera.distortion.k1 > -0.5) {
      EXPECT_EQ(beyond, 0u);
    }
  }
}

TEST(FrameWindow, CentredOnesKeepTheirRulesAndDirections) {
  std::vector<Camera> cameras = distorted_cameras();
  cameras.push_back({400, 300, 350, 355, 210, 144, {}});
  cameras.push_back({400, 300, 360, 340, 190, 150, {}});
  for (const Camera& camera : cameras)
    for (const pipeline::FrameRule rule :
         {pipeline::FrameRule::inside, pipeline::FrameRule::keep, pipeline::FrameRule::all}) {
      const pipeline::FrameWindow w = pipeline::frame_window(camera, rule, true);
      const Camera square = pipeline::camera_of_window(camera, w);
      EXPECT_EQ(io::lost_term(io::SceneTarget::nvm, square), std::nullopt);
      ASSERT_GT(w.width, camera.width / 2);
      ASSERT_LE(w.width, 2 * camera.width);
      ASSERT_LE(w.height, 2 * camera.height);
      for (int y = 0; y < w.height; ++y)
        for (int x = 0; x < w.width; ++x) {
          const PixelPoint p = pipeline::frame_position(camera, w, x, y);
          ASSERT_NEAR((p.x - camera.cx) / camera.fx, (x + 0.5 - square.cx) / square.fx, 1e-12);
          ASSERT_NEAR((p.y - camera.cy) / camera.fy, (y + 0.5 - square.cy) / square.fy, 1e-12);
          if (rule == pipeline::FrameRule::inside) {
            ASSERT_TRUE(in_photo(camera, p)) << x << ", " << y;
          }
        }
      if (rule != pipeline::FrameRule::all || camera.distortion.k1 < -0.5) continue;
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
          const auto p = pixel_from_photo(camera, {x + 0.5, y + 0.5});
          ASSERT_TRUE(p);
          ASSERT_LE(std::abs((p->x - camera.cx) / camera.fx * square.fx), w.width / 2.0);
          ASSERT_LE(std::abs((p->y - camera.cy) / camera.fy * square.fy), w.height / 2.0);
        }
    }
}

TEST(FrameWindow, IsThePhotosOwnOtherwise) {
  const Camera camera = distorted_cameras()[0];
  const pipeline::FrameWindow own{0, 0, camera.width, camera.height};
  EXPECT_EQ(pipeline::frame_window(camera, pipeline::FrameRule::keep), own);
  for (const pipeline::FrameRule rule :
       {pipeline::FrameRule::inside, pipeline::FrameRule::keep, pipeline::FrameRule::all}) {
    const pipeline::FrameWindow window = pipeline::frame_window(pinhole(), rule);
    EXPECT_EQ(window, (pipeline::FrameWindow{0, 0, 96, 72}));
    EXPECT_EQ(pipeline::camera_of_window(pinhole(), window), pinhole());
  }
}

// The same direction lies at the same place of the scene, whichever frame shows it.
TEST(Convert, FramesMoveThePrincipalPointAlone) {
  SmallProject project;
  for (const pipeline::FrameRule rule :
       {pipeline::FrameRule::keep, pipeline::FrameRule::inside, pipeline::FrameRule::all}) {
    project.frame = rule;
    const std::string out = "frame " + std::to_string(static_cast<int>(rule));
    ASSERT_EQ(project.convert(io::SceneTarget::colmap, true, out), "");
    const Scene scene = io::read_scene(project.folder.path() / out, {});
    const Camera& camera = scene.views[0].camera;
    EXPECT_EQ(camera.fx, 35);
    Camera lens{40, 30, 35, 35, 20, 15, {.k1 = -0.1, .k2 = 0.01}};
    limit_distortion(lens);
    const pipeline::FrameWindow window = pipeline::frame_window(lens, rule);
    EXPECT_EQ(camera, pipeline::camera_of_window(lens, window));
    EXPECT_EQ(io::read_image(scene.views[0].photo).width, window.width);
    // A barrel leaves the middles of the sides blank when its corners are kept.
    EXPECT_EQ(pipeline::shows_blank(lens, window), rule == pipeline::FrameRule::all);
    EXPECT_EQ(fs::exists(project.folder.path() / out / "masks/a.png.png"), rule == pipeline::FrameRule::all);
  }
}

// --- masks

/// A project whose first photo has a mask with a block that excludes.
struct MaskedProject : SmallProject {
  MaskedProject() {
    Image mask{40, 30, 1, std::vector<std::uint8_t>(40 * 30, 255)};
    for (int y = 8; y < 19; ++y)
      for (int x = 5; x < 17; ++x) *mask.at(x, y) = 0;
    io::write_image(folder.path() / "images" / "a.mask.png", mask, io::ImageFormat::png, 0);
    // What is excluded differs in colour, so that painting over or mixing would show.
    Image photo{40, 30, 3, std::vector<std::uint8_t>(3 * 40 * 30, 100)};
    for (int y = 8; y < 19; ++y)
      for (int x = 5; x < 17; ++x) std::fill_n(photo.at(x, y), 3, std::uint8_t{250});
    io::write_image(folder.path() / "images" / "a.png", photo, io::ImageFormat::png, 0);
  }
};

TEST(Convert, CarriesMasksToWhereProgramsLookForThem) {
  MaskedProject project;
  const fs::path root = project.folder.path();
  const std::string mask = test::read_file(root / "images/a.mask.png");
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, false, "copied"), "");
  EXPECT_EQ(test::read_file(root / "copied/masks/a.png.png"), mask);
  EXPECT_FALSE(fs::exists(root / "copied/masks/b c.png.png"));
  EXPECT_EQ(test::read_file(root / "copied/images/a.png"), test::read_file(root / "images/a.png"));

  ASSERT_EQ(project.convert(io::SceneTarget::mvs, true, "mvs"), "");
  EXPECT_TRUE(io::read_exclusion(io::read_scene(root / "mvs", {}).views[0]));
  EXPECT_TRUE(fs::exists(root / "mvs/images/a.mask.png"));
  EXPECT_FALSE(fs::exists(root / "mvs/images/b c.mask.png"));

  ASSERT_EQ(project.convert(io::SceneTarget::cam, true, "cam"), "");
  for (const auto& entry : fs::directory_iterator(root / "cam"))
    EXPECT_EQ(entry.path().string().find("mask"), std::string::npos) << entry.path();
}

// COLMAP and OpenMVS take a mask for the PNG that its name says, and look at its colours alone.
TEST(Convert, WritesMasksThatAreNoPlainPngAnew) {
  MaskedProject project;
  const fs::path root = project.folder.path(), mask = root / "images/a.mask.png";
  Image alpha{40, 30, 4, std::vector<std::uint8_t>(4 * 40 * 30, 255)};
  for (int x = 0; x < 40; ++x) alpha.at(x, 29)[3] = 0;
  Image jpeg{40, 30, 1, std::vector<std::uint8_t>(40 * 30, 255)};
  for (int y = 8; y < 16; ++y)
    for (int x = 16; x < 24; ++x) *jpeg.at(x, y) = 0;
  for (const bool is_jpeg : {false, true}) {
    io::write_image(mask, is_jpeg ? jpeg : alpha, is_jpeg ? io::ImageFormat::jpg : io::ImageFormat::png, 100);
    io::SceneOptions options;
    options.images_dir = root / "images";
    const auto expected = io::read_exclusion(io::read_scene(root / "colmap", options).views[0]);
    ASSERT_TRUE(expected);
    const std::string out = is_jpeg ? "of jpeg" : "of alpha";
    ASSERT_EQ(project.convert(io::SceneTarget::colmap, false, out), "");
    const fs::path written = root / out / "masks/a.png.png";
    EXPECT_TRUE(test::read_file(written).starts_with("\x89PNG"));
    const Image image = io::read_image(written);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) ASSERT_EQ(image.at(x, y)[0], expected->excludes(x, y) ? 0 : 255) << x << ", " << y;
  }
}

TEST(Convert, UndistortsMasksSoThatNoExcludedColorIsLeft) {
  for (const pipeline::FrameRule rule :
       {pipeline::FrameRule::keep, pipeline::FrameRule::inside, pipeline::FrameRule::all}) {
    MaskedProject project;
    project.frame = rule;
    ASSERT_EQ(project.convert(io::SceneTarget::colmap, true, "out"), "");
    io::SceneOptions options;
    options.masks_dir = project.folder.path() / "out/masks";
    const View view = io::read_scene(project.folder.path() / "out", options).views[0];
    const auto exclusion = io::read_exclusion(view);
    ASSERT_TRUE(exclusion);
    const Image photo = io::read_image(view.photo);
    std::size_t used = 0, bright = 0;
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x) {
        bright += photo.at(x, y)[0] == 250;
        if (exclusion->excludes(x, y)) continue;
        ++used;
        ASSERT_EQ(photo.at(x, y)[0], 100) << x << ", " << y;
      }
    EXPECT_GT(used, 40u * 30u / 2);
    EXPECT_GT(bright, 80u) << "photos are written whole, not painted over";
  }
}

TEST(Convert, MakesMasksOfAlphaAndOfReducedPhotos) {
  MaskedProject project;
  Image alpha{40, 30, 4, std::vector<std::uint8_t>(4 * 40 * 30, 200)};
  for (int x = 0; x < 40; ++x) alpha.at(x, 29)[3] = 0;
  io::write_image(project.folder.path() / "images" / "b c.png", alpha, io::ImageFormat::png, 0);
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, false, "copied"), "");
  const Image mask = io::read_image(project.folder.path() / "copied/masks/b c.png.png");
  EXPECT_EQ(mask.at(20, 28)[0], 255);
  EXPECT_EQ(mask.at(20, 29)[0], 0);
  project.downscale = 2;
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, false, "reduced"), "");
  const Image reduced = io::read_image(project.folder.path() / "reduced/masks/a.png.png");
  ASSERT_EQ(reduced.width, 20);
  EXPECT_EQ(reduced.at(2, 4)[0], 0) << "of a block that the mask touches";
  EXPECT_EQ(reduced.at(1, 4)[0], 255);
}

}  // namespace
}  // namespace gpvc
