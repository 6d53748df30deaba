// The whole stage against an oracle that shares no code with it.
#include "visibility/visibility.h"

#include <gtest/gtest.h>

#include "tests/visibility_oracle.h"
#include "tests/visibility_scenes.h"

namespace gpvc {
namespace {

class VisibilityGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }
  ViewVisibility classify(const Mesh& mesh, const View& view, const VisibilityOptions& options) {
    VisibilityStage stage(*device_, mesh, options);
    return stage.classify(view, ViewId{0});
  }
  std::unique_ptr<GraphicsDevice> device_;
};

VisibilityOptions exact(Sampling sampling = Sampling::hivers) {
  return {sampling, CoverageCorrection::exact, Classifier::automatic, true};
}

std::size_t expect_oracle(const Mesh& mesh, const View& view, const ViewVisibility& found) {
  const oracle::Answer expected = oracle::classify(mesh, view);
  std::size_t tied = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (expected.tied[f]) {
      ++tied;
      continue;
    }
    EXPECT_EQ(static_cast<int>(found.classes[f]), static_cast<int>(expected.classes[f]))
        << "face " << f << " of " << mesh.faces.size() << ", samples near "
        << oracle::prepare(mesh, view, f).x0 << " " << oracle::prepare(mesh, view, f).y0 << " to "
        << oracle::prepare(mesh, view, f).x1 << " " << oracle::prepare(mesh, view, f).y1;
  }
  return tied;
}

TEST_F(VisibilityGl, AgreesWithOracleOnRandomSoups) {
  const View view = scenes::view_of(160, 120, 150);
  std::uint32_t seed = 1;
  for (const double size : {0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 80.0, 200.0}) {
    const std::size_t faces = size < 5 ? 3000 : (size < 50 ? 600 : 60);
    const Mesh mesh = scenes::soup(view.camera, faces, size, seed++);
    const ViewVisibility found = classify(mesh, view, exact());
    const std::size_t tied = expect_oracle(mesh, view, found);
    EXPECT_LE(tied, mesh.faces.size() / 100) << "size " << size;
    std::array<std::size_t, 4> counts{};
    for (const FaceClass c : found.classes) ++counts[static_cast<std::size_t>(c)];
    RecordProperty("size_" + std::to_string(size), std::to_string(counts[2]) + " full");
    EXPECT_GT(counts[0], 0U);
    EXPECT_GT(counts[1], 0U);
    EXPECT_EQ(counts[3], 0U);
  }
}

}  // namespace
}  // namespace gpvc
