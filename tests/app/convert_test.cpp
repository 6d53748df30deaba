// gpvc convert, run whole: what it writes is read back, and nothing is replaced that is not its own.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/cli/console.h"
#include "app/cli/options.h"
#include "app/pipeline/undistort.h"
#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/support/scene_folder.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiff_photo.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

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
    options.input.mesh = mesh;
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
  fs::path scene = "colmap", mesh;
  pipeline::FrameRule frame = pipeline::FrameRule::keep;
  int downscale = 1;
};

TEST(Convert, CopiesAllFilesOfAPhotosBands) {
  SmallProject project;
  project.folder.write("colmap/images.txt", "1 1 0 0 0 0 0 0 1 IMG_0001_1.tif\n\n2 1 0 0 0 1 0 0 1 IMG_0002_1.tif\n\n");
  Samples samples{40, 30, 1, SampleType::u16, std::vector<std::byte>(2 * 40 * 30)};
  BandSet set;
  set.bands = {{"Blue"}};
  for (const char* photo : {"IMG_0001", "IMG_0002"})
    for (int band = 1; band <= 3; ++band) {
      for (int pixel = 0; pixel < 40 * 30; ++pixel)
        store_sample(samples.bytes.data() + 2 * pixel, SampleType::u16, static_cast<float>(700 * band + pixel));
      io::write_samples(project.folder.path() / "images" / (std::string(photo) + "_" + std::to_string(band) + ".tif"),
                        samples, set);
    }
  EXPECT_EQ(project.convert(io::SceneTarget::colmap, false, "out"), "");
  for (const char* file : {"IMG_0001_3.tif", "IMG_0002_2.tif"})
    EXPECT_EQ(test::read_file(project.folder.path() / "out" / "images" / file),
              test::read_file(project.folder.path() / "images" / file));
  const Scene scene = io::read_scene(project.folder.path() / "out", {});
  ASSERT_TRUE(scene.bands);
  EXPECT_EQ(scene.bands->bands.size(), 3u);
}

// What a photo's file declares to be no data becomes black in the mask of the photo that is made of it.
TEST(Convert, MasksPixelsWithoutDataOfWhatItUndistorts) {
  SmallProject project;
  project.folder.write("colmap/images.txt", "1 1 0 0 0 0 0 0 1 a.tif\n\n2 1 0 0 0 1 0 0 1 b.tif\n\n");
  Samples samples{40, 30, 1, SampleType::u16, std::vector<std::byte>(2 * 40 * 30)};
  for (int pixel = 0; pixel < 40 * 30; ++pixel)
    store_sample(samples.bytes.data() + 2 * pixel, SampleType::u16, static_cast<float>(1000 + 20 * pixel));
  test::write_tiff(project.folder.path() / "images" / "b.tif", samples, {.nodata = "65535"});
  for (int y = 10; y < 20; ++y)
    for (int x = 12; x < 30; ++x) store_sample(samples.at(x, y), SampleType::u16, 65535);
  test::write_tiff(project.folder.path() / "images" / "a.tif", samples, {.nodata = "65535"});
  EXPECT_EQ(project.convert(io::SceneTarget::colmap, true, "out"), "");
  const Scene scene = io::read_scene(project.folder.path() / "out", {});
  ASSERT_EQ(scene.views.size(), 2u);
  EXPECT_FALSE(scene.views[0].mask.empty());
  EXPECT_TRUE(scene.views[1].mask.empty());
  const auto excluded = io::read_exclusion(scene.views[0]);
  ASSERT_TRUE(excluded);
  // The lens hardly moves the middle.
  EXPECT_TRUE(excluded->excludes(20, 15));
  EXPECT_TRUE(excluded->excludes(14, 12));
  EXPECT_FALSE(excluded->excludes(20, 5));
  EXPECT_FALSE(excluded->excludes(35, 15));
  const auto run = nlohmann::json::parse(test::read_file(project.folder.path() / "out" / "run.json"));
  EXPECT_EQ(run.at("counts").at("masks"), 1);
  // Reduced, as well.
  project.downscale = 2;
  EXPECT_EQ(project.convert(io::SceneTarget::colmap, false, "half"), "");
  const Scene half = io::read_scene(project.folder.path() / "half", {});
  ASSERT_FALSE(half.views[0].mask.empty());
  EXPECT_TRUE(io::read_exclusion(half.views[0])->excludes(10, 7));
  // Copies say themselves what they lack.
  project.downscale = 1;
  EXPECT_EQ(project.convert(io::SceneTarget::colmap, false, "copy"), "");
  const Scene copy = io::read_scene(project.folder.path() / "copy", {});
  EXPECT_TRUE(copy.views[0].mask.empty());
  io::PhotoCache photos(copy);
  ASSERT_TRUE(photos.exclusion(ViewId{0}));
  EXPECT_TRUE(photos.exclusion(ViewId{0})->excludes(20, 15));
}

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

// A camera 8 m above the ground flies 1 m while its photo of 64 x 64 pixels is read out: what the first row shows lies 4
// pixels farther left in the middle of the flight, what the last row shows as far right.
TEST(Convert, UndoesTheTravelOfRollingShuttersAboveAMesh) {
  SmallProject project;
  Image photo{64, 64, 3, std::vector<std::uint8_t>(std::size_t{64} * 64 * 3, 0)};
  for (int y = 0; y < 64; ++y) std::fill_n(photo.at(30, y), 4 * 3, std::uint8_t{255});
  io::write_image(project.folder.path() / "p.png", photo, io::ImageFormat::png, 0);
  const auto matrix = [](const char* x) {
    return std::string("[[1, 0, 0, ") + x + "], [0, 1, 0, 0], [0, 0, 1, 8], [0, 0, 0, 1]]";
  };
  project.folder.write("transforms.json", R"({"fl_x": 64, "fl_y": 64, "cx": 32, "cy": 32, "w": 64, "h": 64, "frames": [
    {"file_path": "p.png", "rolling_shutter": [0, 0, 1, 0], "transform_matrix_start": )" +
                                              matrix("-0.5") + ", \"transform_matrix_end\": " + matrix("0.5") + "}]}");
  project.folder.write("ground.obj", "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n");
  project.scene = "transforms.json";
  const auto middle_of_band = [&](const fs::path& out, int y) {
    const Image shown = io::read_image(project.folder.path() / out / "images" / "p.png");
    double sum = 0, weights = 0;
    for (int x = 0; x < shown.width; ++x) {
      sum += (x + 0.5) * *shown.at(x, y);
      weights += *shown.at(x, y);
    }
    return sum / weights;
  };
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, true, "alone"), "");
  EXPECT_NEAR(middle_of_band("alone", 0), 32, 0.1);
  project.mesh = project.folder.path() / "ground.obj";
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, true, "above"), "");
  EXPECT_NEAR(middle_of_band("above", 0), 28, 0.1);
  EXPECT_NEAR(middle_of_band("above", 32), 32, 0.1);
  EXPECT_NEAR(middle_of_band("above", 63), 36, 0.1);
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

// A panorama becomes six photos of 93 degrees, which show what it shows.
TEST(Convert, WritesPanoramasAsTheirViews) {
  SmallProject project;
  const fs::path root = project.folder.path();
  project.folder.write("colmap/cameras.txt", "1 EQUIRECTANGULAR 320 160 320 160\n");
  project.folder.write("colmap/images.txt", "1 1 0 0 0 0 0 0 1 north/a.png\n\n");
  // Levels are those of a direction: right, down and forward.
  Image photo{320, 160, 3, std::vector<std::uint8_t>(3 * 320 * 160)};
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 320; ++x) {
      const double pi = std::acos(-1), longitude = (x + 0.5) / 320 * 2 * pi - pi, down = (y + 0.5) / 160 * pi - pi / 2;
      const double direction[] = {std::cos(down) * std::sin(longitude), std::sin(down),
                                  std::cos(down) * std::cos(longitude)};
      for (std::size_t c = 0; c < 3; ++c)
        photo.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(128 + 120 * direction[c]));
    }
  fs::create_directories(root / "images/north");
  io::write_image(root / "images/north/a.png", photo, io::ImageFormat::png, 0);
  EXPECT_TRUE(test::contains(project.convert(io::SceneTarget::colmap, false, "other"), "a panorama's projection"));
  ASSERT_EQ(project.convert(io::SceneTarget::colmap, true, "out"), "");
  const Scene scene = io::read_scene(root / "out", {});
  ASSERT_EQ(scene.views.size(), 6u);
  for (const View& view : scene.views) {
    const Camera& camera = view.camera;
    EXPECT_TRUE(camera.distortion.is_identity());
    EXPECT_GT(camera.cx / camera.fx, 1) << view.name;  // 45 degrees to each side
    EXPECT_GT((camera.width - camera.cx) / camera.fx, 1) << view.name;
    EXPECT_GT(camera.cy / camera.fy, 1) << view.name;
    EXPECT_GT((camera.height - camera.cy) / camera.fy, 1) << view.name;
    const Image frame = io::read_image(view.photo);
    ASSERT_EQ(frame.width, camera.width);
    const auto& r = view.pose.rotation;
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const double dx = (x + 0.5 - camera.cx) / camera.fx, dy = (y + 0.5 - camera.cy) / camera.fy;
        const double length = std::sqrt(dx * dx + dy * dy + 1);
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(frame.at(x, y)[c], 128 + 120 * (r[c] * dx + r[3 + c] * dy + r[6 + c]) / length, 2)
              << view.name << ' ' << x << ' ' << y;
      }
  }
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
