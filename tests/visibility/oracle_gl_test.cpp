// The stage against the oracle, on soups larger than rays could check in the time.
#include <gtest/gtest.h>

#include <memory>

#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"
#include "visibility/oracle.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

class OracleGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }

  /// Expects the oracle's class of every face without a tie, and returns how many faces are tied.
  std::size_t expect_oracle(const Mesh& mesh, const View& view) {
    VisibilityStage stage(mesh, VisibilityOptions{}, device_.get());
    const ViewVisibility found = stage.classify(view, ViewId{0}, nullptr);
    const OracleView truth = oracle_visibility(mesh, view);
    std::size_t tied = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      tied += truth.tied[f];
      if (truth.tied[f] != 0) continue;
      const Triangle& t = mesh.faces[f];
      const PixelPoint at = pixel_from_camera(view.camera, camera_from_world(view.pose, mesh.positions[t[0]]));
      EXPECT_EQ(static_cast<int>(found.classes[f]), static_cast<int>(truth.classes[f]))
          << view.name << " face " << f << ", first corner at " << at.x << ", " << at.y;
    }
    return tied;
  }

  std::unique_ptr<GraphicsDevice> device_;
};

TEST_F(OracleGl, SoupsOfAllSizes) {
  View view = scenes::view_of(640, 480, 500, 250, 290);
  view.camera.fy = 520;
  std::uint32_t seed = 300;
  for (const double size : {0.2, 0.7, 2.0, 6.0, 25.0, 70.0}) {
    view.name = "soup " + std::to_string(size);
    const std::size_t faces = size < 5 ? 20000 : (size < 50 ? 3000 : 300);
    EXPECT_EQ(expect_oracle(scenes::soup(view.camera, faces, size, seed++), view), 0U) << "size " << size;
  }
}

TEST_F(OracleGl, SoupsAroundTheCameraAndThroughALens) {
  View view = scenes::view_of(300, 220, 160, 120, 140);
  view.camera.distortion.k1 = 0.2;
  limit_distortion(view.camera);
  for (const double size : {1.0, 8.0, 40.0}) {
    view.name = "around " + std::to_string(size);
    Mesh mesh = scenes::soup(view.camera, 3000, size, 17);
    for (WorldPoint& p : mesh.positions) p.z -= 10;
    EXPECT_EQ(expect_oracle(mesh, view), 0U) << "size " << size;
  }
}

TEST_F(OracleGl, DenseTerrainWithDuplicatesFarFromTheOrigin) {
  View view = scenes::view_of(400, 300, 350);
  const auto hill = [](int i, int j) { return 100 + 3 * std::sin(0.4 * i) + 2 * std::cos(0.3 * j); };
  Mesh mesh = scenes::terrain(view.camera, 300, 220, 20.3, 15.1, 1.2, 100, hill);
  const std::size_t faces = mesh.faces.size();
  mesh.faces.insert(mesh.faces.end(), mesh.faces.begin(), mesh.faces.begin() + 500);
  for (WorldPoint& p : mesh.positions) p = {p.x + 4177654.25, p.y + 855123.5, p.z + 4728456.75};
  view.pose.centre = {4177654.25, 855123.5, 4728456.75};
  const std::size_t tied = expect_oracle(mesh, view);
  // The duplicates and their originals, where they are seen; hardly more.
  EXPECT_GT(tied, 500U);
  EXPECT_LT(tied, 1100U);
  EXPECT_GT(faces, 100000U);
}

}  // namespace
}  // namespace gpvc::visibility
