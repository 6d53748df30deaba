// The oracle against another one, which traces rays in long double, and against scenes whose answer is known.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>

#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/oracle.h"
#include "visibility/result.h"

namespace gpvc::visibility {
namespace {

std::size_t count(const OracleView& view, FaceClass wanted) {
  return static_cast<std::size_t>(std::count(view.classes.begin(), view.classes.end(), wanted));
}

std::size_t tied(const OracleView& view) {
  return static_cast<std::size_t>(std::count(view.tied.begin(), view.tied.end(), 1));
}

/// Expects the same classes on all faces that neither oracle calls tied; returns the oracle's answer.
OracleView expect_rays(const Mesh& mesh, const View& view) {
  const OracleView found = oracle_visibility(mesh, view);
  const oracle::Answer rays = oracle::classify(mesh, view);
  EXPECT_EQ(found.classes.size(), mesh.faces.size());
  EXPECT_EQ(found.tied.size(), mesh.faces.size());
  for (std::size_t f = 0; f < found.classes.size(); ++f) {
    if (found.tied[f] != 0 || rays.tied[f]) continue;
    EXPECT_EQ(static_cast<int>(found.classes[f]), static_cast<int>(rays.classes[f])) << "face " << f;
  }
  return found;
}

TEST(Oracle, AgreesWithRaysOnRandomSoups) {
  const View view = scenes::view_of(160, 120, 150);
  std::uint32_t seed = 100;
  for (const double size : {0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 80.0, 120.0}) {
    const std::size_t faces = size < 5 ? 3000 : (size < 50 ? 500 : 80);
    const OracleView found = expect_rays(scenes::soup(view.camera, faces, size, seed++), view);
    EXPECT_EQ(tied(found), 0U) << "size " << size;
    EXPECT_LT(count(found, FaceClass::hidden), faces);
    EXPECT_GT(found.samples, 0U);
  }
}

TEST(Oracle, AgreesWithRaysForObliqueCamerasAndOffCentrePrincipalPoints) {
  View view = scenes::view_of(120, 90, 100, 40, 65);
  view.camera.fy = 85;
  const Mesh mesh = scenes::soup(view.camera, 800, 5, 77);
  std::uint32_t step = 0;
  for (const double angle : {-0.4, 0.1, 0.9}) {
    view.pose.rotation = scenes::rotation(angle, 0.3 - angle, 0.5 * ++step);
    view.pose.centre = {0.5, -1, 2.0 * step - 3};
    EXPECT_EQ(tied(expect_rays(mesh, view)), 0U);
  }
}

TEST(Oracle, AgreesWithRaysInsideACloudOfTriangles) {
  View view = scenes::view_of(80, 60, 40);
  Mesh mesh = scenes::soup(view.camera, 200, 40, 5);
  for (WorldPoint& p : mesh.positions) p.z -= 10;
  EXPECT_EQ(tied(expect_rays(mesh, view)), 0U);
}

TEST(Oracle, AgreesWithRaysThroughALens) {
  View view = scenes::view_of(150, 110, 110, 60, 70);
  view.camera.distortion.k1 = 0.3;
  limit_distortion(view.camera);
  for (const double size : {0.4, 3.0, 20.0})
    EXPECT_EQ(tied(expect_rays(scenes::soup(view.camera, 1000, size, 12), view)), 0U);
}

TEST(Oracle, AgreesWithRaysOnLayersAHairApart) {
  const View view = scenes::view_of(200, 150, 150);
  const auto hill = [](double lift) {
    return [lift](int i, int j) { return (10 + 0.3 * std::sin(0.4 * i) + 0.2 * std::cos(0.3 * j)) * (1 + lift); };
  };
  for (const double lift : {1e-7, 1e-9, 1e-11}) {
    Mesh mesh = scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(lift));
    scenes::append(mesh, scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(0)));
    const OracleView found = expect_rays(mesh, view);
    EXPECT_EQ(tied(found), 0U);
    for (std::size_t f = 600; f < 1200; ++f) EXPECT_EQ(found.classes[f], FaceClass::full) << lift;
  }
  // Closer than a tie, the order still is the real one, and is called a tie.
  Mesh mesh = scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(1e-14));
  scenes::append(mesh, scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(0)));
  const OracleView found = oracle_visibility(mesh, view);
  EXPECT_EQ(tied(found), 1200U);
  EXPECT_EQ(count(found, FaceClass::full), 600U);
  for (std::size_t f = 600; f < 1200; ++f) EXPECT_EQ(found.classes[f], FaceClass::full);
}

TEST(Oracle, FarCoordinatesAndSmallOnesAreTheSame) {
  View view = scenes::view_of(160, 120, 150);
  view.pose.rotation = scenes::rotation(0.3, -0.1, 1.2);
  Mesh mesh = scenes::soup(view.camera, 2000, 3, 4);
  const auto rounded = [](double v) { return std::round(v * 0x1p20) * 0x1p-20; };
  for (WorldPoint& p : mesh.positions) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
  const OracleView here = expect_rays(mesh, view);
  for (WorldPoint& p : mesh.positions) p = {p.x + 412345.5, p.y + 5321987.25, p.z + 4194304};
  view.pose.centre = {412345.5, 5321987.25, 4194304};
  const OracleView there = expect_rays(mesh, view);
  EXPECT_EQ(here.classes, there.classes);
  EXPECT_EQ(here.tied, there.tied);
}

TEST(Oracle, DuplicatesGoToTheLowerIndexAndAreTies) {
  const View view = scenes::view_of(100, 80, 60);
  Mesh mesh = scenes::soup(view.camera, 200, 12, 3);
  const std::size_t faces = mesh.faces.size();
  const OracleView alone = oracle_visibility(mesh, view);
  scenes::append(mesh, Mesh(mesh));
  for (std::size_t f = faces; f < 2 * faces; ++f) {
    Triangle& t = mesh.faces[f];
    t = {t[1], t[2], t[0]};
  }
  const OracleView found = oracle_visibility(mesh, view);
  for (std::size_t f = 0; f < faces; ++f) {
    EXPECT_EQ(found.classes[f], alone.classes[f]) << f;
    EXPECT_EQ(found.classes[f + faces], FaceClass::hidden) << f;
    const bool hidden = found.classes[f] == FaceClass::hidden;
    EXPECT_TRUE(hidden || (found.tied[f] && found.tied[f + faces])) << f;
  }
}

TEST(Oracle, CoplanarSheetsOfDifferentTriangulationTieExactly) {
  // The plane z = 8 + x / 3 is exact in no coordinate system but that of real numbers: its points lie on a grid of
  // thirds, scaled up.
  View view = scenes::view_of(64, 64, 64);
  view.pose.rotation = scenes::rotation(0.01, 0.05, 0.3);
  Mesh mesh;
  const auto p = [&](double x, double y) { return WorldPoint{3 * x, 3 * y, 24 + x}; };
  scenes::add_face(mesh, p(-2, -2), p(-2, 2), p(2, -2));
  scenes::add_face(mesh, p(2, -2), p(-2, 2), p(2, 2));
  scenes::add_face(mesh, p(-2, -2), p(2, 2), p(2, -2));
  scenes::add_face(mesh, p(-2, -2), p(-2, 2), p(2, 2));
  const OracleView found = oracle_visibility(mesh, view);
  using enum FaceClass;
  EXPECT_EQ(found.classes, (std::vector<FaceClass>{full, full, hidden, hidden}));
  EXPECT_EQ(tied(found), 4U);
}

TEST(Oracle, DegenerateAndEdgeOnFacesAreHiddenAndHideNothing) {
  const View view = scenes::view_of(64, 48, 50, 32, 24);
  Mesh mesh;
  const WorldPoint a{-1, -1, 5}, b{1, 0.5, 5};
  scenes::add_face(mesh, a, b, {0, -0.25, 5});  // three points in a line
  scenes::add_face(mesh, a, a, b);              // two corners at one point
  scenes::add_face(mesh, b, b, b);
  scenes::add_face(mesh, {0.5, -2, 4}, {1, 3, 8}, {0.25, 1, 2});  // in the plane x = z / 8 of the camera
  scenes::append(mesh, scenes::terrain(view.camera, 8, 6, 4.2, 4.1, 6.5, 10, [](int, int) { return 10.0; }));
  const OracleView found = oracle_visibility(mesh, view);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    EXPECT_EQ(found.classes[f], f < 4 ? FaceClass::hidden : FaceClass::full) << f;
    EXPECT_EQ(found.tied[f], 0) << f;
  }
}

TEST(Oracle, BackFacesHideAndAreHidden) {
  const View view = scenes::view_of(64, 48, 50);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{10, 10, 10}, {10, 40, 10}, {50, 20, 10}}});
  scenes::add_at_pixels(mesh, view.camera, {{{0, 0, 5}, {60, 10, 5}, {5, 47, 5}}});
  const OracleView found = oracle_visibility(mesh, view);
  EXPECT_EQ(found.classes[1], FaceClass::hidden);
  EXPECT_EQ(found.classes[0], FaceClass::partial);
  EXPECT_EQ(tied(found), 0U);
}

TEST(Oracle, AnEdgeThroughAPixelCentreIsATieOfThoseItDecides) {
  const View view = scenes::view_of(64, 48, 64);
  Mesh mesh;
  // Behind, two pixels' worth of face; in front, an edge exactly through the centre (20.5, 20.5).
  scenes::add_at_pixels(mesh, view.camera, {{{19.75, 20.25, 16}, {19.75, 20.75, 16}, {21.25, 20.5, 16}}});
  scenes::add_at_pixels(mesh, view.camera, {{{20.5, 10, 8}, {20.5, 40, 8}, {40, 20, 8}}});
  scenes::add_at_pixels(mesh, view.camera, {{{2, 2, 8}, {2, 9, 8}, {9, 2, 8}}});
  const OracleView found = oracle_visibility(mesh, view);
  EXPECT_EQ(found.classes[0], FaceClass::hidden) << "the edge is a left one: the centre belongs to the face";
  EXPECT_EQ(found.tied[0], 1);
  EXPECT_EQ(found.classes[1], FaceClass::full);
  EXPECT_EQ(found.tied[1], 0) << "with or without that sample it is seen everywhere";
  EXPECT_EQ(found.classes[2], FaceClass::full);
  EXPECT_EQ(found.tied[2], 0);
}

TEST(Oracle, CentresBeyondTheFrameAreNotLookedAt) {
  const View view = scenes::view_of(64, 48, 64);
  Mesh mesh;
  // Slivers between two columns of pixel centres that leave the frame below; beyond it, the second covers the centre
  // (20.5, 79.5).
  scenes::add_at_pixels(mesh, view.camera, {{{20.6, 40.1, 8}, {20.7, 60, 8}, {20.9, 30.2, 8}}});
  scenes::add_at_pixels(mesh, view.camera, {{{40.6, 40.1, 8}, {40.45, 80, 8}, {40.9, 30.2, 8}}});
  // One that reaches three million pixels: its centroid and all midpoints lie beyond the frame.
  scenes::add_at_pixels(mesh, view.camera, {{{10.6, 30.1, 8}, {10.7, 3e6, 8}, {10.9, 30.2, 8}}});
  // From the right border to behind the camera: one midpoint lies in the frame, at (63.96, 20.2).
  scenes::add_at_pixels(mesh, view.camera, {{{63.9, 20.2, 8}, {63, 20.15, -1}, {63, 20.25, -1}}});
  const OracleView found = expect_rays(mesh, view);
  using enum FaceClass;
  EXPECT_EQ(found.classes, (std::vector<FaceClass>{partial, partial, hidden, partial}));
  EXPECT_EQ(tied(found), 0U);
}

TEST(Oracle, HugeCoordinatesDoNotDisturbTheRest) {
  const View view = scenes::view_of(64, 48, 50);
  Mesh mesh = scenes::terrain(view.camera, 8, 6, 4.2, 4.1, 6.5, 10, [](int, int) { return 10.0; });
  const std::size_t faces = mesh.faces.size();
  for (const double far : {1e12, 1e60, 1e200, 1e300})
    scenes::add_face(mesh, {-far, -far, far}, {-far, far, far}, {far, 0, far});
  const OracleView found = oracle_visibility(mesh, view);
  for (std::size_t f = 0; f < faces; ++f) EXPECT_EQ(found.classes[f], FaceClass::full) << f;
}

TEST(Oracle, ThePapersModelsAreWhatTheyClaim) {
  const View view = scenes::view_of(1000, 1000, 5000);
  for (const double gap : {0.01, 1.0, 100.0}) {
    const OracleView found = oracle_visibility(scenes::two_layers(view.camera, gap), view);
    EXPECT_EQ(count(found, FaceClass::full), 4802U);
    EXPECT_EQ(count(found, FaceClass::partial), 4802U);
    EXPECT_EQ(tied(found), 0U);
  }
}

TEST(Oracle, DoesNotDependOnThreads) {
  const View view = scenes::view_of(400, 300, 300);
  for (const double size : {0.7, 12.0}) {
    Mesh mesh = scenes::soup(view.camera, 20000, size, 9);
    mesh.faces.insert(mesh.faces.end(), mesh.faces.begin(), mesh.faces.begin() + 3000);
    std::vector<OracleView> results;
    for (const std::size_t threads : {1U, 2U, 7U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      results.push_back(oracle_visibility(mesh, view));
    }
    for (std::size_t i = 1; i < results.size(); ++i) {
      EXPECT_EQ(results[i].classes, results[0].classes);
      EXPECT_EQ(results[i].tied, results[0].tied);
      EXPECT_EQ(results[i].samples, results[0].samples);
    }
  }
}

TEST(Oracle, EmptyMeshHasNoClasses) {
  EXPECT_TRUE(oracle_visibility(Mesh{}, scenes::view_of(8, 8, 8)).classes.empty());
}

}  // namespace
}  // namespace gpvc::visibility
