#include "app/frame_check.h"

#include <gtest/gtest.h>

#include "app/lens_json.h"
#include "temporary_folder.h"

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
  return input_error([&] { check_frames(mesh, "m.ply", scene, kUsed); });
}

TEST(FrameCheck, AcceptsOneFaceInOneFrame) {
  EXPECT_NO_THROW(check_frames(triangle_at(0, 0, 0), "m.ply", scene_above(), kUsed));
  EXPECT_NO_THROW(check_frames(triangle_at(4.9, 0, 0), "m.ply", scene_above(), kUsed));
  // A face larger than the frame has no corner in it.
  EXPECT_NO_THROW(check_frames(triangle_at(-100, -100, 0, 1000), "m.ply", scene_above(), kUsed));
  Mesh far = triangle_at(1e6, 0, 0);
  for (int i = 0; i < 5000; ++i) far.faces.push_back(far.faces[0]);
  far.positions.push_back({0, 0, 0});
  far.faces.push_back({3, 3, 3});
  EXPECT_NO_THROW(check_frames(far, "m.ply", scene_above(), kUsed));
}

TEST(FrameCheck, ExplainsWithBothBoxes) {
  EXPECT_TRUE(
      contains(refusal(triangle_at(500000, 20, 0)),
               "m.ply: no photo sees any face, the mesh lies outside every frame: it spans x 500000.000 .. "
               "500001.000, y 20.000 .. 21.000, z 0.000 .. 0.000, the cameras x 0.000 .. 0.000, y 0.000 .. "
               "0.000, z 10.000 .. 10.000; expected both in the same coordinates"));
  EXPECT_TRUE(contains(refusal(triangle_at(0, 0, 11)), "the mesh lies behind every camera"));
  Scene shifted = scene_above();
  shifted.srs = "EPSG:32632";
  shifted.offset = {500000, 20, 0};
  EXPECT_TRUE(
      contains(refusal(triangle_at(500000, 20, 0), shifted), "(which is EPSG:32632 less 500000 20 0)"));
}

TEST(FrameCheck, MeasuresTheShareInAFrame) {
  Mesh mesh = triangle_at(0, 0, 0);
  for (int i = 1; i < 4; ++i) {
    const Mesh more = triangle_at(100.0 * i, 0, 0);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
    mesh.faces.push_back({base, base + 1, base + 2});
  }
  EXPECT_DOUBLE_EQ(framed_share(mesh, scene_above(), kUsed), 0.25);
}

TEST(LensJson, WritesTheModelAndAllItsTerms) {
  Distortion lens{.k1 = -0.1, .p2 = 0.5};
  EXPECT_EQ(lens_json(lens).dump(), R"({"model":"opencv","k1":-0.1,"k2":0.0,"p1":0.0,"p2":0.5,"k3":0.0})");
  EXPECT_EQ(lens_text(lens), "k1 -0.1 p2 0.5");
  lens.model = LensModel::equidistant;
  lens.k4 = 0.25;
  lens.skew = 0.125;
  const auto json = lens_json(lens);
  EXPECT_EQ(json["model"], "equidistant");
  EXPECT_EQ(json["k4"], 0.25);
  EXPECT_EQ(json["skew"], 0.125);
  EXPECT_EQ(json.size(), 16);
  EXPECT_EQ(lens_text(lens), "k1 -0.1 p2 0.5 k4 0.25 skew 0.125");
}

}  // namespace
}  // namespace gpvc
