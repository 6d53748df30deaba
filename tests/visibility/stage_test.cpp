// VisibilityStage without a device, and which options need one.
#include <gtest/gtest.h>

#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"
#include "visibility/oracle.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

std::string refusal(const VisibilityOptions& options) {
  const Mesh mesh;
  try {
    const VisibilityStage stage(mesh, options);
  } catch (const GpuError& error) {
    return error.what();
  }
  return {};
}

TEST(Stage, AgreesWithTheOracleWithoutADevice) {
  const View view = scenes::view_of(320, 240, 250);
  for (const double size : {0.7, 6.0, 40.0}) {
    const Mesh mesh = scenes::soup(view.camera, size > 30 ? 300 : 3000, size, 41);
    VisibilityStage stage(mesh, {});
    EXPECT_EQ(stage.drawing_note(), "native: there is no graphics hardware");
    const ViewVisibility found = stage.classify(view, ViewId{0}, nullptr);
    const OracleView truth = oracle_visibility(mesh, view);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      EXPECT_TRUE(truth.tied[f] != 0 || found.classes[f] == truth.classes[f]) << "face " << f << " of size " << size;
  }
}

TEST(Stage, ComparedMethodsDrawTheSameItemBufferWithoutADevice) {
  const View view = scenes::view_of(160, 120, 150);
  const Mesh mesh = scenes::soup(view.camera, 500, 12, 42);
  io::PhotoExclusion right_half{160, 120, 3, std::vector<std::uint64_t>(3 * 120)};
  for (std::size_t y = 0; y < 120; ++y) {
    right_half.words[3 * y + 1] = ~std::uint64_t{0} << 16;
    right_half.words[3 * y + 2] = ~std::uint64_t{0};
  }
  const auto ivm = [&](const Method& method) {
    return VisibilityStage(mesh, {method}).classify(view, ViewId{0}, &right_half).ivm;
  };
  const Ivm expected = ivm(Gpvc{});
  for (int y = 0; y < 120; ++y)
    for (int x = 80; x < 160; ++x) EXPECT_EQ(expected.at(x, y), kNoFace);
  EXPECT_LT(std::count(expected.faces.begin(), expected.faces.end(), kNoFace), 160 * 120 - 1000);
  EXPECT_EQ(ivm(NoTest{}).faces, expected.faces);
  EXPECT_EQ(ivm(RayTracing{RaySampling::dense, 0.001}).faces, expected.faces);
}

TEST(Stage, SaysWhatNeedsADevice) {
  EXPECT_EQ(refusal({ShadowMap{Projection::spc, 0.001}}),
            "shadow-map:spc:0.001 needs an OpenGL device, and none was given");
  EXPECT_TRUE(refusal({PaperGpvc{}}).starts_with("gpvc without the exact coverage correction"));
  EXPECT_TRUE(refusal({Gpvc{.classifier = Classifier::gpu}}).starts_with("classifying in shaders"));
  EXPECT_TRUE(refusal({NoTest{Drawing::opengl}}).starts_with("drawing with OpenGL"));
  EXPECT_EQ(refusal({Gpvc{}}), "");
}

TEST(Stage, RefusesShadersWhereNothingIsDrawnByOpenGl) {
  const Mesh mesh;
  const VisibilityOptions options{Gpvc{.drawing = Drawing::native, .classifier = Classifier::gpu}};
  EXPECT_THROW(VisibilityStage(mesh, options), std::invalid_argument);
}

TEST(FindDevice, LooksForNoneWhereNativeDrawingIsAskedFor) {
  EXPECT_EQ(find_device({Gpvc{.drawing = Drawing::native}}), nullptr);
  EXPECT_EQ(find_device({NoTest{Drawing::native}}), nullptr);
}

}  // namespace
}  // namespace gpvc::visibility
