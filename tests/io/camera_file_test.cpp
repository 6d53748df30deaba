// COLMAP's cameras and poses in both of its encodings, and what read_scene() says of what is no scene.
#include <cmath>
#include <random>

#include "io/scene_files.h"
#include "tests/io/colmap_folder.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::bytes_of;
using test::ColmapFolder;
using test::contains;
using test::images_bin;
using test::input_error;
using test::kCameras;
using test::kFrameHeight;
using test::kFrameWidth;
using test::kImages;
using test::kQuarterTurn;
using test::replaced;
using test::TemporaryFolder;
using test::TestCamera;
using test::TestImage;

void expect_point(const View& view, const WorldPoint& world, double x, double y) {
  const CameraPoint camera = camera_from_world(view.pose, world);
  ASSERT_GT(camera.z, 0);
  const auto photo = photo_from_pixel(view.camera, pixel_from_camera(view.camera, camera));
  ASSERT_TRUE(photo);
  EXPECT_NEAR(photo->x, x, 1e-9);
  EXPECT_NEAR(photo->y, y, 1e-9);
}

class Colmap : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Encoding, Colmap, testing::Values(true, false),
                         [](const auto& chosen) { return chosen.param ? "Binary" : "Text"; });

TEST_P(Colmap, OrdersViewsByNameBytewise) {
  ColmapFolder files;
  const Scene scene = read_scene(files.model(GetParam()), {});
  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_EQ(scene.views[0].name, "a with blank.png");
  EXPECT_EQ(scene.views[1].name, "b/One.png");
  EXPECT_EQ(scene.views[2].name, "b/two.png");
  for (const View& view : scene.views) EXPECT_TRUE(std::filesystem::exists(view.photo));
}

TEST_P(Colmap, ProjectsKnownPointsToKnownPixels) {
  ColmapFolder files;
  const Scene scene = read_scene(files.model(GetParam()), {});
  // PINHOLE, no rotation, t = (1, 2, 3): (0, -1, 1) is (1, 1, 4) in the camera.
  expect_point(scene.views[2], {0, -1, 1}, 50 * 0.25 + 33, 51 * 0.25 + 25);
  EXPECT_EQ(scene.views[2].pose.centre, (WorldPoint{-1, -2, -3}));
  // OPENCV, quarter turn: the world's (-19, 9, -10) is (-9 + 10, -19 + 20, 20) = (1, 1, 20).
  const double x = 0.05, r2 = 2 * x * x, radial = 1 - 0.1 * r2 + 0.02 * r2 * r2;
  const double dx = x * radial + 2 * 0.001 * x * x - 0.002 * (r2 + 2 * x * x);
  const double dy = x * radial + 0.001 * (r2 + 2 * x * x) - 2 * 0.002 * x * x;
  expect_point(scene.views[0], {-19, 9, -10}, 50 * dx + 33, 51 * dy + 25);
}

// Every model, the point (0.4, -0.3, 1) of the camera: r = 0.5. Formulas from COLMAP's list of camera models.
TEST_P(Colmap, ReadsEveryCameraModel) {
  const double x = 0.4, y = -0.3, k1 = 0.2, k2 = -0.3, p1 = 0.01, p2 = 0.02, r2 = 0.25;
  const double theta = std::atan(0.5), t2 = theta * theta, u = x * theta / 0.5, v = y * theta / 0.5;
  struct Expected {
    TestCamera camera;
    double fy, x, y;
  };
  const auto radial = [&](double a, double b) { return 1 + a * r2 + b * r2 * r2; };
  const auto angular = [&](double a, double b) { return 1 + a * t2 + b * t2 * t2; };
  const double rational =
      (1 + k1 * r2 + k2 * r2 * r2 + 0.1 * r2 * r2 * r2) / (1 + 0.4 * r2 + 0.5 * r2 * r2 + 0.6 * r2 * r2 * r2);
  const double fisheye = angular(k1, k2) + 0.1 * t2 * t2 * t2 + 0.4 * t2 * t2 * t2 * t2;
  const double fov = std::atan(2 * 0.5 * std::tan(0.45)) / 0.9 / 0.5;
  const double tx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x), ty = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  const double tu = 2 * p1 * u * v + p2 * (t2 + 2 * u * u), tv = p1 * (t2 + 2 * v * v) + 2 * p2 * u * v;
  const double divided = 2 / (1 + std::sqrt(1 - 4 * k1 * r2)), unified = 1 / (0.6 * std::sqrt(1.1 * r2 + 1) + 0.4);
  const double six = fisheye + 0.5 * std::pow(t2, 5) + 0.6 * std::pow(t2, 6), a = u * six, b = v * six,
               b2 = a * a + b * b;
  const std::vector<Expected> models{
      {{1, 0, "SIMPLE_PINHOLE", {50, 33, 25}}, 50, x, y},
      {{1, 1, "PINHOLE", {50, 60, 33, 25}}, 60, x, y},
      {{1, 2, "SIMPLE_RADIAL", {50, 33, 25, k1}}, 50, x * radial(k1, 0), y * radial(k1, 0)},
      {{1, 3, "RADIAL", {50, 33, 25, k1, k2}}, 50, x * radial(k1, k2), y * radial(k1, k2)},
      {{1, 4, "OPENCV", {50, 60, 33, 25, k1, k2, p1, p2}}, 60, x * radial(k1, k2) + tx, y * radial(k1, k2) + ty},
      {{1, 5, "OPENCV_FISHEYE", {50, 60, 33, 25, k1, k2, 0.1, 0.4}}, 60, u * fisheye, v * fisheye},
      {{1, 6, "FULL_OPENCV", {50, 60, 33, 25, k1, k2, p1, p2, 0.1, 0.4, 0.5, 0.6}},
       60,
       x * rational + tx,
       y * rational + ty},
      {{1, 7, "FOV", {50, 60, 33, 25, 0.9}}, 60, x * fov, y * fov},
      {{1, 8, "SIMPLE_RADIAL_FISHEYE", {50, 33, 25, k1}}, 50, u * angular(k1, 0), v * angular(k1, 0)},
      {{1, 9, "RADIAL_FISHEYE", {50, 33, 25, k1, k2}}, 50, u * angular(k1, k2), v * angular(k1, k2)},
      {{1, 10, "THIN_PRISM_FISHEYE", {50, 60, 33, 25, k1, k2, p1, p2, 0.1, 0.4, 0.03, 0.05}},
       60,
       u * fisheye + tu + 0.03 * t2,
       v * fisheye + tv + 0.05 * t2},
      {{1,
        11,
        "RAD_TAN_THIN_PRISM_FISHEYE",
        {50, 60, 33, 25, k1, k2, 0.1, 0.4, 0.5, 0.6, p1, p2, 0.03, 0.05, 0.07, 0.02}},
       60,
       a + p1 * (b2 + 2 * a * a) + 2 * p2 * a * b + 0.03 * b2 + 0.05 * b2 * b2,
       b + p2 * (b2 + 2 * b * b) + 2 * p1 * a * b + 0.07 * b2 + 0.02 * b2 * b2},
      {{1, 12, "SIMPLE_DIVISION", {50, 33, 25, k1}}, 50, x * divided, y * divided},
      {{1, 13, "DIVISION", {50, 60, 33, 25, k1}}, 60, x * divided, y * divided},
      {{1, 16, "EUCM", {50, 60, 33, 25, 0.6, 1.1}}, 60, x * unified, y * unified},
      {{1, 14, "SIMPLE_FISHEYE", {50, 33, 25}}, 50, u, v},
      {{1, 15, "FISHEYE", {50, 60, 33, 25}}, 60, u, v}};
  const std::vector<TestImage> one{{1, {1, 0, 0, 0}, {0, 0, 0}, 1, "one.png"}};
  for (const Expected& model : models) {
    ColmapFolder files(one);
    const Scene scene = read_scene(files.model(GetParam(), {model.camera}, one), {});
    SCOPED_TRACE(model.camera.model_name);
    expect_point(scene.views[0], {x, y, 1}, 50 * model.x + 33, model.fy * model.y + 25);
  }
}

TEST(ColmapEncodings, Agree) {
  ColmapFolder files;
  const Scene binary = read_scene(files.model(true), {}), text = read_scene(files.model(false), {});
  ASSERT_EQ(binary.views.size(), text.views.size());
  for (std::size_t i = 0; i < binary.views.size(); ++i) {
    EXPECT_EQ(binary.views[i].name, text.views[i].name);
    EXPECT_EQ(binary.views[i].photo, text.views[i].photo);
    EXPECT_EQ(binary.views[i].camera, text.views[i].camera);
    EXPECT_EQ(binary.views[i].pose.rotation, text.views[i].pose.rotation);
    EXPECT_EQ(binary.views[i].pose.centre, text.views[i].pose.centre);
  }
}

TEST_P(Colmap, ComputesAnOrthonormalRotation) {
  ColmapFolder files;
  for (const View& view : read_scene(files.model(GetParam()), {}).views) {
    const auto& r = view.pose.rotation;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        EXPECT_NEAR(r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2], i == j, 1e-15);
    EXPECT_NEAR(
        r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]), 1,
        1e-15);
  }
}

TEST_P(Colmap, FindsTheModelBelowARootAndPhotosBesideIt) {
  ColmapFolder files;
  const auto model = files.model(GetParam());
  const auto root = files.folder.path();
  for (const auto& source : {root, root / "", root / "sparse", model, model / "."}) {
    const Scene scene = read_scene(source, {});
    EXPECT_EQ(scene.source, source);
    EXPECT_EQ(scene.views.size(), 3) << source;
    EXPECT_TRUE(std::filesystem::equivalent(scene.views[0].photo, root / "images" / "a with blank.png"));
  }
  std::filesystem::rename(root / "images", root / "elsewhere");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), (root / "images").string()));
  EXPECT_EQ(read_scene(model, {.images_dir = root / "elsewhere"}).views.size(), 3);
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {.images_dir = root / "nowhere"}); }), "is not a folder"));
}

// COLMAP's mapper numbers the pieces it could not join; the first is often a fragment.
TEST_P(Colmap, TakesTheLargestOfSeveralModels) {
  ColmapFolder files;
  const auto root = files.folder.path();
  const auto model = [&](const std::string& number, const std::vector<TestImage>& images) {
    files.model(GetParam(), kCameras, images);
    std::filesystem::rename(root / "sparse/0", root / "sparse" / number);
  };
  model("2", {kImages[0], kImages[1]});
  model("10", {kImages[1], kImages[2]});
  files.model(GetParam(), kCameras, {kImages[2]});
  for (const auto& source : {root, root / "sparse"}) {
    const Scene scene = read_scene(source, {});
    EXPECT_EQ(scene.views.size(), 2) << source;
    EXPECT_EQ(scene.views.back().name, "b/two.png");  // a tie goes to the lower number
    ASSERT_EQ(scene.warnings.size(), 1);
    EXPECT_EQ(scene.warnings[0],
              "the folder holds 3 models; the largest, 2, of 2 images, is read, the others cannot be brought "
              "into its frame");
  }
  for (const char* named : {"sparse/0", "sparse/10"}) EXPECT_TRUE(read_scene(root / named, {}).warnings.empty());
  EXPECT_EQ(read_scene(root / "sparse/0", {}).views.size(), 1);
  // One model is one, whatever its number.
  std::filesystem::remove_all(root / "sparse/0");
  std::filesystem::remove_all(root / "sparse/2");
  EXPECT_EQ(read_scene(root, {}).views.front().name, "a with blank.png");
  EXPECT_TRUE(read_scene(root, {}).warnings.empty());
}

TEST_P(Colmap, ReducesCamerasExactly) {
  ColmapFolder files;
  const auto model = files.model(GetParam());
  const Scene full = read_scene(model, {}), fifth = read_scene(model, {.downscale = 5});
  for (std::size_t i = 0; i < full.views.size(); ++i) {
    const Camera &a = full.views[i].camera, &b = fifth.views[i].camera;
    EXPECT_EQ(b.width, 12);  // 64 / 5 and 48 / 5, cut
    EXPECT_EQ(b.height, 9);
    const CameraPoint point{0.3, -0.2, 1};
    const auto p = photo_from_pixel(a, pixel_from_camera(a, point)),
               q = photo_from_pixel(b, pixel_from_camera(b, point));
    EXPECT_NEAR(p->x / 5, q->x, 1e-12);
    EXPECT_NEAR(p->y / 5, q->y, 1e-12);
  }
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {.downscale = 49}); }), "too small"));
}

TEST_P(Colmap, NamesAllMissingPhotos) {
  ColmapFolder files;
  const auto model = files.model(GetParam());
  std::filesystem::remove(files.folder.path() / "images/b/two.png");
  const std::string one = input_error([&] { read_scene(model, {}); });
  EXPECT_TRUE(contains(one, "1 of 3 photos are not in"));
  EXPECT_TRUE(contains(one, ": b/two.png"));
  std::vector<TestImage> many;
  for (std::uint32_t i = 0; i < 9; ++i)
    many.push_back({i, {1, 0, 0, 0}, {0, 0, 0}, 7, std::string("m").append(std::to_string(i))});
  const std::string nine = input_error([&] { read_scene(files.model(GetParam(), kCameras, many), {}); });
  EXPECT_TRUE(contains(nine, "9 of 9"));
  EXPECT_TRUE(contains(nine, "m0, m1, m2, m3, m4, m5, m6, m7, m8"));
}

TEST_P(Colmap, RefusesPhotosOfAnotherSizeAndBrokenOnes) {
  ColmapFolder files;
  const auto model = files.model(GetParam());
  files.photo("b/two.png", kFrameWidth, kFrameHeight + 1);
  const std::string error = input_error([&] { read_scene(model, {}); });
  EXPECT_TRUE(contains(error, "b/two.png (is 64 x 49 pixels"));
  EXPECT_TRUE(contains(error, "64 x 48"));
  files.folder.write("images/b/two.png", "no image");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "b/two.png (is no image"));
}

TEST_P(Colmap, RefusesWhatIsNoScene) {
  ColmapFolder files;
  const auto refused = [&](const std::vector<TestCamera>& cameras, const std::vector<TestImage>& images) {
    return input_error([&] { read_scene(files.model(GetParam(), cameras, images), {}); });
  };
  const auto with = [](auto values, const auto& change) {
    change(values.back());
    return values;
  };
  EXPECT_TRUE(contains(refused({kCameras[0], {3, 17, "EQUIRECTANGULAR", {64, 32}}}, kImages),
                       "the parameters of a panorama are not its width and height"));
  EXPECT_TRUE(contains(refused(with(kCameras,
                                    [](TestCamera& c) {
                                      c = {3, 16, "EUCM", {50, 51, 33, 25, 1.5, 1}};
                                    }),
                               kImages),
                       "alpha"));
  EXPECT_TRUE(contains(refused(with(kCameras,
                                    [](TestCamera& c) {
                                      c = {3, 7, "FOV", {50, 51, 33, 25, 0}};
                                    }),
                               kImages),
                       "omega"));
  EXPECT_TRUE(contains(refused({{7, 99, "KALEIDOSCOPE", {1}}}, kImages), "is unknown; supported are SIMPLE_PINHOLE, "));
  EXPECT_TRUE(contains(refused({kCameras[0]}, kImages), "refers to camera 3"));
  EXPECT_TRUE(contains(refused(with(kCameras, [](TestCamera& c) { c.parameters[0] = 0; }), kImages), "focal"));
  EXPECT_TRUE(
      contains(refused(with(kCameras, [](TestCamera& c) { c.parameters[4] = std::nan(""); }), kImages), "finite"));
  EXPECT_TRUE(contains(refused(kCameras, with(kImages, [](TestImage& i) { i.q = {0, 0, 0, 0}; })), "no direction"));
  EXPECT_TRUE(contains(refused(kCameras, with(kImages, [](TestImage& i) { i.q[2] = std::nan(""); })), "no direction"));
  EXPECT_TRUE(contains(refused(kCameras, with(kImages, [](TestImage& i) { i.t[2] = std::nan(""); })), "translation"));
  EXPECT_TRUE(contains(refused(kCameras, with(kImages, [](TestImage& i) { i.name = "b/two.png"; })), "twice"));
  EXPECT_TRUE(contains(refused(kCameras, with(kImages, [](TestImage& i) { i.id = 9; })), "image number 9 is taken"));
  std::vector<TestCamera> twice = kCameras;
  twice.push_back(kCameras[0]);
  EXPECT_TRUE(contains(refused(twice, kImages), "camera number 7 is taken"));
  EXPECT_TRUE(contains(refused(kCameras, {}), "lists no image"));
  // Cameras no image uses need not be understood.
  EXPECT_NO_THROW(read_scene(files.model(GetParam(), with(kCameras, [](TestCamera&) {}), kImages), {}));
  std::vector<TestCamera> more = kCameras;
  more.push_back({8, 17, "EQUIRECTANGULAR", {1, 1}});
  EXPECT_NO_THROW(read_scene(files.model(GetParam(), more, kImages), {}));
}

TEST(ColmapFolders, SaysWhatItExpected) {
  const TemporaryFolder folder;
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.write("a/cameras.txt", ""), {}); }),
                       "is part of a COLMAP model: the folder holds a COLMAP model without images.txt"));
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path() / "absent", {}); }), "does not exist"));
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.write("file", "x"), {}); }), "is no scene"));
}

TEST(ColmapFolders, NameWhatAModelLacksFromEachFolderAbove) {
  const TemporaryFolder folder;
  folder.write("p/sparse/0/cameras.txt", "1 PINHOLE 400 300 360 360 200 150\n");
  for (const char* given : {"p", "p/sparse", "p/sparse/0"})
    EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path() / given, {}); }), "without images.txt")) << given;
}

TEST(SceneFiles, NamesASceneOneFolderAboveOrBelow) {
  const TemporaryFolder folder;
  folder.write("p/model/cameras.txt", "1 PINHOLE 400 300 360 360 200 150\n");
  folder.write("p/model/images.txt", "1 1 0 0 0 0 0 0 1 p.jpg\n\n");
  folder.write("p/model/images/p.jpg", "");
  const std::string named = "p/model is one (COLMAP); give that";
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path() / "p", {}); }), named));
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path() / "p/model/images", {}); }), named));
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path() / "p/model/images/", {}); }), named));
}

TEST(SceneFiles, NamesThePosesOfLlff) {
  const TemporaryFolder folder;
  const auto file = folder.write("scene/poses_bounds.npy", "\x93NUMPY");
  for (const auto& source : {file, file.parent_path()})
    EXPECT_TRUE(contains(input_error([&] { read_scene(source, {}); }), "poses of LLFF (poses_bounds.npy)")) << source;
}

// Scripts that are run twice append frames again. Frames of one photo that differ are refused, as before.
TEST(SceneFiles, LeavesOutImagesThatAreListedAgain) {
  const TemporaryFolder folder;
  const std::string frame =
      R"({"file_path": "p.png", "transform_matrix": [[1, 0, 0, 10], [0, 1, 0, 20], [0, 0, 1, 100], [0, 0, 0, 1]]})";
  const auto read = [&](const std::string& frames) {
    return read_scene(folder.write("transforms.json", R"({"w": 40, "h": 30, "fl_x": 36, "frames": [)" + frames + "]}"),
                      {.allow_missing_photos = true});
  };
  const Scene scene = read(frame + ", " + frame + ", " + replaced(frame, "p.png", "q.png") + ", " + frame);
  EXPECT_EQ(scene.views.size(), 2u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], "2 images are left out that repeat others with the same camera and pose, as 'p.png'");
  EXPECT_TRUE(contains(input_error([&] { read(frame + ", " + replaced(frame, "10]", "10.5]")); }),
                       "lists the image 'p.png' twice"));
}

TEST(SceneFiles, SaysWhatAFileThatIsNoSceneLooksLike) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& name, std::string_view bytes) {
    return input_error([&] { read_scene(folder.write(name, bytes), {}); });
  };
  EXPECT_TRUE(contains(refusal("a.xml", ""), "a.xml: is empty: expected "));
  EXPECT_TRUE(contains(refusal("a.xml", "<?xml version='1.0'?><!-- x --><kml><Document/></kml>"),
                       "a.xml: is XML of another program, whose root is 'kml': expected "));
  EXPECT_TRUE(contains(refusal("a.json", "\n {\"type\": \"FeatureCollection\"}"), "is JSON of another program"));
  EXPECT_TRUE(contains(refusal("a.ply", "ply\nformat ascii 1.0\n"), "is a mesh; the scene goes before it"));
  EXPECT_TRUE(contains(refusal("a.jpg", "\xFF\xD8\xFF\xE0"), "is a photo"));
  EXPECT_TRUE(contains(refusal("a.xml", std::string_view("\xFF\xFE<\0k\0", 6)), "is text in UTF-16"));
}

/// Cameras and poses bit by bit, in order.
bool same_views(const Scene& a, const Scene& b) {
  return std::equal(a.views.begin(), a.views.end(), b.views.begin(), b.views.end(),
                    [](const View& one, const View& other) {
                      return one.name == other.name && one.camera == other.camera &&
                             one.pose.rotation == other.pose.rotation && one.pose.centre == other.pose.centre;
                    });
}

TEST_P(Colmap, RefusesFilesCutAtEveryByteOrWarns) {
  ColmapFolder files;
  const auto model = files.model(GetParam());
  const Scene whole = read_scene(model, {});
  for (const std::string name : {"cameras", "images"}) {
    const auto file = model / (name + (GetParam() ? ".bin" : ".txt"));
    const std::string good = test::read_file(file);
    std::size_t refused = 0;
    for (std::size_t size = 0; size < good.size(); ++size) {
      files.folder.write(std::filesystem::relative(file, files.folder.path()), good.substr(0, size));
      try {
        const Scene scene = read_scene(model, {});
        // A text file cut between two lines, or inside a last number that reads as a shorter one, differs from no file
        // that a hand wrote: there a warning is all. What follows the last image's name is not read.
        ASSERT_FALSE(GetParam()) << file << " at " << size;
        ASSERT_TRUE(!scene.warnings.empty() || same_views(scene, whole)) << file << " at " << size;
      } catch (const InputError&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, good.size() * 3 / 4);
    files.folder.write(std::filesystem::relative(file, files.folder.path()), good);
  }
}

// One byte changed anywhere: a scene of usable views, or an InputError.
TEST_P(Colmap, SurvivesEveryByteChanged) {
  ColmapFolder files;
  const auto model = files.model(GetParam());
  std::mt19937 random(3);
  for (const std::string name : {"cameras", "images"}) {
    const auto file = model / (name + (GetParam() ? ".bin" : ".txt"));
    const auto relative = std::filesystem::relative(file, files.folder.path());
    const std::string good = test::read_file(file);
    for (std::size_t at = 0; at < good.size(); ++at) {
      std::string bytes = good;
      bytes[at] = static_cast<char>(random());
      files.folder.write(relative, bytes);
      try {
        for (const View& view : read_scene(model, {}).views) {
          ASSERT_TRUE(view.camera.fx > 0 && view.camera.fy > 0);
          ASSERT_TRUE(std::isfinite(view.pose.centre.x + view.pose.centre.y + view.pose.centre.z));
          ASSERT_EQ(view.camera.width, kFrameWidth);
        }
      } catch (const InputError&) {
      }
    }
    files.folder.write(relative, good);
  }
}

TEST(ColmapBinary, RefusesHostileCounts) {
  ColmapFolder files;
  const auto model = files.model(true);
  for (const std::string name : {"cameras.bin", "images.bin"}) {
    const std::string good = test::read_file(model / name);
    for (const std::uint64_t count : {std::uint64_t{4}, std::uint64_t{1} << 60, ~std::uint64_t{0}}) {
      files.folder.write("sparse/0/" + name, bytes_of(count) + good.substr(8));
      EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "the file ends"));
    }
    files.folder.write("sparse/0/" + name, good);
  }
  std::string images = images_bin({kImages[0]});
  files.folder.write("sparse/0/images.bin", images.substr(0, images.size() - 8) + bytes_of(~std::uint64_t{0} / 8));
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "points"));
}

// A shift that doubles hold exactly moves the centre and nothing else.
TEST_P(Colmap, KeepsCentresOfFarAwayScenes) {
  const std::vector<TestImage> one{{1, kQuarterTurn, {-5400000.25, 500000.5, -128}, 7, "one.png"}};
  ColmapFolder files(one);
  const Scene scene = read_scene(files.model(GetParam(), kCameras, one), {});
  // x_camera = (-y, x, z) + t vanishes at y = t.x, x = -t.y, z = -t.z.
  EXPECT_NEAR(scene.views[0].pose.centre.x, -500000.5, 1e-8);
  EXPECT_NEAR(scene.views[0].pose.centre.y, -5400000.25, 1e-8);
  EXPECT_NEAR(scene.views[0].pose.centre.z, 128, 1e-8);
}

}  // namespace
}  // namespace gpvc::io
