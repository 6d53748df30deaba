// The whole stage against an oracle that shares no code with it.
#include "visibility/visibility.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <memory>

#include "tests/visibility/visibility_check.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"

namespace gpvc::visibility {
namespace {

using Counts = ClassCounts;

Counts count(const std::vector<FaceClass>& classes) { return count_classes(classes); }

VisibilityOptions options(CoverageCorrection correction, Sampling sampling = Sampling::hivers,
                          Classifier classifier = Classifier::automatic) {
  if (correction == CoverageCorrection::exact) return {Gpvc{sampling, Drawing::automatic, classifier}};
  return {PaperGpvc{sampling, Projection::apc, correction, classifier}};
}

class VisibilityGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }

  ViewVisibility classify(const Mesh& mesh, const View& view, const VisibilityOptions& given) {
    VisibilityStage stage(mesh, given, device_.get());
    return stage.classify(view, ViewId{7}, nullptr);
  }
  /// Exact classes; checks that shaders, the CPU and native drawing agree.
  ViewVisibility classify(const Mesh& mesh, const View& view) {
    const auto on = [&](Classifier classifier, Drawing drawing) {
      return classify(mesh, view, {Gpvc{Sampling::hivers, drawing, classifier}});
    };
    const ViewVisibility gpu = on(Classifier::gpu, Drawing::opengl), cpu = on(Classifier::cpu, Drawing::opengl),
                         drawn = on(Classifier::automatic, Drawing::native);
    expect_same_visibility(gpu, cpu);
    EXPECT_EQ(gpu.statistics.processed_faces, cpu.statistics.processed_faces);
    EXPECT_EQ(gpu.statistics.samples, cpu.statistics.samples);
    EXPECT_EQ(gpu.statistics.contested_samples, cpu.statistics.contested_samples);
    expect_same_visibility(drawn, cpu);
    return drawn;
  }

  std::unique_ptr<GraphicsDevice> device_;
};

TEST_F(VisibilityGl, AgreesWithOracleOnRandomSoups) {
  const View view = scenes::view_of(160, 120, 150);
  std::uint32_t seed = 1;
  for (const double size : {0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 80.0, 200.0})
    for (int repeat = 0; repeat < 3; ++repeat) {
      const std::size_t faces = size < 5 ? 3000 : (size < 50 ? 600 : 60);
      const Mesh mesh = scenes::soup(view.camera, faces, size, seed++);
      const ViewVisibility found = classify(mesh, view);
      EXPECT_EQ(expect_oracle(mesh, view, found), 0U) << "size " << size;
      const Counts counts = count(found.classes);
      EXPECT_GT(counts[0], 0U);
      EXPECT_GT(counts[1], 0U);
      EXPECT_GT(size > 50 ? counts[2] + 1 : counts[2], 0U);
      EXPECT_EQ(counts[3], 0U);
    }
}

TEST_F(VisibilityGl, AgreesWithOracleForObliqueCamerasAndOffCentrePrincipalPoints) {
  View view = scenes::view_of(200, 150, 170, 65, 110);
  view.camera.fy = 140;
  const Mesh mesh = scenes::soup(view.camera, 1500, 6, 77);
  std::uint32_t step = 0;
  for (const double angle : {-0.4, 0.1, 0.9}) {
    view.pose.rotation = scenes::rotation(angle, 0.3 - angle, 0.5 * ++step);
    view.pose.centre = {0.5, -1, 2.0 * step - 3};
    EXPECT_EQ(expect_oracle(mesh, view, classify(mesh, view)), 0U);
  }
}

TEST_F(VisibilityGl, AgreesWithOracleInsideACloudOfTriangles) {
  View view = scenes::view_of(120, 90, 60);
  Mesh mesh = scenes::soup(view.camera, 400, 60, 5);
  // Around the camera, across its plane and behind it.
  for (WorldPoint& p : mesh.positions) p.z -= 10;
  const oracle::Answer expected = oracle::classify(mesh, view);
  std::size_t crossing = 0;
  for (const Triangle& t : mesh.faces) {
    std::size_t behind = 0;
    for (const std::uint32_t v : t) behind += mesh.positions[v].z <= 0;
    crossing += behind == 1 || behind == 2;
  }
  ASSERT_GT(crossing, 20U);
  EXPECT_EQ(expect_oracle(mesh, view, classify(mesh, view)), 0U);
}

TEST_F(VisibilityGl, FloorUnderTheCameraReachesTheHorizon) {
  // Two triangles below the camera, from behind it to far ahead: the lower half of the image.
  const View view = scenes::view_of(40, 30, 20);
  Mesh mesh;
  scenes::add_face(mesh, {-1000, 1, -50}, {1000, 1, -50}, {1000, 1, 1e6});
  scenes::add_face(mesh, {-1000, 1, -50}, {1000, 1, 1e6}, {-1000, 1, 1e6});
  if (oracle::prepare(mesh, view, 0).front_facing) std::swap(mesh.faces[0][1], mesh.faces[0][2]);
  const ViewVisibility found = classify(mesh, view);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) EXPECT_EQ(found.ivm.at(x, y) != kNoFace, y >= 15) << x << ", " << y;
  EXPECT_EQ(expect_oracle(mesh, view, found), 0U);
}

TEST_F(VisibilityGl, ClassifiesEveryFaceOfThePapersModels) {
  const View view = scenes::view_of(1000, 1000, 5000);
  for (const double gap : {0.01, 1.0, 100.0}) {
    const Mesh mesh = scenes::two_layers(view.camera, gap);
    ASSERT_EQ(mesh.faces.size(), 9604U);
    const oracle::Answer expected = oracle::classify(mesh, view);
    const Counts truth = count(expected.classes);
    ASSERT_EQ(truth[2], 4802U) << "the upper layer is fully visible";
    ASSERT_EQ(truth[1], 4802U) << "every face of the lower layer is partially occluded";
    for (const CoverageCorrection correction : {CoverageCorrection::paper, CoverageCorrection::exact})
      for (const Sampling sampling : {Sampling::hivers, Sampling::dense}) {
        const ViewVisibility found = classify(mesh, view, options(correction, sampling));
        std::size_t right = 0;
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) right += found.classes[f] == expected.classes[f];
        EXPECT_EQ(right, 9604U) << "gap " << gap << " sampling " << static_cast<int>(sampling);
      }
    const ViewVisibility uncorrected = classify(mesh, view, options(CoverageCorrection::off));
    EXPECT_LT(count(uncorrected.classes)[2], 4802U) << "without correction the paper misses some";
  }
}

TEST_F(VisibilityGl, ResolvesDenseMeshesOfSubpixelFaces) {
  // A smooth surface of faces half a pixel wide with nothing in front: all of them are seen.
  const View view = scenes::view_of(64, 48, 50);
  const auto hill = [](int i, int j) { return 10 + 0.5 * std::sin(0.11 * i) * std::cos(0.13 * j); };
  const Mesh mesh = scenes::terrain(view.camera, 80, 60, 8.2, 7.3, 0.5, 10, hill);
  const ViewVisibility found = classify(mesh, view);
  EXPECT_EQ(count(found.classes)[2], mesh.faces.size());
  VisibilityOptions off = options(CoverageCorrection::exact);
  off.subpixel = false;
  EXPECT_GT(count(classify(mesh, view, off).classes)[3], mesh.faces.size() / 2);
}

TEST_F(VisibilityGl, SubpixelFacesBehindASubpixelScreenAreHidden) {
  const View view = scenes::view_of(64, 48, 50);
  const auto flat = [](double depth) { return [depth](int, int) { return depth; }; };
  Mesh mesh = scenes::terrain(view.camera, 40, 40, 20.1, 10.2, 0.5, 10, flat(10));
  // In front, under the same pixels, and half a pixel larger all around.
  scenes::append(mesh, scenes::terrain(view.camera, 42, 42, 19.6, 9.7, 0.5, 9, flat(9)));
  const ViewVisibility found = classify(mesh, view);
  for (std::size_t f = 0; f < 3200; ++f) ASSERT_EQ(found.classes[f], FaceClass::hidden) << f;
  for (std::size_t f = 3200; f < mesh.faces.size(); ++f) ASSERT_EQ(found.classes[f], FaceClass::full) << f;
}

TEST_F(VisibilityGl, ExactDuplicatesGoToTheLowerIndex) {
  const View view = scenes::view_of(100, 80, 60);
  Mesh mesh = scenes::soup(view.camera, 200, 12, 3);
  const std::size_t faces = mesh.faces.size();
  const ViewVisibility alone = classify(mesh, view);
  // The same triangles again, with their own vertices and the corners in another order.
  Mesh doubled = mesh;
  scenes::append(doubled, mesh);
  for (std::size_t f = faces; f < 2 * faces; ++f) {
    Triangle& t = doubled.faces[f];
    t = {t[1], t[2], t[0]};
  }
  const ViewVisibility found = classify(doubled, view);
  for (std::size_t f = 0; f < faces; ++f) {
    EXPECT_EQ(found.classes[f], alone.classes[f]) << f;
    EXPECT_EQ(found.classes[f + faces], FaceClass::hidden) << f;
  }
}

TEST_F(VisibilityGl, CoplanarSheetsOfDifferentTriangulationTieExactly) {
  // Depth is constant or a small multiple of x: both triangulations lie exactly in one plane.
  const View view = scenes::view_of(64, 64, 64);
  for (const double slope : {0.0, 0.25}) {
    Mesh mesh;
    const auto p = [&](double x, double y) { return WorldPoint{x, y, 8 + slope * x}; };
    scenes::add_face(mesh, p(-3, -3), p(-3, 3), p(3, -3));
    scenes::add_face(mesh, p(3, -3), p(-3, 3), p(3, 3));
    scenes::add_face(mesh, p(-3, -3), p(3, 3), p(3, -3));
    scenes::add_face(mesh, p(-3, -3), p(-3, 3), p(3, 3));
    const ViewVisibility found = classify(mesh, view);
    EXPECT_EQ(found.classes[0], FaceClass::full);
    EXPECT_EQ(found.classes[1], FaceClass::full);
    EXPECT_EQ(found.classes[2], FaceClass::hidden);
    EXPECT_EQ(found.classes[3], FaceClass::hidden);
  }
}

TEST_F(VisibilityGl, LayersCloserThanTheDepthBufferResolves) {
  // 1e-7 of the depth apart: below the step of a 32-bit float, far above that of a double.
  const View view = scenes::view_of(200, 150, 150);
  const auto hill = [](double lift) {
    return [lift](int i, int j) { return (10 + 0.3 * std::sin(0.4 * i) + 0.2 * std::cos(0.3 * j)) * (1 + lift); };
  };
  for (const double lift : {1e-7, 1e-9, 1e-10}) {
    Mesh mesh = scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(lift));
    scenes::append(mesh, scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(0)));
    const ViewVisibility found = classify(mesh, view);
    EXPECT_EQ(expect_oracle(mesh, view, found), 0U) << lift;
    for (std::size_t f = 600; f < 1200; ++f) EXPECT_EQ(found.classes[f], FaceClass::full) << lift << " face " << f;
  }
}

TEST_F(VisibilityGl, IntersectingSheetsAndFansOfManyFaces) {
  const View view = scenes::view_of(160, 120, 120);
  Mesh mesh;
  // Twelve faces on one edge.
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.05 + i * 6.28 / 12;
    scenes::add_face(mesh, {0.1, -2, 9}, {0.12, 2, 10}, {3 * std::cos(angle), 0.2, 10 + 3 * std::sin(angle)});
  }
  // Two sheets through each other and through the fan.
  scenes::append(mesh, scenes::terrain(view.camera, 6, 6, 22.3, 13, 17.7, 10, [](int i, int) { return 8 + 0.7 * i; }));
  scenes::append(mesh, scenes::terrain(view.camera, 6, 6, 27.23, 11.37, 17.1, 10,
                                       [](int i, int j) { return 12 - 0.3 * i - 0.3 * j; }));
  EXPECT_EQ(expect_oracle(mesh, view, classify(mesh, view)), 0U);
}

TEST_F(VisibilityGl, DegenerateFacesAreHiddenAndHideNothing) {
  const View view = scenes::view_of(64, 48, 50);
  const auto flat = [](int, int) { return 10.0; };
  Mesh mesh;
  const auto at = [&](double x, double y) { return scenes::at_pixel(view.camera, x, y, 5); };
  scenes::add_face(mesh, at(5, 5), at(50, 40), at(27.5, 22.5));  // three points in a line
  scenes::add_face(mesh, at(5, 5), at(5, 5), at(40, 9));         // two corners at one point
  scenes::add_face(mesh, at(30, 30), at(30, 30), at(30, 30));
  const std::size_t degenerate = mesh.faces.size();
  scenes::append(mesh, scenes::terrain(view.camera, 8, 6, 4, 4, 6.5, 10, flat));
  for (const CoverageCorrection correction : {CoverageCorrection::paper, CoverageCorrection::exact}) {
    const ViewVisibility found = classify(mesh, view, options(correction));
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      EXPECT_EQ(found.classes[f], f < degenerate ? FaceClass::hidden : FaceClass::full) << f;
  }
}

TEST_F(VisibilityGl, EdgesThroughPixelCentresBelongToOneFaceEach) {
  // Corners on pixel centres and corners: the top-left rule decides along every edge.
  const View view = scenes::view_of(64, 64, 64);
  for (const double start : {8.0, 8.5}) {
    const Mesh mesh = scenes::terrain(view.camera, 12, 12, start, start, 4, 8, [](int, int) { return 8.0; });
    for (const CoverageCorrection correction : {CoverageCorrection::paper, CoverageCorrection::exact})
      EXPECT_EQ(count(classify(mesh, view, options(correction)).classes)[2], mesh.faces.size());
  }
}

TEST_F(VisibilityGl, HiversEqualsDenseAndReadsLess) {
  const View view = scenes::view_of(300, 200, 200);
  for (const double size : {3.0, 15.0, 60.0}) {
    const Mesh mesh = scenes::soup(view.camera, 1500, size, 11);
    for (const CoverageCorrection correction :
         {CoverageCorrection::off, CoverageCorrection::paper, CoverageCorrection::exact}) {
      const ViewVisibility dense = classify(mesh, view, options(correction, Sampling::dense));
      const ViewVisibility hivers = classify(mesh, view, options(correction));
      EXPECT_EQ(dense.classes, hivers.classes);
      EXPECT_EQ(dense.coverage.words, hivers.coverage.words);
      if (size > 10) {
        EXPECT_LT(hivers.statistics.samples, dense.statistics.samples) << size;
      }
    }
  }
}

TEST_F(VisibilityGl, VesMissesAnOccluderInsideAFaceAndHiversDoesNot) {
  const View view = scenes::view_of(100, 100, 100);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{10, 10, 10}, {10, 90, 10}, {90, 50, 10}}});
  scenes::add_at_pixels(mesh, view.camera, {{{35, 45, 5}, {35, 55, 5}, {42, 50, 5}}});
  EXPECT_EQ(classify(mesh, view, options(CoverageCorrection::paper, Sampling::ves)).classes[0], FaceClass::full);
  EXPECT_EQ(classify(mesh, view, options(CoverageCorrection::paper)).classes[0], FaceClass::partial);
}

TEST_F(VisibilityGl, ShadersAndCpuGiveTheSameBits) {
  View view = scenes::view_of(150, 110, 110, 60, 70);
  view.camera.distortion.k1 = 0.2;
  limit_distortion(view.camera);
  view.pose.rotation = scenes::rotation(0.1, -0.2, 0.3);
  for (const double size : {0.7, 4.0, 30.0, 150.0}) {
    Mesh mesh = scenes::soup(view.camera, size > 100 ? 80 : 800, size, 21);
    for (std::size_t i = 0; i < mesh.positions.size(); i += 40) mesh.positions[i].z -= 14;
    for (const Sampling sampling : {Sampling::hivers, Sampling::ves, Sampling::dense})
      for (const CoverageCorrection correction : {CoverageCorrection::off, CoverageCorrection::paper}) {
        VisibilityStage cpu(mesh, options(correction, sampling, Classifier::cpu), device_.get());
        VisibilityStage gpu(mesh, options(correction, sampling, Classifier::gpu), device_.get());
        ASSERT_EQ(cpu.classifier_note().substr(0, 3), "cpu");
        ASSERT_EQ(gpu.classifier_note().substr(0, 3), "gpu");
        const ViewVisibility a = cpu.classify(view, ViewId{0}, nullptr), b = gpu.classify(view, ViewId{0}, nullptr);
        EXPECT_EQ(a.classes, b.classes) << "size " << size;
        EXPECT_EQ(a.coverage.words, b.coverage.words);
      }
  }
}

// One invocation of a shader would walk a million samples, and drivers end long loops without a word.
TEST_F(VisibilityGl, LargeFacesAreClassifiedAlikeByShaders) {
  const View view = scenes::view_of(1600, 1200, 1500);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{10, 10, 10}, {10, 1190, 12}, {1500, 1190, 9}}});
  scenes::add_at_pixels(mesh, view.camera, {{{60, 10, 10}, {1590, 1100, 11}, {1590, 20, 12}}});
  // Small ones in front, low down in the first and near the right end of the second.
  scenes::add_at_pixels(mesh, view.camera, {{{700, 1180, 2}, {705, 1186, 2}, {712, 1181, 2}}});
  scenes::add_at_pixels(mesh, view.camera, {{{1560, 1060, 2}, {1565, 1066, 2}, {1572, 1061, 2}}});
  for (const CoverageCorrection correction : {CoverageCorrection::off, CoverageCorrection::paper})
    for (const Sampling sampling : {Sampling::hivers, Sampling::ves, Sampling::dense}) {
      const ViewVisibility cpu = classify(mesh, view, options(correction, sampling, Classifier::cpu));
      const ViewVisibility gpu = classify(mesh, view, options(correction, sampling, Classifier::gpu));
      expect_same_visibility(gpu, cpu);
      if (sampling == Sampling::ves) continue;
      EXPECT_EQ(std::count(cpu.classes.begin(), cpu.classes.end(), FaceClass::partial), 2);
    }
}

// A mesh that goes on behind the camera: what crosses its plane beside the frame has no part in the view.
TEST_F(VisibilityGl, FacesAcrossTheCameraPlaneAmongSubpixelFaces) {
  View view = scenes::view_of(24, 16, 16);
  view.pose.rotation = scenes::rotation(0.6, 0, 0);  // downwards: y runs down
  view.pose.centre = {0, -3, 0};
  Mesh mesh;
  constexpr int kCells = 44;
  const auto corner = [](int i, int j) {
    return WorldPoint{(i - kCells / 2) * 0.25, 0.02 * std::sin(i * 0.9) * std::cos(j * 1.3), j * 0.25 - 4};
  };
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      scenes::add_face(mesh, corner(i, j), corner(i + 1, j), corner(i, j + 1));
      scenes::add_face(mesh, corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  std::size_t crossing = 0;
  for (const Triangle& t : mesh.faces) {
    int behind = 0;
    for (const std::uint32_t v : t) behind += camera_from_world(view.pose, mesh.positions[v]).z <= 0 ? 1 : 0;
    crossing += behind % 3 != 0 ? 1 : 0;
  }
  EXPECT_GT(crossing, 50u);
  const ViewVisibility found = classify(mesh, view);
  EXPECT_GT(std::count(found.classes.begin(), found.classes.end(), FaceClass::full), 1000);
  EXPECT_EQ(expect_oracle(mesh, view, found), 0U);
}

TEST_F(VisibilityGl, ResultDoesNotDependOnThreads) {
  const View view = scenes::view_of(400, 300, 300);
  for (const double size : {1.0, 12.0}) {
    const Mesh mesh = scenes::soup(view.camera, 20000, size, 9);
    std::vector<ViewVisibility> results;
    for (const std::size_t threads : {1U, 2U, 7U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      results.push_back(classify(mesh, view));
    }
    for (std::size_t i = 1; i < results.size(); ++i) {
      EXPECT_EQ(results[i].classes, results[0].classes);
      EXPECT_EQ(results[i].coverage.words, results[0].coverage.words);
      EXPECT_EQ(results[i].statistics.samples, results[0].statistics.samples);
      EXPECT_EQ(results[i].statistics.corrected_samples, results[0].statistics.corrected_samples);
    }
  }
}

TEST_F(VisibilityGl, MovingTheSceneByAnExactShiftChangesNothing) {
  View view = scenes::view_of(200, 150, 150);
  view.pose.rotation = scenes::rotation(0.2, 0.1, -0.4);
  Mesh mesh = scenes::soup(view.camera, 2000, 5, 31);
  const auto rounded = [](double v) { return std::round(v * 0x1p20) * 0x1p-20; };
  for (WorldPoint& p : mesh.positions) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
  view.pose.centre = {0.25, -0.5, 0.125};
  const ViewVisibility here = classify(mesh, view);
  for (const WorldPoint& shift :
       {WorldPoint{412345.5, 5321987.25, 231.0625}, WorldPoint{4194304, -0.000030517578125, 6e6}}) {
    Mesh moved = mesh;
    for (WorldPoint& p : moved.positions) p = {p.x + shift.x, p.y + shift.y, p.z + shift.z};
    View there = view;
    there.pose.centre = {view.pose.centre.x + shift.x, view.pose.centre.y + shift.y, view.pose.centre.z + shift.z};
    const ViewVisibility found = classify(moved, there);
    EXPECT_EQ(found.classes, here.classes);
    EXPECT_EQ(found.ivm.faces, here.ivm.faces);
    EXPECT_EQ(found.coverage.words, here.coverage.words);
  }
}

TEST_F(VisibilityGl, PixelsOutsideThePhotoSeeNothing) {
  View view = scenes::view_of(120, 90, 80);
  view.camera.distortion.k1 = 0.3;  // stretches the corners out of the photo
  limit_distortion(view.camera);
  const Mesh mesh = scenes::terrain(view.camera, 24, 18, 0, 0, 5, 8, [](int, int) { return 8.0; });
  const ViewVisibility found = classify(mesh, view);
  std::size_t outside = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      const bool in = in_photo(view.camera, {x + 0.5, y + 0.5});
      outside += !in;
      EXPECT_EQ(found.ivm.at(x, y) != kNoFace, in) << x << ", " << y;
    }
  ASSERT_GT(outside, 100U);
  const Counts counts = count(found.classes);
  EXPECT_GT(counts[0], 0U);
  EXPECT_GT(counts[1], 0U);
  EXPECT_GT(counts[2], 0U);
  const Mesh soup = scenes::soup(view.camera, 3000, 1.5, 8);
  expect_oracle(soup, view, classify(soup, view));
}

TEST_F(VisibilityGl, AStageGivesTheSameAnswerForAViewWhateverCameBefore) {
  const Mesh mesh = scenes::soup(scenes::view_of(200, 150, 150).camera, 3000, 4, 55);
  View first = scenes::view_of(200, 150, 150), second = scenes::view_of(150, 200, 170);
  second.pose.rotation = scenes::rotation(0.3, 0, 0);
  VisibilityStage stage(mesh, options(CoverageCorrection::exact), device_.get());
  ViewVisibility again;
  const ViewVisibility fresh = stage.classify(first, ViewId{0}, nullptr);
  stage.classify(second, ViewId{1}, nullptr, again);
  EXPECT_EQ(again.classes, classify(mesh, second).classes);
  stage.classify(first, ViewId{0}, nullptr, again);
  EXPECT_EQ(again.classes, fresh.classes);
  EXPECT_EQ(again.coverage.words, fresh.coverage.words);
  EXPECT_EQ(again.statistics.samples, fresh.statistics.samples);
}

TEST_F(VisibilityGl, HugeCoordinatesDoNotDisturbTheRest) {
  const View view = scenes::view_of(64, 48, 50);
  Mesh mesh = scenes::terrain(view.camera, 8, 6, 4, 4, 6.5, 10, [](int, int) { return 10.0; });
  const std::size_t faces = mesh.faces.size();
  // Behind the terrain, out to where products of coordinates overflow.
  for (const double far : {1e12, 1e60, 1e200, 1e300})
    scenes::add_face(mesh, {-far, -far, far}, {-far, far, far}, {far, 0, far});
  const ViewVisibility found = classify(mesh, view);
  for (std::size_t f = 0; f < faces; ++f) EXPECT_EQ(found.classes[f], FaceClass::full) << f;
}

TEST_F(VisibilityGl, EmptyMeshHasNoClasses) {
  const ViewVisibility found = classify(Mesh{}, scenes::view_of(8, 8, 8));
  EXPECT_TRUE(found.classes.empty());
  EXPECT_EQ(found.ivm.at(3, 3), kNoFace);
}

}  // namespace
}  // namespace gpvc::visibility
