#include "app/checks/frame_check.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>

#include "app/cli/view_lists.h"
#include "app/evaluate/scene_json.h"
#include "app/pipeline/pipeline.h"
#include "app/pipeline/viewpoint.h"
#include "io/lens_terms.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

using test::contains;
using test::input_error;

/// Looks down from (0, 0, 10) over [-5, 5] x [-5, 5] at z = 0.
Scene scene_above() {
  View view;
  view.name = "a.jpg";
  view.camera = {100, 100, 100, 100, 50, 50, {}};
  view.pose = {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 10}};
  Scene scene;
  scene.views.push_back(view);
  return scene;
}

Mesh triangle_at(double x, double y, double z, double size = 1) {
  Mesh mesh;
  mesh.positions = {{x, y, z}, {x + size, y, z}, {x, y + size, z}};
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

const std::vector<ViewId> kUsed{ViewId{0}};

std::string refusal(const Mesh& mesh, const Scene& scene = scene_above()) {
  return input_error([&] { checks::check_frames(mesh, "m.ply", scene, kUsed); });
}

TEST(FrameCheck, AcceptsOneFaceInOneFrame) {
  EXPECT_NO_THROW(checks::check_frames(triangle_at(0, 0, 0), "m.ply", scene_above(), kUsed));
  EXPECT_NO_THROW(checks::check_frames(triangle_at(4.9, 0, 0), "m.ply", scene_above(), kUsed));
  // A face larger than the frame has no corner in it.
  EXPECT_NO_THROW(checks::check_frames(triangle_at(-100, -100, 0, 1000), "m.ply", scene_above(), kUsed));
  Mesh far = triangle_at(1e6, 0, 0);
  for (int i = 0; i < 5000; ++i) far.faces.push_back(far.faces[0]);
  far.positions.push_back({0, 0, 0});
  far.faces.push_back({3, 3, 3});
  EXPECT_NO_THROW(checks::check_frames(far, "m.ply", scene_above(), kUsed));
}

TEST(FrameCheck, ExplainsWithBothBoxes) {
  EXPECT_TRUE(contains(refusal(triangle_at(500000, 20, 0)),
                       "m.ply: no photo sees any face, the mesh lies outside every frame: it spans x 500000.000 .. "
                       "500001.000, y 20.000 .. 21.000, z 0.000 .. 0.000, the cameras x 0.000 .. 0.000, y 0.000 .. "
                       "0.000, z 10.000 .. 10.000; expected both in the same coordinates"));
  EXPECT_TRUE(contains(refusal(triangle_at(0, 0, 11)), "the mesh lies behind every camera"));
  Scene shifted = scene_above();
  shifted.srs = "EPSG:32632";
  shifted.offset = {500000, 20, 0};
  EXPECT_TRUE(contains(refusal(triangle_at(500000, 20, 0), shifted), "(which is EPSG:32632 less 500000 20 0)"));
}

TEST(FrameCheck, MeasuresTheShareInAFrame) {
  Mesh mesh = triangle_at(0, 0, 0);
  for (int i = 1; i < 4; ++i) {
    const Mesh more = triangle_at(100.0 * i, 0, 0);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
    mesh.faces.push_back({base, base + 1, base + 2});
  }
  EXPECT_DOUBLE_EQ(checks::framed_share(mesh, scene_above(), kUsed), 0.25);
}

TEST(FrameCheck, OverlapCountsViewsAheadOfAFacesFront) {
  Mesh mesh = triangle_at(0, 0, 0);
  mesh.positions.push_back({100, 0, 0});
  mesh.faces.push_back({0, 2, 1});  // the back of the first
  mesh.faces.push_back({3, 3, 3});
  Scene scene = scene_above();
  scene.views.resize(3, scene.views[0]);
  scene.views[2].pose.centre = {50, 0, 10};  // does not frame them
  EXPECT_EQ(checks::overlap(mesh, scene, checks::all_views(scene)), (std::vector<std::size_t>{0, 0, 2}));
  EXPECT_TRUE(checks::overlap({}, scene, checks::all_views(scene)).empty());
}

// Of strips that overlap: places that one view alone shows need it, and others need no more than are asked for.
TEST(FrameCheck, FewViewsShowEachFaceOftenEnough) {
  Mesh mesh;
  for (int i = 0; i < 300; ++i) {
    const Mesh more = triangle_at(i, 0, 0);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
    mesh.faces.push_back({base, base + 1, base + 2});
  }
  Scene scene = scene_above();
  scene.views.resize(100, scene.views[0]);
  for (std::size_t v = 0; v < 100; ++v) scene.views[v].pose.centre = {3.0 * static_cast<double>(v), 0, 20};
  const std::vector<ViewId> all = checks::all_views(scene);
  for (const int times : {1, 3}) {
    const std::vector<ViewId> few = checks::few_views(mesh, scene, all, times);
    EXPECT_LT(few.size(), all.size() * static_cast<std::size_t>(times) / 4);
    EXPECT_TRUE(std::ranges::is_sorted(few));
    const std::vector<std::size_t> most = checks::overlap(mesh, scene, all), shown = checks::overlap(mesh, scene, few);
    ASSERT_GT(most.back(), 6U);
    const auto enough = [&](const std::vector<std::size_t>& counts) {
      return std::ranges::count_if(counts, [&](std::size_t n) { return n >= static_cast<std::size_t>(times); });
    };
    EXPECT_GE(enough(shown) + 2, enough(most));
  }
  EXPECT_TRUE(checks::few_views({}, scene, all, 3).empty());
}

/// Closed, corners counter-clockwise seen from outside: [-2, 2] x [-2, 2] x [0, 2].
Mesh box() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back({i & 1 ? 2.0 : -2.0, i & 2 ? 2.0 : -2.0, i & 4 ? 2.0 : 0.0});
  mesh.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Mesh turned(Mesh mesh, std::size_t first = 0) {
  for (std::size_t f = first; f < mesh.faces.size(); ++f) std::swap(mesh.faces[f][1], mesh.faces[f][2]);
  return mesh;
}

std::optional<double> backs_of(const Mesh& mesh, const Scene& scene = scene_above()) {
  const std::optional<checks::Backs> backs = checks::back_share(mesh, scene, kUsed);
  return backs ? std::optional(backs->share) : std::nullopt;
}

TEST(BackShare, LooksAtWhatIsSeenFirst) {
  // From above, ten of the box's twelve faces turn their back, and none of them is seen.
  EXPECT_EQ(backs_of(box()), 0.0);
  EXPECT_EQ(backs_of(turned(box())), 1.0);
  Mesh half = box();
  std::swap(half.faces[2][1], half.faces[2][2]);
  EXPECT_NEAR(*backs_of(half), 0.5, 0.02);
  EXPECT_EQ(backs_of(triangle_at(100, 0, 0)), std::nullopt);
  EXPECT_EQ(backs_of(triangle_at(0, 0, 11)), std::nullopt) << "behind the camera";
}

TEST(BackShare, CountsTheFrontOfFacesThatAreThereTurnedBothWays) {
  Mesh both = box();
  for (const Triangle& t : turned(box()).faces) both.faces.push_back(t);
  EXPECT_EQ(backs_of(both), 0.0);
  std::reverse(both.faces.begin(), both.faces.end());
  EXPECT_EQ(backs_of(both), 0.0);
}

TEST(BackShare, SeesFacesThatReachBehindTheCamera) {
  Scene level = scene_above();  // looks along y, one above the ground
  level.views[0].pose = {{1, 0, 0, 0, 0, -1, 0, 1, 0}, {0, 0, 1}};
  const Mesh ground = triangle_at(-1000, -1000, 0, 4000);
  EXPECT_EQ(backs_of(ground, level), 0.0);
  EXPECT_EQ(backs_of(turned(ground), level), 1.0);
}

TEST(BackShare, KeepsItsDigitsInLargeCoordinates) {
  Mesh far = box();
  for (WorldPoint& p : far.positions) p = {p.x + 4e6, p.y + 5e6, p.z};
  Scene scene = scene_above();
  scene.views[0].pose.centre = {4e6, 5e6, 10};
  EXPECT_EQ(backs_of(far, scene), 0.0);
  EXPECT_EQ(backs_of(turned(far), scene), 1.0);
}

TEST(CheckWinding, RefusesInsideOutAndWarnsOfParts) {
  EXPECT_EQ(checks::check_winding({}, "m.ply"), "");
  EXPECT_EQ(checks::check_winding(checks::Backs{0.1, 1}, "m.ply"), "");
  EXPECT_EQ(checks::check_winding(checks::Backs{0.25, 1}, "m.ply"),
            "m.ply: parts of the mesh look inside out: 25 % of what the cameras see of it are backs of "
            "faces, which get no photo; expected corners counter-clockwise seen from outside (turn the faces "
            "over when exporting)");
  EXPECT_TRUE(contains(input_error([] {
                         checks::check_winding(checks::Backs{0.96, 1}, "m.ply");
                       }),
                       "m.ply: the mesh looks inside out, or the cameras stand behind its surface: 96 % of"));
  EXPECT_TRUE(contains(input_error([] {
                         checks::check_winding(checks::Backs{1, 0.12}, "m.ply");
                       }),
                       "m.ply: the mesh fills 12 % of the photos, and 100 % of what the cameras see of it are backs of "
                       "faces: is it another scene's"));
}

TEST(CheckScale, WarnsOfFloatsThatAreCoarserThanPixels) {
  Scene scene = scene_above();
  const auto warning = [&](const Mesh& mesh) {
    return checks::check_scale(mesh, checks::sampling_distances(mesh, scene, kUsed), "m.ply");
  };
  EXPECT_EQ(warning(box()), "");
  // Floats of 5 million lie half a unit apart.
  scene.views[0].pose.centre = {5e6, 0, 10};
  Mesh far = box();
  for (WorldPoint& p : far.positions) p.x = static_cast<double>(static_cast<float>(p.x + 5e6));
  EXPECT_TRUE(contains(warning(far), "m.ply: positions are rounded to 0.5 units")) << warning(far);
  far.positions[0].x += 1e-3;  // as doubles have it
  EXPECT_EQ(warning(far), "");
}

TEST(CheckScale, RefusesAMeshOfAFewPixels) {
  Mesh small = box();
  for (WorldPoint& p : small.positions) p = {1e-6 * p.x, 1e-6 * p.y, 1e-6 * p.z};
  const Scene scene = scene_above();
  EXPECT_TRUE(contains(
      input_error([&] { checks::check_scale(small, checks::sampling_distances(small, scene, kUsed), "m.ply"); }),
      "m.ply: the whole mesh is "));
}

// --- the picture of the result

/// Where the overview of a mesh seen from above shows its corners: the smallest and largest x and y, as a share of the
/// picture.
std::array<double, 4> pictured(const Mesh& mesh) {
  const std::vector<ViewId> labels(mesh.faces.size(), ViewId{0});
  const pipeline::Viewpoint at = pipeline::overview(mesh, labels, scene_above(), kUsed, io::UpAxis::pos_z, 400, 300);
  std::array<double, 4> reach{1e9, -1e9, 1e9, -1e9};
  for (const WorldPoint& p : mesh.positions) {
    const CameraPoint c = camera_from_world(at.pose, p);
    EXPECT_GT(c.z, 0);
    const PixelPoint pixel = pixel_from_camera(at.camera, c);
    reach = {std::min(reach[0], pixel.x / 400), std::max(reach[1], pixel.x / 400), std::min(reach[2], pixel.y / 300),
             std::max(reach[3], pixel.y / 300)};
  }
  return reach;
}

void expect_filled(const Mesh& mesh) {
  const auto [left, right, top, bottom] = pictured(mesh);
  EXPECT_GE(left, 0);
  EXPECT_LE(right, 1);
  EXPECT_GE(top, 0);
  EXPECT_LE(bottom, 1);
  EXPECT_GT(std::max(right - left, bottom - top), 0.85);
}

TEST(Overview, HoldsMeshesOfFewFaces) {
  Mesh wall;  // 16 x 6
  wall.positions = {{-8, -3, 0}, {8, -3, 0}, {8, 3, 0}, {-8, 3, 0}};
  wall.faces = {{0, 1, 2}, {0, 2, 3}};
  expect_filled(wall);
  expect_filled(triangle_at(0, 0, 0));
  Mesh house = box();
  for (const WorldPoint& p : {WorldPoint{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}}) house.positions.push_back(p);
  house.faces.push_back({8, 9, 10});
  house.faces.push_back({8, 10, 11});
  expect_filled(house);
}

TEST(LensJson, WritesTheModelAndAllItsTerms) {
  Distortion lens{.k1 = -0.1, .p2 = 0.5};
  EXPECT_EQ(evaluate::lens_json(lens).dump(), R"({"model":"opencv","k1":-0.1,"k2":0.0,"p1":0.0,"p2":0.5,"k3":0.0})");
  EXPECT_EQ(evaluate::lens_text(lens), "k1 -0.1 p2 0.5");
  lens.model = LensModel::equidistant;
  lens.k4 = 0.25;
  lens.skew = 0.125;
  const auto json = evaluate::lens_json(lens);
  EXPECT_EQ(json["model"], "equidistant");
  EXPECT_EQ(json["k4"], 0.25);
  EXPECT_EQ(json["skew"], 0.125);
  EXPECT_EQ(json.size(), 1 + std::size(kLensTerms));
  EXPECT_EQ(evaluate::lens_text(lens), "k1 -0.1 p2 0.5 k4 0.25 skew 0.125");
}

// --- lists of views

Scene scene_with(const std::vector<std::string>& names) {
  Scene scene;
  for (const std::string& name : names) {
    scene.views.push_back(scene_above().views[0]);
    scene.views.back().name = name;
  }
  return scene;
}

std::vector<std::size_t> listed(const Scene& scene, const std::string& list) {
  std::vector<std::size_t> found;
  for (const ViewId id : cli::used_views(scene.views, list, "")) found.push_back(index(id));
  return found;
}

std::string list_refusal(const Scene& scene, const std::string& list) {
  try {
    cli::used_views(scene.views, list, "");
  } catch (const cli::UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(ViewLists, TakeNamesWithoutFolderOrExtensionWhereOneViewHasThem) {
  using Indices = std::vector<std::size_t>;
  const Scene scene = scene_with({"DJI_0018.JPG", "DJI_0020.JPG", "a", "a.jpg", "b.1.jpg", "c.jpg", "c.png",
                                  "north/d.jpg", "north/e.jpg", "south/e.jpg"});
  EXPECT_EQ(listed(scene, "DJI_0020"), Indices{1});
  EXPECT_EQ(listed(scene, "DJI_0020.JPG"), Indices{1});
  EXPECT_EQ(listed(scene, "DJI_00*,b.1"), (Indices{0, 1, 4}));
  EXPECT_EQ(listed(scene, "a"), Indices{2}) << "as it stands";
  EXPECT_EQ(listed(scene, "north/d"), Indices{7});
  EXPECT_EQ(listed(scene, "c.png"), Indices{6});
  EXPECT_TRUE(contains(list_refusal(scene, "c"), "'c' may be c.jpg or c.png; give the whole name"));
  EXPECT_EQ(listed(scene, "d"), Indices{7});
  EXPECT_EQ(listed(scene, "d.jpg"), Indices{7});
  EXPECT_TRUE(contains(list_refusal(scene, "e"), "'e' may be north/e.jpg or south/e.jpg; give the whole name"));
  EXPECT_TRUE(contains(list_refusal(scene, "DJI_0021"), "no view 'DJI_0021'; near are DJI_0020.JPG"));
  EXPECT_TRUE(contains(list_refusal(scene, "f"), "no view 'f'"));
  const std::vector<ViewId> used = cli::used_views(scene.views, "", "");
  EXPECT_EQ(cli::held_out_views(scene, used, "DJI_0018"), std::vector{ViewId{0}});
  EXPECT_EQ(cli::held_out_views(scene, used, "4"), (std::vector{ViewId{3}, ViewId{7}}));
}

TEST(FrameCheck, ManyViewsTakeFewerVertices) {
  Scene scene = scene_above();
  scene.views.resize(10000, scene.views[0]);
  Mesh mesh = triangle_at(0, 0, 0);
  mesh.positions.resize(2000, {0, 0, 0});
  const std::vector<ViewId> used = checks::all_views(scene);
  const std::size_t lengths = checks::sampling_distances(mesh, scene, used).size();
  EXPECT_GT(lengths, 1000000u);
  EXPECT_LE(lengths, 4000000u + used.size());
}

// k1 = -5 folds back at a radius of 1 / sqrt(15) of the undistorted plane, which lies at 2 / 3 of that in the photo: of this
// photo's 0.8 by 0.6, a disc of 0.093 is described.
TEST(FrameCheck, LensesThatFoldBackInThePhotoAreNamed) {
  Scene scene = scene_with({"a.jpg", "b.jpg"});
  for (View& view : scene.views) {
    view.camera = {800, 600, 1000, 1000, 400, 300, {}};
    limit_distortion(view.camera);
  }
  const std::vector<ViewId> used = checks::all_views(scene);
  EXPECT_EQ(checks::check_lenses(scene, used), "");
  scene.views[1].camera.distortion.k1 = -0.28;  // a drone's
  limit_distortion(scene.views[1].camera);
  EXPECT_EQ(checks::check_lenses(scene, used), "");
  scene.views[1].camera.distortion.k1 = -5;
  limit_distortion(scene.views[1].camera);
  const std::string warning = checks::check_lenses(scene, used);
  EXPECT_TRUE(contains(warning,
                       "1 of 2 photos have a lens whose terms describe only a part of them, 19 % of the least (b.jpg)"))
      << warning;
}

}  // namespace
}  // namespace gpvc
