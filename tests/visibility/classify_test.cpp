// The CPU classifier on item buffers made by hand, of whose faces it knows nothing: no graphics.
#include "visibility/classify/classify.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/classify/front_faces.h"
#include "visibility/classify/lpcc.h"
#include "visibility/classify/subpixel.h"
#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

/// A view with its vertices projected and an item buffer to be filled.
struct Bench {
  Bench(const Mesh& given, const View& seen)
      : mesh(given),
        view(seen),
        mask(seen.camera),
        ivm(static_cast<std::size_t>(seen.camera.width) * static_cast<std::size_t>(seen.camera.height), kNoFace) {
    project_vertices(mesh, view.camera, view.pose, projected);
  }
  PreparedView prepared() const { return {mesh, view.camera, ViewId{0}, mask, projected, ivm}; }
  ViewVisibility classify(CoverageCorrection correction, Sampling sampling = Sampling::hivers) const {
    ViewVisibility result;
    ClassifyOptions options;
    options.sampling = sampling;
    options.correction = correction;
    FaceScan scan;
    scan.start(mesh.faces.size());
    CpuClassifier(options).classify(prepared(), scan, result);
    return result;
  }
  const Mesh& mesh;
  const View& view;
  PhotoMask mask;
  ProjectedMesh projected;
  std::vector<FaceId> ivm;
};

TEST(Exact, DoesNotTrustTheItemBuffer) {
  // Whatever the item buffer says, the exact classes are the oracle's.
  const View view = scenes::view_of(120, 90, 100);
  for (const double size : {0.6, 5.0, 40.0}) {
    const Mesh mesh = scenes::soup(view.camera, size > 10 ? 150 : 900, size, 12);
    const oracle::Answer expected = oracle::classify(mesh, view);
    Bench bench(mesh, view);
    std::mt19937 random(1);
    std::vector<std::vector<FaceId>> buffers(3, bench.ivm);
    for (FaceId& face : buffers[1]) face = FaceId{static_cast<std::uint32_t>(random() % mesh.faces.size())};
    for (std::size_t p = 0; p < bench.ivm.size(); ++p) {
      buffers[2][p] = FaceId{expected.owners[p]};
      if (random() % 4 == 0) buffers[2][p] = FaceId{static_cast<std::uint32_t>(random() % mesh.faces.size())};
    }
    for (const std::vector<FaceId>& buffer : buffers) {
      bench.ivm = buffer;
      const ViewVisibility found = bench.classify(CoverageCorrection::exact);
      for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        ASSERT_TRUE(expected.tied[f] || found.classes[f] == expected.classes[f]) << "face " << f;
      std::size_t owned = 0, seen = 0;
      for (const FaceCoverage& entry : found.coverage.entries)
        if (entry.width > 0) {
          seen += entry.visible;
          for (const std::uint32_t owner : expected.owners) owned += owner == index(entry.face);
        }
      EXPECT_EQ(seen, owned);
    }
  }
}

/// Which of the sub-pixel samples of `faces` no face hides, by asking the exact predicates about every pair.
std::vector<std::uint32_t> visible_by_brute_force(const PreparedView& view, const std::vector<FaceId>& faces) {
  std::vector<RasterFace> rasters;
  for (std::uint32_t f = 0; f < view.mesh.faces.size(); ++f) rasters.push_back(view.raster(FaceId{f}));
  std::vector<std::uint32_t> visible;
  for (const FaceId face : faces) {
    visible.push_back(0);
    const SubpixelPositions at = subpixel_positions(view, face);
    for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
      if (!view.in_image(at.x[k], at.y[k])) continue;
      const FacePoint own = face_point(rasters[index(face)], at.x[k], at.y[k]);
      bool hidden = false;
      for (std::size_t f = 0; f < rasters.size() && !hidden; ++f) {
        if (f == index(face) || rasters[f].facing == Facing::edge_on) continue;
        const FacePoint there = face_point(rasters[f], at.x[k], at.y[k]);
        if (!covers_exactly(there)) continue;
        const int order = compare_depth_exactly(there, own);
        hidden = order < 0 || (order == 0 && f < index(face));
      }
      visible.back() += !hidden;
    }
  }
  return visible;
}

/// Checks the front faces among `first` .. `end` - 1, and that some samples see them and some do not.
void expect_brute_force(const Mesh& mesh, const View& view, std::uint32_t first, std::uint32_t end) {
  const Bench bench(mesh, view);
  const PreparedView prepared = bench.prepared();
  std::vector<FaceId> faces;
  std::vector<FaceCode> codes(mesh.faces.size(), FaceCode::hidden);
  for (std::uint32_t f = first; f < end; ++f) {
    if (prepared.raster(FaceId{f}).facing != Facing::front) continue;
    faces.push_back(FaceId{f});
    codes[f] = FaceCode::no_centre;
  }
  constexpr std::size_t kTogether = 64;
  const std::vector<PixelBox> everywhere((mesh.faces.size() + kTogether - 1) / kTogether, prepared.frame());
  SubpixelResolver resolver;
  const std::vector<std::uint32_t> expected = visible_by_brute_force(prepared, faces);
  std::size_t all = 0;
  for (int repeat = 0; repeat < 2; ++repeat) {
    resolver.resolve(prepared, codes, everywhere, kTogether);
    for (std::size_t i = 0; i < faces.size(); ++i)
      ASSERT_EQ(resolver.visible(faces[i]), expected[i]) << "face " << index(faces[i]);
  }
  for (const std::uint32_t samples : expected) all += samples;
  EXPECT_GT(all, faces.size() / 2);
  EXPECT_LT(all, faces.size() * 4 * 9 / 10);
}

TEST(Subpixel, TilesDecideAsThePredicatesDo) {
  // Small faces everywhere and heaped up in one pixel, behind small and middling ones, slivers across the image, one
  // over all of it and one that crosses the camera plane.
  const View view = scenes::view_of(1100, 1060, 1000);
  Mesh mesh = scenes::soup(view.camera, 400, 0.4, 3);
  Mesh heap = scenes::soup(scenes::view_of(1, 1, 1000).camera, 400, 0.2, 4);
  for (WorldPoint& p : heap.positions) p = {p.x + 0.2 * p.z, p.y + 0.1 * p.z, p.z};
  scenes::append(mesh, heap);
  scenes::append(mesh, scenes::soup(view.camera, 60, 80, 5));
  for (int i = 0; i < 6; ++i)
    scenes::add_at_pixels(mesh, view.camera,
                          {{{10.0 + 60 * i, 5, 6}, {1000, 1050.0 - 90 * i, 7}, {1003, 1058.0 - 90 * i, 7}}});
  scenes::add_at_pixels(mesh, view.camera, {{{-300, -200, 12}, {700, 2300, 14}, {2300, 100, 13}}});
  scenes::add_face(mesh, {-3, 1, -2}, {0.5, 2, 8}, {2, -3, 9});
  expect_brute_force(mesh, view, 0, 800);
}

TEST(Subpixel, FacesOnBordersOfTilesDecideAsThePredicatesDo) {
  // Corners on and beside the borders, thin faces along them, and others over them, far from the image's corner.
  const View view = scenes::view_of(6000, 130, 1000);
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  constexpr std::array kBeside = {0.0, 0.0, 1e-12, -1e-12, 1e-7, -1e-7, 0.02, -0.02, 0.3, -0.3};
  Mesh mesh;
  for (int i = 0; i < 900; ++i) {
    const double x = 32.0 * (184 + static_cast<double>(random() % 3));
    const double y = 32.0 * static_cast<double>(1 + random() % 3);
    const double along_x = random() % 2 == 0 ? uniform(-5, 5) : 0, along_y = along_x == 0 ? uniform(-5, 5) : 0;
    const double z = uniform(5, 15);
    std::array<std::array<double, 3>, 3> corners{};
    for (auto& corner : corners)
      corner = {x + (along_x != 0 ? along_x + uniform(-0.5, 0.5) : kBeside[random() % kBeside.size()]),
                y + (along_y != 0 ? along_y + uniform(-0.5, 0.5) : kBeside[random() % kBeside.size()]),
                z + uniform(-0.001, 0.001)};
    scenes::add_at_pixels(mesh, view.camera, corners);
  }
  expect_brute_force(mesh, view, 0, 900);
}

TEST(Subpixel, EdgesBesideSamplesDecideAsThePredicatesDo) {
  // Nearer faces with an edge past a sample, nearer to it than floats can tell: small ones and long ones.
  const View view = scenes::view_of(2000, 150, 1000);
  constexpr std::size_t kFaces = 500;
  Mesh mesh = scenes::soup(view.camera, kFaces, 0.4, 8);
  std::mt19937 random(9);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  const Bench bench(mesh, view);
  Mesh all = mesh;
  for (std::uint32_t f = 0; f < kFaces; ++f) {
    const SubpixelPositions positions = subpixel_positions(bench.prepared(), FaceId{f});
    const std::size_t k = random() % kSubpixelSamples;
    const PixelPoint at{positions.x[k], positions.y[k]};
    if (!bench.prepared().in_image(at.x, at.y)) continue;
    const double angle = uniform(0, 6.3), size = f % 4 == 0 ? 40 : 0.4, past = uniform(-1e-7, 1e-7);
    const double dx = std::cos(angle), dy = std::sin(angle);
    const auto corner = [&](double along, double beside) -> std::array<double, 3> {
      return {at.x + along * dx - beside * dy, at.y + along * dy + beside * dx, 3};
    };
    const double one = size * uniform(0.2, 1), other = size * uniform(0.2, 1);
    scenes::add_at_pixels(all, view.camera,
                          {corner(-one, past), corner(other, past), corner(0, f % 4 == 0 ? 0.5 : size)});
  }
  expect_brute_force(all, view, 0, kFaces);
}

TEST(Subpixel, ThreadsThatShareATileDecideAsThePredicatesDo) {
  // So many faces in a few pixels that one thread is not left alone with them.
  const View view = scenes::view_of(8, 6, 1000);
  const Mesh mesh = scenes::soup(view.camera, 90000, 0.02, 6);
  expect_brute_force(mesh, view, 500, 620);
}

/// Two faces of a square and a third behind them.
///     0 0 0 1
///     0 0 1 1
///     0 1 1 1
struct Square {
  Square() {
    scenes::add_at_pixels(mesh, view.camera, {{{2, 2, 5}, {2, 10, 5}, {10, 2, 5}}});
    scenes::add_at_pixels(mesh, view.camera, {{{10, 2, 5}, {2, 10, 5}, {10, 10, 5}}});
    scenes::add_at_pixels(mesh, view.camera, {{{1, 1, 8}, {1, 40, 8}, {40, 1, 8}}});
  }
  View view = scenes::view_of(16, 16, 16);
  Mesh mesh;
};

/// What a perfect rasterizer stores.
void fill(Bench& bench) {
  const oracle::Answer answer = oracle::classify(bench.mesh, bench.view);
  for (std::size_t p = 0; p < bench.ivm.size(); ++p) bench.ivm[p] = FaceId{answer.owners[p]};
  // The diagonal of the square runs through pixel centres; it is the left edge of face 1.
  for (int i = 0; i < 8; ++i) bench.ivm[static_cast<std::size_t>((9 - i) * 16 + 2 + i)] = FaceId{1};
}

TEST(Lpcc, RestoresAFragmentThatANeighbourDoesNotCover) {
  const Square square;
  Bench bench(square.mesh, square.view);
  fill(bench);
  EXPECT_EQ(bench.classify(CoverageCorrection::paper).classes[0], FaceClass::full);
  // Figure 11a: a pixel at the diagonal of face 0 given to face 1, which does not cover its centre.
  const std::size_t pixel = 5 * 16 + 5;
  ASSERT_EQ(bench.ivm[pixel], FaceId{0});
  bench.ivm[pixel] = FaceId{1};
  EXPECT_EQ(bench.classify(CoverageCorrection::off).classes[0], FaceClass::partial);
  const ViewVisibility paper = bench.classify(CoverageCorrection::paper);
  EXPECT_EQ(paper.classes[0], FaceClass::full);
  EXPECT_EQ(paper.classes[1], FaceClass::full);
  EXPECT_EQ(paper.statistics.corrected_samples, 1U);
  EXPECT_EQ(bench.classify(CoverageCorrection::exact).classes[0], FaceClass::full);
}

TEST(Lpcc, RestoresAFragmentLostToAFartherFace) {
  const Square square;
  Bench bench(square.mesh, square.view);
  fill(bench);
  // Figure 11b: the face behind covers the centre too, but is farther there.
  bench.ivm[2 * 16 + 2] = FaceId{2};
  EXPECT_EQ(bench.classify(CoverageCorrection::off).classes[0], FaceClass::partial);
  EXPECT_EQ(bench.classify(CoverageCorrection::paper).classes[0], FaceClass::full);
}

TEST(Lpcc, LeavesTheInsideAlone) {
  // An interior pixel stored wrongly: beyond LPCC, not beyond the exact correction.
  View view = scenes::view_of(16, 16, 16);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{1, 1, 5}, {1, 15, 5}, {15, 8, 5}}});
  scenes::add_at_pixels(mesh, view.camera, {{{0, 0, 8}, {0, 40, 8}, {40, 0, 8}}});
  Bench bench(mesh, view);
  const oracle::Answer answer = oracle::classify(mesh, view);
  for (std::size_t p = 0; p < bench.ivm.size(); ++p) bench.ivm[p] = FaceId{answer.owners[p]};
  bench.ivm[8 * 16 + 5] = FaceId{1};
  EXPECT_EQ(bench.classify(CoverageCorrection::paper).classes[0], FaceClass::partial);
  EXPECT_EQ(bench.classify(CoverageCorrection::exact).classes[0], FaceClass::full);
}

TEST(Classify, UnstoredFacesAreNotLookedAt) {
  // Lazy projection: a face that owns no pixel of the buffer stays hidden without the exact correction.
  const Square square;
  Bench bench(square.mesh, square.view);
  EXPECT_EQ(bench.classify(CoverageCorrection::paper).statistics.processed_faces, 0U);
  EXPECT_EQ(bench.classify(CoverageCorrection::paper).classes[0], FaceClass::hidden);
  EXPECT_EQ(bench.classify(CoverageCorrection::exact).classes[0], FaceClass::full);
}

TEST(Classify, ShareCountsSamplesOutsideTheFrame) {
  // A quarter of a square's samples lie in the frame, all of them seen.
  View view = scenes::view_of(20, 20, 20);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{-10, -10, 5}, {-10, 10, 5}, {30, -10, 5}}});
  Bench bench(mesh, view);
  const ViewVisibility found = bench.classify(CoverageCorrection::exact);
  ASSERT_EQ(found.coverage.entries.size(), 1U);
  const FaceCoverage& entry = found.coverage.entries[0];
  std::size_t all = 0, inside = 0;
  for (int y = -10; y < 10; ++y)
    for (int x = -10; x < 30; ++x) {
      // Left of the line from (-10, 10) to (30, -10).
      if (!(20 * (x + 10 + 0.5) + 40 * (y + 10 + 0.5) < 800)) continue;
      ++all;
      inside += x >= 0 && y >= 0;
    }
  EXPECT_EQ(entry.visible, inside);
  EXPECT_FLOAT_EQ(entry.visible_share, static_cast<float>(inside) / static_cast<float>(all));
}

TEST(PhotoMask, AgreesWithTheLensModelAtEveryPixel) {
  Camera camera = scenes::view_of(203, 131, 140).camera;
  for (const double k1 : {-0.4, -0.1, 0.25})
    for (const double p1 : {0.0, 0.02}) {
      camera.distortion = {};
      camera.distortion.k1 = k1;
      camera.distortion.p1 = p1;
      camera.distortion.k2 = 0.05;
      limit_distortion(camera);
      const PhotoMask mask(camera);
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
          ASSERT_EQ(mask.contains(x, y), in_photo(camera, {x + 0.5, y + 0.5})) << x << ", " << y;
    }
}

}  // namespace
}  // namespace gpvc::visibility
