// VisibilityStage without a device, and which options need one.
#include <gtest/gtest.h>

#include <array>

#include "io/photos.h"
#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"
#include "visibility/item_buffer.h"
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

TEST(Stage, StoresTheOwnersThatTheOracleFinds) {
  // Around the camera, so that many faces are drawn with rounded edges.
  View view = scenes::view_of(240, 180, 110);
  for (const double advance : {0.0, 9.0}) {
    view.pose.centre.z = advance;
    const Mesh mesh = scenes::soup(view.camera, 400, 40, 43);
    const oracle::Answer expected = oracle::classify(mesh, view);
    const Ivm found = VisibilityStage(mesh, {}).classify(view, ViewId{0}, nullptr).ivm;
    std::size_t compared = 0;
    for (std::size_t p = 0; p < found.faces.size(); ++p) {
      const auto owner = expected.owners[p], stored = static_cast<std::uint32_t>(found.faces[p]);
      const auto tied = [&](std::uint32_t face) {
        return face != static_cast<std::uint32_t>(kNoFace) && expected.tied[face];
      };
      if (tied(owner) || tied(stored)) continue;
      ++compared;
      ASSERT_EQ(stored, owner) << "pixel " << p << ", camera at " << advance;
    }
    EXPECT_GT(compared, found.faces.size() / 2);
  }
}

TEST(Stage, MovingTheSceneByAnInexactShiftChangesNoClass) {
  View view = scenes::view_of(640, 480, 500);
  view.pose.rotation = scenes::rotation(0.2, 0.1, -0.4);
  const Mesh mesh = scenes::soup(view.camera, 20000, 6, 45);
  // As a file has it that stores t: the centre is -R^T t, with t rounded at this size.
  const WorldPoint shift{500000.1, 5400000.3, 100.7};
  const auto& r = view.pose.rotation;
  std::array<double, 3> t{};
  for (std::size_t k = 0; k < 3; ++k) t[k] = -(r[3 * k] * shift.x + r[3 * k + 1] * shift.y + r[3 * k + 2] * shift.z);
  View there = view;
  there.pose.centre = {-(r[0] * t[0] + r[3] * t[1] + r[6] * t[2]), -(r[1] * t[0] + r[4] * t[1] + r[7] * t[2]),
                       -(r[2] * t[0] + r[5] * t[1] + r[8] * t[2])};
  EXPECT_NE(there.pose.centre.y, shift.y);
  Mesh moved = mesh;
  for (WorldPoint& p : moved.positions) p = {p.x + shift.x, p.y + shift.y, p.z + shift.z};
  const ViewVisibility here = VisibilityStage(mesh, {}).classify(view, ViewId{0}, nullptr);
  const ViewVisibility found = VisibilityStage(moved, {}).classify(there, ViewId{0}, nullptr);
  EXPECT_EQ(found.classes, here.classes);
  EXPECT_EQ(found.ivm.faces, here.ivm.faces);
}

TEST(Stage, CopiesOfALargeFaceAreNeitherDrawnNorContested) {
  // Drawn like any other face, 20,000 of them would take minutes.
  const View view = scenes::view_of(640, 480, 500);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{-20, -30, 9}, {10, 900, 11}, {1300, 5, 10}}});
  scenes::append(mesh, scenes::soup(view.camera, 50, 20, 44));
  const std::size_t distinct = mesh.faces.size();
  const ViewVisibility alone = VisibilityStage(mesh, {}).classify(view, ViewId{0}, nullptr);
  ASSERT_EQ(alone.classes[0], FaceClass::partial);
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const WorldPoint& p = mesh.positions[i % 3];
    mesh.positions.push_back({p.x, p.y, p.z});
    // With the same vertices and with their own, from another corner on.
    const std::uint32_t a = i % 2 == 0 ? 0 : static_cast<std::uint32_t>(mesh.positions.size()) - 1;
    const std::uint32_t b = i % 2 == 0 ? 1 : (i + 1) % 3, c = i % 2 == 0 ? 2 : (i + 2) % 3;
    mesh.faces.push_back({b, c, a});
  }
  const ViewVisibility found = VisibilityStage(mesh, {}).classify(view, ViewId{0}, nullptr);
  EXPECT_EQ(found.statistics.contested_samples, alone.statistics.contested_samples);
  EXPECT_EQ(found.ivm.faces, alone.ivm.faces);
  EXPECT_EQ(std::vector(found.classes.begin(), found.classes.begin() + static_cast<std::ptrdiff_t>(distinct)),
            alone.classes);
  for (std::size_t f = distinct; f < found.classes.size(); ++f) ASSERT_EQ(found.classes[f], FaceClass::hidden) << f;
}

TEST(Stage, BothSidesOfASurfaceThatAreFacesOfTheirOwnAreSeen) {
  const View view = scenes::view_of(320, 240, 250);
  const auto classes = [&](const Mesh& mesh) {
    return VisibilityStage(mesh, {}).classify(view, ViewId{0}, nullptr).classes;
  };
  for (const double size : {0.7, 6.0, 40.0}) {
    const Mesh mesh = scenes::soup(view.camera, size > 30 ? 300 : 3000, size, 45);
    Mesh turned = mesh;
    for (Triangle& t : turned.faces) std::swap(t[1], t[2]);
    const std::vector<FaceClass> fronts = classes(mesh), backs = classes(turned);
    for (const bool back_first : {false, true}) {
      Mesh both = mesh;
      both.faces.clear();
      for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        both.faces.push_back((back_first ? turned : mesh).faces[f]);
        both.faces.push_back((back_first ? mesh : turned).faces[f]);
      }
      const std::vector<FaceClass> found = classes(both);
      const OracleView truth = oracle_visibility(both, view);
      std::size_t seen = 0;
      for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        EXPECT_EQ(found[2 * f + (back_first ? 1 : 0)], fronts[f]) << f;
        EXPECT_EQ(found[2 * f + (back_first ? 0 : 1)], backs[f]) << f;
        seen += fronts[f] != FaceClass::hidden && backs[f] == FaceClass::hidden ? 1 : 0;
      }
      EXPECT_GT(seen, mesh.faces.size() / 10);
      EXPECT_EQ(truth.classes, found);
      const Ivm shown = draw_item_buffer(both, view.camera, view.pose),
                once = draw_item_buffer(mesh, view.camera, view.pose);
      std::size_t others = 0;
      for (std::size_t i = 0; i < shown.faces.size(); ++i)
        others +=
            shown.faces[i] == kNoFace ? once.faces[i] != kNoFace : index(shown.faces[i]) / 2 != index(once.faces[i]);
      EXPECT_LT(others, shown.faces.size() / 1000) << "where depths are close";
    }
  }
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
