// Scenes that each provoke one thing that drawing, or drawing with LPCC, gets wrong; the exact correction must agree
// with the oracle on every face, and the others must be seen to fail, or the scene provokes nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <random>

#include "tests/visibility/visibility_check.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/classify/view_tester.h"
#include "visibility/device.h"
#include "visibility/gl/classify_gl.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

VisibilityOptions with(CoverageCorrection correction, Classifier classifier = Classifier::automatic) {
  if (correction == CoverageCorrection::exact) return {Gpvc{Sampling::hivers, Drawing::opengl, classifier}};
  return {PaperGpvc{Sampling::hivers, Projection::apc, correction, classifier}};
}

class ExactGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }

  ViewVisibility classify(const Mesh& mesh, const View& view, const VisibilityOptions& options) {
    VisibilityStage stage(mesh, options, device_.get());
    const auto* paper = std::get_if<PaperGpvc>(&options.method);
    const Classifier classifier = paper != nullptr ? paper->classifier : std::get<Gpvc>(options.method).classifier;
    EXPECT_EQ(stage.classifier_note().substr(0, 3), classifier == Classifier::gpu ? "gpu" : "cpu");
    return stage.classify(view, ViewId{7}, nullptr);
  }

  /// The exact correction runs on the CPU and in shaders, on what OpenGL draws and what the CPU draws, which must agree
  /// on every bit.
  ViewVisibility classify(const Mesh& mesh, const View& view, CoverageCorrection correction) {
    const ViewVisibility cpu = classify(mesh, view, with(correction, Classifier::cpu));
    if (correction == CoverageCorrection::exact) {
      expect_same(classify(mesh, view, with(correction, Classifier::gpu)), cpu);
      expect_same_visibility(classify(mesh, view, {Gpvc{.drawing = Drawing::native}}), cpu);
    }
    return cpu;
  }

  /// As a stage does it, with less of the device.
  ViewVisibility classify_within(const Mesh& mesh, const View& view, const GpuLimits& limits, std::string_view note) {
    device_->make_current();
    ViewSource source(mesh, {.native = false, .opengl = {.staged_reads = limits.staged_reads}});
    const auto tester = make_gpvc_tester(source, ClassifyOptions{}, Classifier::gpu, &device_->info(), limits);
    EXPECT_EQ(tester->note(), note);
    ViewVisibility result;
    const PreparedView prepared = source.prepare(view, ViewId{7}, nullptr, result);
    tester->classify(prepared, view, result);
    return result;
  }

  /// The same from the same item buffer: samples looked at are the same ones, too.
  static void expect_same(const ViewVisibility& found, const ViewVisibility& expected) {
    expect_same_visibility(found, expected);
    const VisibilityStatistics &a = found.statistics, &b = expected.statistics;
    EXPECT_EQ(a.processed_faces, b.processed_faces);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.corrected_samples, b.corrected_samples);
    EXPECT_EQ(a.contested_samples, b.contested_samples);
  }

  /// The exact correction agrees with the oracle; `paper` and `off` are wrong about at least so many faces.
  void expect_provoked(const Mesh& mesh, const View& view, std::size_t paper, std::size_t off) {
    const oracle::Answer expected = oracle::classify(mesh, view);
    EXPECT_EQ(expect_answer(view, classify(mesh, view, CoverageCorrection::exact), expected), 0U);
    EXPECT_GE(count_wrong(classify(mesh, view, CoverageCorrection::paper), expected), paper);
    EXPECT_GE(count_wrong(classify(mesh, view, CoverageCorrection::off), expected), off);
  }

  std::unique_ptr<GraphicsDevice> device_;
};

/// A rectangle of two front faces, corners in pixels.
void add_rectangle(Mesh& mesh, const Camera& camera, double x0, double y0, double x1, double y1, double z) {
  scenes::add_at_pixels(mesh, camera, {{{x0, y0, z}, {x0, y1, z}, {x1, y0, z}}});
  scenes::add_at_pixels(mesh, camera, {{{x1, y0, z}, {x0, y1, z}, {x1, y1, z}}});
}

/// Less than half of the rasterizer's step of 1/256 px: an edge this far from a pixel centre is drawn on it.
constexpr double kSnapped = 0.0013;

TEST_F(ExactGl, AFaceWhoseOnlyPixelWasStolenBySnapping) {
  // The right edge lies just beyond the centre and is drawn on it, which leaves the centre to what is behind.
  const View view = scenes::view_of(120, 90, 100);
  Mesh mesh;
  for (int y = 10; y < 80; y += 5)
    for (int x = 10; x < 110; x += 5)
      scenes::add_at_pixels(
          mesh, view.camera,
          {{{x - 0.3, y + 0.53, 5}, {x + 0.5 + kSnapped, y + 0.9, 5}, {x + 0.5 + kSnapped, y + 0.17, 5}}});
  const std::size_t small = mesh.faces.size();
  ASSERT_EQ(small, 280U);
  add_rectangle(mesh, view.camera, 1.3, 1.4, 118.7, 88.2, 9);
  expect_provoked(mesh, view, small, small);
}

TEST_F(ExactGl, AThirdLayerUnderAnEdge) {
  // Nearest, a sliver that covers no centre but is drawn over one; next, the face that owns it; farthest, a face whose
  // edge runs through the same pixel: LPCC compares it with the sliver alone and gives it the pixel.
  const View view = scenes::view_of(120, 90, 100);
  Mesh mesh;
  std::vector<std::size_t> farthest;
  for (int y = 4; y < 80; y += 12)
    for (int x = 4; x < 105; x += 12) {
      const double cx = x + 0.5, cy = y + 4.5;
      farthest.push_back(mesh.faces.size());
      scenes::add_at_pixels(mesh, view.camera,
                            {{{cx - 0.3, cy - 4.2, 12}, {cx - 0.3, cy + 4.3, 12}, {cx + 8.31, cy - 4.2, 12}}});
      scenes::add_at_pixels(mesh, view.camera,
                            {{{cx - 0.31, cy - 0.32, 10}, {cx - 0.22, cy + 0.41, 10}, {cx + 0.37, cy + 0.02, 10}}});
      scenes::add_at_pixels(mesh, view.camera,
                            {{{cx + kSnapped, cy - 0.41, 8}, {cx + kSnapped, cy + 0.43, 8}, {cx + 0.4, cy, 8}}});
    }
  expect_provoked(mesh, view, farthest.size(), 1);
  const ViewVisibility paper = classify(mesh, view, CoverageCorrection::paper);
  const ViewVisibility exact = classify(mesh, view, CoverageCorrection::exact);
  for (const std::size_t f : farthest) {
    EXPECT_EQ(paper.classes[f], FaceClass::full) << "face " << f;
    EXPECT_EQ(exact.classes[f], FaceClass::partial) << "face " << f;
  }
}

TEST_F(ExactGl, ADepthFightInsideAFace) {
  // Two tilted sheets 1e-8 of their depth apart, the nearer one later in the mesh: the depth buffer cannot tell them
  // apart anywhere, and LPCC looks at edges alone.
  const View view = scenes::view_of(160, 120, 120);
  const auto sheet = [](double lift) {
    return [lift](int i, int j) { return (9 + 0.31 * i - 0.17 * j) * (1 + lift); };
  };
  Mesh mesh = scenes::terrain(view.camera, 5, 4, 12.3, 9.1, 21.7, 10, sheet(1e-8));
  scenes::append(mesh, scenes::terrain(view.camera, 5, 4, 12.3, 9.1, 21.7, 10, sheet(0)));
  expect_provoked(mesh, view, 20, 20);
}

TEST_F(ExactGl, EdgesThroughCentresButForRounding) {
  // The middle of one edge of every triangle is a pixel centre, as far as doubles go: the rasterizer snaps the edge to
  // either side, and the sign of an edge value there is noise, or the top-left rule.
  const View view = scenes::view_of(200, 200, 128);
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  Mesh mesh;
  for (int y = 6; y < 194; y += 7)
    for (int x = 6; x < 194; x += 7) {
      const double cx = x + 0.5, cy = y + 0.5, angle = uniform(0, 6.2831), reach = uniform(0.6, 3);
      const double dx = reach * std::cos(angle), dy = reach * std::sin(angle);
      // Both ends are snapped to opposite sides when they lie opposite each other: then nothing is stolen.
      const double back = y % 2 == 0 ? 1 : 0.7;
      scenes::add_at_pixels(
          mesh, view.camera,
          {{{cx + dx, cy + dy, 4}, {cx - back * dx, cy - back * dy, 4}, {cx - 0.9 * dy, cy + 0.9 * dx, 4}}});
    }
  if (!oracle::prepare(mesh, view, 0).front_facing)
    for (Triangle& t : mesh.faces) std::swap(t[1], t[2]);
  const std::size_t triangles = mesh.faces.size();
  add_rectangle(mesh, view.camera, 1.3, 1.4, 198.7, 198.2, 9);
  const ViewVisibility found = classify(mesh, view, CoverageCorrection::exact);
  EXPECT_EQ(std::count(found.classes.begin(), found.classes.end(), FaceClass::full),
            static_cast<std::ptrdiff_t>(triangles));
  EXPECT_GT(found.statistics.corrected_samples, triangles / 20);
}

TEST_F(ExactGl, SoupsProvokeWhatTheyAreFor) {
  const View view = scenes::view_of(160, 120, 150);
  std::size_t off = 0, paper = 0;
  for (const double size : {0.4, 1.5, 4.0, 12.0}) {
    const Mesh mesh = scenes::soup(view.camera, 4000, size, 1001);
    const oracle::Answer expected = oracle::classify(mesh, view);
    EXPECT_EQ(expect_answer(view, classify(mesh, view, CoverageCorrection::exact), expected), 0U) << size;
    off += count_wrong(classify(mesh, view, CoverageCorrection::off), expected);
    paper += count_wrong(classify(mesh, view, CoverageCorrection::paper), expected);
  }
  EXPECT_GT(off, 3U);
  EXPECT_GT(paper, 0U);
}

TEST_F(ExactGl, AgreesWithTheOracleFarFromTheOrigin) {
  // UTM and ECEF: the positions are rounded there, and what is rounded is the truth.
  for (const WorldPoint& offset :
       {WorldPoint{447321.7, 5412876.3, 311.9}, WorldPoint{4194411.3, 627912.1, 4748234.9}}) {
    View view = scenes::view_of(160, 120, 150, 66, 71);
    Mesh mesh = scenes::soup(view.camera, 2500, 5, 404);
    for (WorldPoint& p : mesh.positions) p = {p.x + offset.x, p.y + offset.y, p.z + offset.z};
    view.pose.rotation = scenes::rotation(0.02, -0.03, 0.4);
    view.pose.centre = offset;
    EXPECT_EQ(expect_oracle(mesh, view, classify(mesh, view, CoverageCorrection::exact)), 0U);
  }
}

TEST_F(ExactGl, PrincipalPointsFarOffCentre) {
  // Up to outside the image.
  for (const auto& [cx, cy] : {std::pair{16.0, 108.0}, std::pair{152.0, 3.0}, std::pair{-40.0, 190.0}}) {
    View view = scenes::view_of(160, 120, 140, cx, cy);
    const Mesh mesh = scenes::soup(view.camera, 2000, 5, 42);
    EXPECT_EQ(expect_oracle(mesh, view, classify(mesh, view, CoverageCorrection::exact)), 0U) << cx;
  }
}

TEST_F(ExactGl, FansOfManyFacesOnOneEdgeSeenFromInside) {
  // Forty faces on one edge that passes close by the camera: most cross the camera plane.
  const View view = scenes::view_of(120, 90, 60);
  Mesh mesh;
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.03 + i * 6.2831 / 40;
    scenes::add_face(mesh, {0.3137, 0.2, -3}, {0.4, -0.1, 9},
                     {5 * std::cos(angle), 5 * std::sin(angle), 2.1 + std::cos(3 * angle)});
  }
  scenes::append(mesh, scenes::soup(view.camera, 300, 9, 6));
  EXPECT_EQ(expect_oracle(mesh, view, classify(mesh, view, CoverageCorrection::exact)), 0U);
}

TEST_F(ExactGl, TilesAndMasksChangeNothing) {
  // An image above the GL limit is drawn in tiles, and shaders look at it in tiles; here the limits are made small. A
  // mask takes out half of what lies in stripes; the oracle knows none, so only the first answers it.
  const View view = scenes::view_of(203, 131, 150, 90, 71);
  io::PhotoExclusion stripes{203, 131, 4, std::vector<std::uint64_t>(4 * 131)};
  for (std::size_t i = 0; i < stripes.words.size(); ++i) stripes.words[i] = i % 7 < 3 ? 0x00FFF0000F00FFFF : 0;
  const PhotoMask whole(view.camera), striped(whole, stripes);
  device_->make_current();
  for (const double size : {0.7, 6.0, 70.0}) {
    const Mesh mesh = scenes::soup(view.camera, size > 50 ? 80 : 2500, size, 303);
    const oracle::Answer expected = oracle::classify(mesh, view);
    ProjectedMesh projected;
    project_vertices(mesh, view.camera, view.pose, projected);
    std::vector<ViewVisibility> found;  // without and with mask, for every size of tiles
    for (const int tile : {0, 128, 37, 16}) {
      IvmRenderer renderer(mesh, {.largest_tile = tile});
      EXPECT_EQ(renderer.tiles(view.camera) > 1, tile > 0);
      std::vector<FaceId> drawn;
      renderer.render(view.camera, view.pose, {&drawn});
      const ClassifyOptions options;
      GpuLimits limits = gpu_limits();
      limits.texture_side = 64;
      limits.storage_bytes = 1 << 13;  // two dispatches of 2500 faces
      std::optional<GpuClassifier> gpu;
      // Shaders do not see the renderer's tiles, but their own.
      if (tile == 0 || tile == 37) gpu.emplace(mesh, renderer, options, limits);
      for (const PhotoMask* mask : {&whole, &striped}) {
        std::vector<FaceId> shown = drawn;
        mask->clear_outside(shown);
        const ViewVisibility as_drawn{{view.camera.width, view.camera.height, shown}, {}, {}, {}};
        ViewVisibility result = as_drawn;
        const PreparedView prepared{mesh, view.camera, ViewId{7}, *mask, projected, shown};
        FaceScan scan;
        scan.start(mesh.faces.size());
        CpuClassifier(options).classify(prepared, scan, result);
        if (mask == &whole) {
          EXPECT_EQ(expect_answer(view, result, expected), 0U) << "tile " << tile;
        }
        if (gpu) {
          ViewVisibility scanned = as_drawn;
          gpu->scan(prepared, view.pose, scan, scanned.statistics);
          EXPECT_GT(scan.counts.contested_samples, 0U);
          CpuClassifier(options).classify(prepared, scan, scanned);
          expect_same(scanned, result);
          const ClassifyOptions lazy{.correction = CoverageCorrection::paper};
          ViewVisibility completed, paper;
          GpuClassifier(mesh, renderer, lazy, limits).scan(prepared, view.pose, scan, completed.statistics);
          CpuClassifier(lazy).classify(prepared, scan, completed);
          scan.start(mesh.faces.size());
          CpuClassifier(lazy).classify(prepared, scan, paper);
          EXPECT_EQ(completed.classes, paper.classes) << "tile " << tile;
          EXPECT_EQ(completed.coverage.words, paper.coverage.words) << "tile " << tile;
        }
        found.push_back(std::move(result));
      }
    }
    EXPECT_NE(found[0].classes, found[1].classes);
    for (std::size_t i = 2; i < found.size(); ++i) {
      EXPECT_EQ(found[i].classes, found[i % 2].classes) << i;
      EXPECT_EQ(found[i].coverage.words, found[i % 2].coverage.words) << i;
    }
  }
}

TEST_F(ExactGl, MeshesAboveTheStorageBufferLimit) {
  // 128 MiB, which llvmpipe allows a storage buffer, are 11.2 million faces or 5.6 million vertices. Most lie behind
  // the camera; those that matter come last, beyond the limit.
  const View view = scenes::view_of(160, 120, 150);
  const Mesh soup = scenes::soup(view.camera, 1000, 8, 77);
  constexpr std::uint32_t kVertices = 5'700'000, kFaces = 11'300'000;
  Mesh mesh;
  mesh.positions.reserve(kVertices + soup.positions.size());
  mesh.faces.reserve(kFaces + soup.faces.size());
  for (std::uint32_t v = 0; v < kVertices; ++v)
    mesh.positions.push_back({v % 2381 - 1200.0, v % 1201 - 600.0, -5.0 - v % 17});
  for (std::uint32_t f = 0; f < kFaces; ++f) {
    const std::uint32_t v = f % (kVertices - 2);
    mesh.faces.push_back({v, v + 1, v + 2});
  }
  scenes::append(mesh, soup);
  const ViewVisibility alone = classify(soup, view, CoverageCorrection::exact);
  const ViewVisibility found = classify(mesh, view, CoverageCorrection::exact);
  EXPECT_EQ(count_classes(found.classes)[0], kFaces + count_classes(alone.classes)[0]);
  for (std::size_t f = 0; f < soup.faces.size(); ++f)
    EXPECT_EQ(found.classes[kFaces + f], alone.classes[f]) << "face " << f;
  EXPECT_EQ(found.coverage.words, alone.coverage.words);
}

TEST_F(ExactGl, ShadersTakeWhatADeviceAllows) {
  // Less and less storage: vertices and faces in several dispatches, then no room for the claims, then for the
  // candidates.
  const View view = scenes::view_of(160, 120, 150);
  Mesh mesh = scenes::soup(view.camera, 3000, 9, 77);
  // The same a hair behind: no sample is certain, and all are claimed.
  Mesh behind = mesh;
  for (WorldPoint& p : behind.positions) p = {p.x * (1 + 0x1p-48), p.y * (1 + 0x1p-48), p.z * (1 + 0x1p-48)};
  scenes::append(mesh, behind);
  const ViewVisibility expected = classify(mesh, view, with(CoverageCorrection::exact, Classifier::cpu));
  GpuLimits limits = gpu_limits();
  limits.first_claims = 16;  // made larger
  expect_same(classify_within(mesh, view, limits, "gpu: asked for"), expected);
  limits.staged_reads = true;
  expect_same(classify_within(mesh, view, limits, "gpu: asked for"), expected);
  limits.storage_bytes = 6144;
  ASSERT_LT(limits.storage_bytes / sizeof(Claim), expected.statistics.contested_samples);
  expect_same(classify_within(mesh, view, limits, "gpu: asked for"), expected);
  limits.first_claims = 1 << 20;
  expect_same(classify_within(mesh, view, limits, "gpu: asked for"), expected);
  limits.storage_bytes = 6143;
  expect_same(classify_within(mesh, view, limits, "cpu: the mesh exceeds the storage buffers of this device"),
              expected);
  limits = gpu_limits();
  limits.texels = 3 * mesh.positions.size() - 1;
  expect_same(classify_within(mesh, view, limits, "cpu: the mesh exceeds the texture buffers of this device"),
              expected);
  limits.texels += 1;
  expect_same(classify_within(mesh, view, limits, "gpu: asked for"), expected);
}

TEST_F(ExactGl, SeveralDispatchesScanAMesh) {
  // 6144 bytes hold 256 vertices or 1536 faces; few enough claims to stay within.
  const View view = scenes::view_of(160, 120, 150);
  const auto hill = [](int i, int j) { return 10 + 0.5 * std::sin(0.11 * i) * std::cos(0.13 * j); };
  Mesh mesh = scenes::terrain(view.camera, 50, 38, 3.2, 7.3, 2.9, 10, hill);
  scenes::append(mesh, scenes::terrain(view.camera, 2, 2, 33.3, 21.7, 30.4, 9, [](int, int) { return 9.0; }));
  ASSERT_GT(mesh.faces.size(), 2 * 1536U);
  const ViewVisibility expected = classify(mesh, view, with(CoverageCorrection::exact, Classifier::cpu));
  ASSERT_GT(count_classes(expected.classes)[1], 0U);
  GpuLimits limits = gpu_limits();
  limits.storage_bytes = 6144;
  device_->make_current();
  const ClassifyOptions options;
  ViewSource source(mesh, {.native = false});
  GpuClassifier gpu(mesh, *source.renderer(), options, limits);
  ViewVisibility result;
  const PreparedView prepared = source.prepare(view, ViewId{7}, nullptr, result);
  FaceScan scan;
  gpu.scan(prepared, view.pose, scan, result.statistics);
  const auto unsure = std::count(scan.codes.begin(), scan.codes.end(), FaceCode::unsure);
  EXPECT_LT(unsure, 10) << "shaders leave little open";
  EXPECT_LT(scan.claims.size(), expected.statistics.contested_samples / 4);
  CpuClassifier(options).classify(prepared, scan, result);
  expect_same(result, expected);
}

TEST_F(ExactGl, ShadersAgreeInEveryModeOnSoups) {
  View view = scenes::view_of(150, 110, 110, 60, 70);
  view.camera.distortion.k1 = 0.2;
  limit_distortion(view.camera);
  view.pose.rotation = scenes::rotation(0.1, -0.2, 0.3);
  for (const double size : {0.2, 0.7, 4.0, 30.0, 200.0}) {
    Mesh mesh = scenes::soup(view.camera, size > 100 ? 60 : 900, size, 21);
    // Some cross the camera plane, some lie in one plane, some are slivers, some there twice.
    for (std::size_t i = 0; i < mesh.positions.size(); i += 40) mesh.positions[i].z -= 14;
    for (std::size_t i = 0; i + 3 <= mesh.positions.size() / 4; i += 3) {
      const WorldPoint &a = mesh.positions[i], b = mesh.positions[i + 1];
      mesh.positions[i + 2] = {b.x + (b.x - a.x) * 0.5, b.y + (b.y - a.y) * 0.5 + 1e-4, b.z};
    }
    for (std::size_t f = 0; f < 40; ++f) mesh.faces.push_back(mesh.faces[7 * f % mesh.faces.size()]);
    for (const Projection projection : {Projection::apc, Projection::spc})
      for (const Sampling sampling : {Sampling::hivers, Sampling::ves, Sampling::dense}) {
        const auto on = [&](Classifier classifier) {
          const PaperGpvc method{sampling, projection, CoverageCorrection::exact, classifier};
          return classify(mesh, view, {method, sampling != Sampling::dense});
        };
        SCOPED_TRACE(testing::Message() << "size " << size << " sampling " << name_of(kSamplingNames, sampling));
        expect_same(on(Classifier::gpu), on(Classifier::cpu));
      }
  }
}

}  // namespace
}  // namespace gpvc::visibility
