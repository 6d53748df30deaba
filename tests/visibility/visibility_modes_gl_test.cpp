// The bias-based methods, SPC and no test at all, on scenes whose answer is known.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <memory>

#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"
#include "visibility/gl/ivm_gl.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

VisibilityOptions mode(const std::string& name) { return {parse_visibility_mode(name)}; }

std::size_t count(const ViewVisibility& seen, FaceClass wanted) {
  return static_cast<std::size_t>(std::count(seen.classes.begin(), seen.classes.end(), wanted));
}

class ModesGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }
  ViewVisibility classify(const Mesh& mesh, const View& view, const VisibilityOptions& options) {
    VisibilityStage stage(mesh, options, device_.get());
    return stage.classify(view, ViewId{3}, nullptr);
  }
  ViewVisibility classify(const Mesh& mesh, const View& view, const std::string& name) {
    return classify(mesh, view, mode(name));
  }

  std::unique_ptr<GraphicsDevice> device_;
};

constexpr PaperGpvc kExactSpc{.projection = Projection::spc, .correction = CoverageCorrection::exact};

/// All modes that test samples of pixels, with biases that suit a scene 5 to 15 units deep.
constexpr const char* kPerPixel[] = {"shadow-map:spc:1e-4", "shadow-map:apc:1e-10", "ray:dense:0.001"};
constexpr const char* kAll[] = {
    "gpvc", "shadow-map:spc:1e-4", "shadow-map:apc:1e-10", "ray:dense:0.001", "ray:sparse:0.001", "none"};

/// A wall of 2 x 2 cells less one at depth 5 before a terrain at depth 10. No edge comes near a pixel centre.
Mesh wall_with_hole(const Camera& camera) {
  Mesh mesh = scenes::terrain(camera, 12, 9, 2.23, 2.27, 7.73, 10, [](int, int) { return 10.0; });
  const Mesh wall = scenes::terrain(camera, 3, 3, 20.21, 11.19, 17.37, 5, [](int, int) { return 5.0; });
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), wall.positions.begin(), wall.positions.end());
  for (std::size_t f = 0; f < wall.faces.size(); ++f) {
    if (f / 2 == 4) continue;  // the middle cell
    const Triangle& t = wall.faces[f];
    mesh.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}

TEST_F(ModesGl, PerPixelModesSeeThroughAHoleInAWallAsTheOracleDoes) {
  const View view = scenes::view_of(100, 75, 80);
  const Mesh mesh = wall_with_hole(view.camera);
  const oracle::Answer truth = oracle::classify(mesh, view);
  ASSERT_EQ(std::count(truth.tied.begin(), truth.tied.end(), true), 0);
  const ViewVisibility gpvc = classify(mesh, view, "gpvc");
  ASSERT_GT(count(gpvc, FaceClass::hidden), 20U);
  ASSERT_GT(count(gpvc, FaceClass::partial), 20U);
  for (const char* name : kPerPixel) {
    const ViewVisibility seen = classify(mesh, view, name);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      EXPECT_EQ(static_cast<int>(seen.classes[f]), static_cast<int>(truth.classes[f])) << name << " face " << f;
    EXPECT_EQ(seen.coverage.words, gpvc.coverage.words) << name;
    ASSERT_EQ(seen.coverage.entries.size(), gpvc.coverage.entries.size());
    for (std::size_t i = 0; i < seen.coverage.entries.size(); ++i) {
      EXPECT_EQ(seen.coverage.entries[i].face, gpvc.coverage.entries[i].face);
      EXPECT_EQ(seen.coverage.entries[i].visible, gpvc.coverage.entries[i].visible);
      EXPECT_EQ(seen.coverage.entries[i].visible_share, gpvc.coverage.entries[i].visible_share);
      EXPECT_EQ(index(seen.coverage.entries[i].view), 3U);
    }
    EXPECT_EQ(seen.ivm.faces, gpvc.ivm.faces) << name;
    EXPECT_EQ(seen.statistics.partial, count(seen, FaceClass::partial));
    EXPECT_EQ(seen.statistics.full, count(seen, FaceClass::full));
  }
}

TEST_F(ModesGl, NoTestTakesWhateverLiesInTheImage) {
  const View view = scenes::view_of(100, 75, 80);
  const Mesh mesh = wall_with_hole(view.camera);
  const ViewVisibility seen = classify(mesh, view, "none");
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    bool inside = true;
    for (const std::uint32_t v : mesh.faces[f]) {
      const WorldPoint& p = mesh.positions[v];
      const PixelPoint at = pixel_from_camera(view.camera, {p.x, p.y, p.z});
      inside = inside && at.x >= 0 && at.y >= 0 && at.x <= 100 && at.y <= 75;
    }
    EXPECT_EQ(seen.classes[f], inside ? FaceClass::full : FaceClass::partial) << f;
  }
  EXPECT_EQ(seen.statistics.samples, 0U);
}

TEST_F(ModesGl, NoTestKeepsBackFacesAndWhatIsBesideTheImageOut) {
  const View view = scenes::view_of(100, 75, 80);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{10, 10, 5}, {10, 40, 5}, {40, 10, 5}}});              // front
  scenes::add_at_pixels(mesh, view.camera, {{{10, 10, 5}, {40, 10, 5}, {10, 40, 5}}});              // back
  scenes::add_at_pixels(mesh, view.camera, {{{110, 10, 5}, {110, 40, 5}, {140, 10, 5}}});           // beside
  scenes::add_at_pixels(mesh, view.camera, {{{90, 10, 5}, {90, 40, 5}, {140, 10, 5}}});             // across the border
  scenes::add_at_pixels(mesh, view.camera, {{{50.1, 50.1, 5}, {50.1, 50.3, 5}, {50.3, 50.1, 5}}});  // sub-pixel
  scenes::add_face(mesh, {0, 0, -5}, {0, 1, -5}, {1, 0, -5});                                       // behind
  const ViewVisibility seen = classify(mesh, view, "none");
  using enum FaceClass;
  EXPECT_EQ(seen.classes, (std::vector<FaceClass>{full, hidden, hidden, partial, full, hidden}));
  VisibilityOptions coarse = mode("none");
  coarse.subpixel = false;
  EXPECT_EQ(classify(mesh, view, coarse).classes[4], unresolved);
}

TEST_F(ModesGl, AnOccluderStrictlyInsideAFaceEscapesSparseRaysAlone) {
  const View view = scenes::view_of(100, 100, 100);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{10.2, 10.2, 10}, {10.2, 90.2, 10}, {90.2, 50.2, 10}}});
  scenes::add_at_pixels(mesh, view.camera, {{{35.2, 45.2, 5}, {35.2, 55.2, 5}, {42.2, 50.2, 5}}});
  for (const char* name : kPerPixel) EXPECT_EQ(classify(mesh, view, name).classes[0], FaceClass::partial) << name;
  EXPECT_EQ(classify(mesh, view, "ray:sparse:0.001").classes[0], FaceClass::full);
  EXPECT_EQ(classify(mesh, view, "none").classes[0], FaceClass::full);
}

TEST_F(ModesGl, SparseRaysCountVisibleVertices) {
  const View view = scenes::view_of(100, 100, 100);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{10, 10, 10}, {10, 90, 10}, {90, 50, 10}}});
  // Before the first vertex; before the first two of another face; before all of a third.
  scenes::add_at_pixels(mesh, view.camera, {{{5, 5, 5}, {5, 20, 5}, {20, 5, 5}}});
  const ViewVisibility one = classify(mesh, view, "ray:sparse:0.001");
  EXPECT_EQ(one.classes[0], FaceClass::partial);
  ASSERT_EQ(one.coverage.entries.size(), 1U);
  EXPECT_EQ(one.coverage.entries[0].visible, 2U);
  EXPECT_FLOAT_EQ(one.coverage.entries[0].visible_share, 2.0F / 3);
  EXPECT_EQ(one.statistics.rays, 6U);
  scenes::add_at_pixels(mesh, view.camera, {{{1, 1, 4}, {1, 99, 4}, {99, 50, 4}}});
  EXPECT_EQ(classify(mesh, view, "ray:sparse:0.001").classes[0], FaceClass::hidden);
  // A bias larger than the gap leaks.
  EXPECT_EQ(classify(mesh, view, "ray:sparse:20").classes[0], FaceClass::full);
}

/// Tables 1 to 4 in short: what a bias must be depends on the gap, and on the method's rounding.
TEST_F(ModesGl, TooSmallABiasHidesTooLargeABiasLeaksOnThePapersModels) {
  const View view = scenes::view_of(1000, 1000, 5000);
  const Mesh close = scenes::two_layers(view.camera, 0.01), apart = scenes::two_layers(view.camera, 100);
  const auto full = [&](const Mesh& mesh, const std::string& name) {
    return count(classify(mesh, view, name), FaceClass::full);
  };
  ASSERT_EQ(full(apart, "gpvc"), 4802U);
  // 100 m apart there is room for a bias; one that suits there leaks 1 cm apart.
  EXPECT_EQ(full(apart, "ray:dense:1"), 4802U);
  EXPECT_GT(full(close, "ray:dense:1"), 9500U);
  EXPECT_LT(full(apart, "ray:dense:1e-6"), 2400U);
  EXPECT_GT(full(apart, "shadow-map:spc:0.05"), 4700U);
  EXPECT_LE(full(apart, "shadow-map:spc:0.05"), 4802U);
  EXPECT_GT(full(close, "shadow-map:spc:0.05"), 9500U);
  EXPECT_LT(full(apart, "shadow-map:spc:1e-8"), 2400U);
  // APC: depths lie close to 0, and every bias of ordinary size leaks (table 2).
  EXPECT_GT(full(apart, "shadow-map:apc:1e-5"), 9500U);
  EXPECT_LT(full(apart, "shadow-map:apc:1e-12"), 4900U);
  EXPECT_EQ(full(apart, "none"), 9604U);
}

TEST_F(ModesGl, SpcWithCorrectionClassifiesEveryFaceOfThePapersModels) {
  const View view = scenes::view_of(1000, 1000, 5000);
  for (const double gap : {0.01, 1.0, 100.0}) {
    const Mesh mesh = scenes::two_layers(view.camera, gap);
    for (const CoverageCorrection correction : {CoverageCorrection::paper, CoverageCorrection::exact}) {
      const ViewVisibility seen =
          classify(mesh, view, {PaperGpvc{.projection = Projection::spc, .correction = correction}});
      for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        ASSERT_EQ(seen.classes[f], f < 4802 ? FaceClass::full : FaceClass::partial) << gap << " face " << f;
    }
  }
}

TEST_F(ModesGl, SpcEqualsApcOnEveryFaceOnceExact) {
  View view = scenes::view_of(160, 120, 110, 70, 66);
  std::uint32_t seed = 500;
  for (const double size : {0.6, 4.0, 25.0, 120.0}) {
    Mesh mesh = scenes::soup(view.camera, size < 50 ? 1500 : 200, size, seed++);
    for (const double advance : {0.0, 10.0}) {  // before the triangles, and among them
      view.pose.centre = {0.3, -0.2, advance};
      view.pose.rotation = scenes::rotation(0.1, -0.2, 0.3);
      const ViewVisibility a = classify(mesh, view, VisibilityOptions{}), b = classify(mesh, view, {kExactSpc});
      EXPECT_EQ(a.classes, b.classes) << size;
      EXPECT_EQ(a.coverage.words, b.coverage.words) << size;
      EXPECT_EQ(a.ivm.faces, b.ivm.faces) << size;
    }
  }
}

TEST_F(ModesGl, MovingTheSceneToUtmCoordinatesChangesNoClass) {
  View view = scenes::view_of(200, 150, 150);
  view.pose.rotation = scenes::rotation(0.2, 0.1, -0.4);
  Mesh mesh = scenes::soup(view.camera, 1200, 8, 31);
  const auto rounded = [](double v) { return std::round(v * 0x1p20) * 0x1p-20; };
  for (WorldPoint& p : mesh.positions) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
  view.pose.centre = {0.25, -0.5, 0.125};
  const WorldPoint shift{412345.5, 5321987.25, 231.0625};
  Mesh moved = mesh;
  for (WorldPoint& p : moved.positions) p = {p.x + shift.x, p.y + shift.y, p.z + shift.z};
  View there = view;
  there.pose.centre = {0.25 + shift.x, -0.5 + shift.y, 0.125 + shift.z};
  for (const char* name : kAll) {
    const ViewVisibility a = classify(mesh, view, name), b = classify(moved, there, name);
    EXPECT_GT(count(a, FaceClass::full), 20U) << name;
    EXPECT_EQ(a.classes, b.classes) << name;
    EXPECT_EQ(a.coverage.words, b.coverage.words) << name;
  }
}

TEST_F(ModesGl, ClassesDoNotDependOnThreads) {
  const View view = scenes::view_of(400, 300, 300);
  const Mesh mesh = scenes::soup(view.camera, 12000, 6, 9);
  for (const char* name : kAll) {
    std::vector<ViewVisibility> results;
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      results.push_back(classify(mesh, view, name));
    }
    for (std::size_t i = 1; i < results.size(); ++i) {
      EXPECT_EQ(results[i].classes, results[0].classes) << name;
      EXPECT_EQ(results[i].coverage.words, results[0].coverage.words) << name;
      EXPECT_EQ(results[i].statistics.samples, results[0].statistics.samples) << name;
      EXPECT_EQ(results[i].statistics.rays, results[0].statistics.rays) << name;
    }
  }
}

TEST_F(ModesGl, PixelsOutsideThePhotoSeeNothingInAnyMode) {
  View view = scenes::view_of(120, 90, 80);
  view.camera.distortion.k1 = 0.3;  // stretches the corners out of the photo
  limit_distortion(view.camera);
  const Mesh mesh = scenes::terrain(view.camera, 24, 18, 0.13, 0.17, 4.97, 8, [](int, int) { return 8.0; });
  const ViewVisibility truth = classify(mesh, view, "gpvc");
  ASSERT_GT(count(truth, FaceClass::hidden), 0U);
  for (const char* name : {"none", "shadow-map:spc:1e-4", "shadow-map:apc:1e-10", "ray:dense:0.001"}) {
    const ViewVisibility seen = classify(mesh, view, name);
    EXPECT_EQ(seen.classes, truth.classes) << name;
    EXPECT_EQ(seen.coverage.words, truth.coverage.words) << name;
  }
}

TEST_F(ModesGl, SubpixelFacesAreTestedAtTheirOwnSamples) {
  const View view = scenes::view_of(64, 48, 50);
  const auto flat = [](double depth) { return [depth](int, int) { return depth; }; };
  Mesh mesh = scenes::terrain(view.camera, 40, 40, 20.1, 10.2, 0.5, 10, flat(10));
  scenes::append(mesh, scenes::terrain(view.camera, 42, 42, 19.6, 9.7, 0.5, 9, flat(9)));
  for (const char* name : kPerPixel) {
    const ViewVisibility seen = classify(mesh, view, name);
    for (std::size_t f = 3200; f < mesh.faces.size(); ++f) ASSERT_EQ(seen.classes[f], FaceClass::full) << name;
    // A depth map has one depth a pixel, and the screen ends within some.
    std::size_t hidden = 0;
    for (std::size_t f = 0; f < 3200; ++f) hidden += seen.classes[f] == FaceClass::hidden;
    EXPECT_GT(hidden, 3000U) << name;
    VisibilityOptions coarse = mode(name);
    coarse.subpixel = false;
    EXPECT_GT(count(classify(mesh, view, coarse), FaceClass::unresolved), 3200U) << name;
  }
}

TEST_F(ModesGl, StatisticsSayWhatWasDone) {
  const View view = scenes::view_of(400, 300, 300);
  const Mesh mesh = scenes::soup(view.camera, 1500, 30, 12);
  const ViewVisibility hivers = classify(mesh, view, "gpvc"), dense = classify(mesh, view, "gpvc:dense");
  EXPECT_EQ(hivers.classes, dense.classes);
  EXPECT_LT(hivers.statistics.samples, dense.statistics.samples);
  for (const char* name : {"shadow-map:spc:1e-4", "ray:dense:0.001", "ray:sparse:0.001"}) {
    VisibilityStage stage(mesh, mode(name), device_.get());
    const ViewVisibility first = stage.classify(view, ViewId{0}, nullptr),
                         again = stage.classify(view, ViewId{0}, nullptr);
    const VisibilityStatistics &a = first.statistics, &b = again.statistics;
    // Bias-based tests look at hidden faces too (section 5).
    EXPECT_GT(a.processed_faces, hivers.statistics.processed_faces) << name;
    EXPECT_GT(a.samples, 0U) << name;
    EXPECT_EQ(a.samples, b.samples) << name;
    EXPECT_EQ(a.upload_s > 0, stage.drawing_note().starts_with("opengl")) << name;
    EXPECT_GT(a.render_s + b.render_s, 0) << name;
    EXPECT_GT(a.classify_s, 0) << name;
    const bool ray = std::string(name).starts_with("ray");
    EXPECT_EQ(a.build_s > 0, ray) << name;
    EXPECT_EQ(b.build_s, 0) << name;
    EXPECT_EQ(a.rays > 0, ray) << name;
  }
}

TEST_F(ModesGl, SecondsOfShadersAreToldApart) {
  const View view = scenes::view_of(400, 300, 300);
  const Mesh mesh = scenes::soup(view.camera, 3000, 12, 12);
  for (const CoverageCorrection correction : {CoverageCorrection::paper, CoverageCorrection::exact}) {
    const auto on = [&](Classifier classifier) {
      const PaperGpvc method{.correction = correction, .classifier = classifier};
      return classify(mesh, view, {method}).statistics;
    };
    const VisibilityStatistics cpu = on(Classifier::cpu), gpu = on(Classifier::gpu);
    EXPECT_EQ(cpu.shader_s, 0);
    EXPECT_EQ(cpu.claims_s, 0);
    EXPECT_GT(gpu.shader_s, 0);
    EXPECT_EQ(gpu.claims_s > 0, correction == CoverageCorrection::exact);
    EXPECT_LE(gpu.shader_s + gpu.claims_s, gpu.classify_s);
    EXPECT_GT(gpu.upload_s, 0);
  }
}

TEST_F(ModesGl, AMethodMeasuredAloneDrawsNoItemBuffer) {
  const View view = scenes::view_of(200, 150, 150);
  const Mesh mesh = scenes::soup(view.camera, 500, 12, 4);
  for (const char* name : kAll) {
    VisibilityOptions alone = mode(name);
    alone.draw_ivm = false;
    const ViewVisibility seen = classify(mesh, view, alone), usual = classify(mesh, view, name);
    EXPECT_EQ(seen.classes, usual.classes) << name;
    EXPECT_EQ(seen.ivm.faces.empty(), std::string(name) != "gpvc") << name;
    if (std::string(name).starts_with("ray")) {
      EXPECT_EQ(seen.statistics.render_s, 0);
    }
  }
}

TEST_F(ModesGl, DepthsOfATiledImageAreThoseOfAWholeOne) {
  const View view = scenes::view_of(200, 150, 150);
  const Mesh mesh = scenes::soup(view.camera, 400, 25, 14);
  for (const Projection projection : {Projection::apc, Projection::spc}) {
    IvmRenderer::Options options;
    options.projection = projection;
    options.near = kShadowMapNear;
    std::vector<FaceId> faces, tiled_faces;
    std::vector<float> depths, tiled_depths;
    IvmRenderer whole(mesh, options);
    whole.render(view.camera, view.pose, {&faces, &depths});
    options.largest_tile = 64;
    IvmRenderer tiled(mesh, options);
    ASSERT_EQ(tiled.tiles(view.camera), 12);
    tiled.render(view.camera, view.pose, {&tiled_faces, &tiled_depths});
    const float farthest = projection == Projection::apc ? 0 : 1;
    std::size_t covered = 0, differ = 0;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      EXPECT_EQ(faces[i] == kNoFace, depths[i] == farthest) << i;
      covered += faces[i] != kNoFace;
      if (faces[i] != tiled_faces[i]) {  // an edge that snaps the other way
        ++differ;
        continue;
      }
      // Another viewport rounds otherwise: floats of coordinates up to the tile's size.
      EXPECT_NEAR(depths[i], tiled_depths[i], 1e-4F * (farthest + depths[i])) << i;
    }
    EXPECT_GT(covered, 10000U);
    EXPECT_LT(differ, covered / 200);
  }
}

TEST_F(ModesGl, ABiasIsRefusedWhereItMeansNothing) {
  const Mesh mesh;
  for (const double epsilon : {0.0, -1.0, std::nan(""), HUGE_VAL})
    for (const Method& method :
         {Method(ShadowMap{Projection::apc, epsilon}), Method(RayTracing{RaySampling::dense, epsilon})})
      EXPECT_THROW(VisibilityStage(mesh, {method}, device_.get()), std::invalid_argument);
}

TEST_F(ModesGl, EmptyMeshesAndNothingInViewAreFine) {
  const View view = scenes::view_of(16, 16, 16);
  Mesh behind;
  scenes::add_face(behind, {0, 0, -5}, {0, 1, -5}, {1, 0, -5});
  for (const char* name : kAll) {
    EXPECT_TRUE(classify(Mesh{}, view, name).classes.empty()) << name;
    EXPECT_EQ(classify(behind, view, name).classes[0], FaceClass::hidden) << name;
  }
  EXPECT_EQ(classify(behind, view, {kExactSpc}).classes[0], FaceClass::hidden);
}

// --- depth planes, without a device

TEST(DepthMapping, SymmetricPlanesHoldTheWholeBoxInFloats) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (int repeat = 0; repeat < 2000; ++repeat) {
    const double size = std::exp(uniform(-7, 7)), distance = size * uniform(2, 1000);
    const Box box{{-size * uniform(0, 1), -size, -size * uniform(0, 1)}, {size, size * uniform(0, 1), size}};
    Pose pose;
    pose.rotation = scenes::rotation(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
    const auto& r = pose.rotation;
    pose.centre = {-distance * r[6], -distance * r[7], -distance * r[8]};
    const DepthMapping mapping = depth_mapping(Projection::spc, 0, box, pose);
    for (int corner = 0; corner < 8; ++corner) {
      const double z =
          camera_from_world(pose, {corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                   corner & 4 ? box.high.z : box.low.z})
              .z;
      ASSERT_GT(z, 0);
      const auto clip = static_cast<float>((2 * mapping.window.at_infinity - 1) * z + 2 * mapping.window.per_inverse_z);
      const auto w = static_cast<float>(z);
      ASSERT_GE(clip, -w);
      ASSERT_LE(clip, w);
    }
  }
}

TEST(DepthMapping, SymmetricDepthRunsFromTheNearestCornerToTheFarthest) {
  const Box box{{-1, -1, 10}, {1, 1, 20}};
  const WindowDepth window = depth_mapping(Projection::spc, 0, box, Pose{}).window;
  EXPECT_NEAR(window.at_infinity + window.per_inverse_z / 10, 0, 1e-5);
  EXPECT_NEAR(window.at_infinity + window.per_inverse_z / 20, 1, 1e-5);
  // Formula 2 in between: F / (F - N) (1 - N / z).
  EXPECT_NEAR(window.at_infinity + window.per_inverse_z / 15, 2 * (1 - 10.0 / 15), 1e-5);
  // A camera inside the box: the far plane stays, the near one keeps a distance.
  Pose inside;
  inside.centre = {0, 0, 15};
  const WindowDepth close = depth_mapping(Projection::spc, 0, box, inside).window;
  EXPECT_NEAR(close.at_infinity + close.per_inverse_z / 5, 1, 0.01);
  EXPECT_NEAR(close.at_infinity + close.per_inverse_z / (5 * 0x1p-14), 0, 0.01);
  EXPECT_EQ(depth_mapping(Projection::apc, 0.25, box, Pose{}).window.per_inverse_z, 0.25);
}

}  // namespace
}  // namespace gpvc::visibility
