// Native drawing: the item buffer and the codes of the faces before ExactScan::settle(), without graphics. The tests of
// the stage compare its classes with the oracle, scene by scene (visibility_gl_test, visibility_exact_gl_test).
#include "visibility/native/ivm_cpu.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "io/vector.h"
#include "tests/visibility/visibility_check.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/classify/classify.h"
#include "visibility/native/face_hulls.h"
#include "visibility/oracle.h"

namespace gpvc::visibility {
namespace {

class Drawn {
 public:
  Drawn(const Mesh& mesh, const View& view) : Drawn(mesh, view, PhotoMask(view.camera)) {}
  Drawn(const Mesh& mesh, const View& view, const PhotoMask& mask) : mesh_(mesh), view_(view), mask_(mask) {
    project_vertices(mesh_, view_.camera, view_.pose, projected_);
    ivm.resize(static_cast<std::size_t>(view.camera.width) * static_cast<std::size_t>(view.camera.height));
    CpuIvm().draw(prepared(ivm), {}, {}, ivm, scan);
  }
  /// From what was drawn, which it uses up.
  ViewVisibility classify(const ClassifyOptions& options = {}) {
    ViewVisibility result{{view_.camera.width, view_.camera.height, ivm}, {}, {}, {}};
    CpuClassifier(options).classify(prepared(ivm), scan, result);
    return result;
  }
  /// From an empty item buffer: every face contests every pixel that it covers.
  ViewVisibility classify_undrawn(const ClassifyOptions& options = {}) const {
    const std::vector<FaceId> nothing(ivm.size(), kNoFace);
    ViewVisibility result{{view_.camera.width, view_.camera.height, nothing}, {}, {}, {}};
    FaceScan unknown;
    unknown.start(mesh_.faces.size());
    CpuClassifier(options).classify(prepared(nothing), unknown, result);
    return result;
  }
  bool claims(std::uint32_t pixel, std::uint32_t face) const {
    return std::any_of(scan.claims.begin(), scan.claims.end(),
                       [&](const Claim& claim) { return claim.pixel == pixel && index(claim.face) == face; });
  }
  std::size_t unsure() const {
    return static_cast<std::size_t>(std::count(scan.codes.begin(), scan.codes.end(), FaceCode::unsure));
  }

  std::vector<FaceId> ivm;
  FaceScan scan;

 private:
  PreparedView prepared(std::span<const FaceId> owners) const {
    return {mesh_, view_.camera, ViewId{7}, mask_, projected_, owners};
  }

  const Mesh& mesh_;
  const View& view_;
  PhotoMask mask_;
  ProjectedMesh projected_;
};

void expect_classes_undrawn(const Mesh& mesh, const View& view, const PhotoMask& mask) {
  Drawn drawn(mesh, view, mask);
  const ViewVisibility expected = drawn.classify_undrawn();
  expect_same_visibility(drawn.classify(), expected);
}

TEST(CpuIvm, TheRightOwnerIsStoredOrClaimedOrItsFaceUnsure) {
  const View view = scenes::view_of(300, 280, 250);
  for (const double size : {0.8, 6.0, 60.0}) {
    const Mesh mesh = scenes::soup(view.camera, size > 50 ? 150 : 2500, size, 81);
    const oracle::Answer expected = oracle::classify(mesh, view);
    const Drawn drawn(mesh, view);
    std::size_t stored = 0;
    for (std::uint32_t pixel = 0; pixel < drawn.ivm.size(); ++pixel) {
      const std::uint32_t owner = expected.owners[pixel];
      stored += index(drawn.ivm[pixel]) == owner;
      if (index(drawn.ivm[pixel]) == owner) continue;
      ASSERT_NE(owner, index(kNoFace)) << pixel;
      EXPECT_TRUE(expected.tied[owner] || drawn.claims(pixel, owner) || drawn.scan.codes[owner] == FaceCode::unsure)
          << "pixel " << pixel;
    }
    // Nothing is snapped: what is drawn is nearly all right.
    EXPECT_GT(stored, drawn.ivm.size() * 999 / 1000) << size;
    EXPECT_LT(drawn.unsure(), mesh.faces.size() / 2) << size;
  }
}

TEST(CpuIvm, AFaceThatNothingTouchesIsFullWithoutAnotherLook) {
  const View view = scenes::view_of(300, 280, 250);
  const Mesh mesh = scenes::terrain(view.camera, 40, 38, 5.3, 6.7, 7.1, 10,
                                    [](int i, int j) { return 10 + 0.2 * std::sin(0.7 * i + 0.4 * j); });
  const Drawn drawn(mesh, view);
  EXPECT_TRUE(std::all_of(drawn.scan.codes.begin(), drawn.scan.codes.end(),
                          [](FaceCode code) { return code == FaceCode::full; }));
  EXPECT_TRUE(drawn.scan.claims.empty());
  EXPECT_EQ(drawn.scan.counts.processed_faces, mesh.faces.size());
  EXPECT_EQ(drawn.scan.counts.samples,
            static_cast<std::size_t>(
                std::count_if(drawn.ivm.begin(), drawn.ivm.end(), [](FaceId face) { return face != kNoFace; })));
}

TEST(CpuIvm, LayersThatFloatsCannotTellApartAreDoubts) {
  const View view = scenes::view_of(200, 150, 150);
  const auto hill = [](double lift) {
    return [lift](int i, int j) { return (10 + 0.3 * std::sin(0.4 * i + 0.2 * j)) * (1 + lift); };
  };
  for (const double lift : {3e-7, 1e-8, 1e-10})
    for (const bool nearest_first : {false, true}) {
      Mesh mesh = scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(nearest_first ? 0 : lift));
      scenes::append(mesh, scenes::terrain(view.camera, 20, 15, 15, 12, 8.3, 10, hill(nearest_first ? lift : 0)));
      Drawn drawn(mesh, view);
      EXPECT_GT(drawn.scan.claims.size(), drawn.ivm.size() / 2) << lift;
      const ViewVisibility found = drawn.classify();
      EXPECT_EQ(expect_oracle(mesh, view, found), 0U) << lift;
    }
}

TEST(CpuIvm, AFanOverANoisyFlatPolygonIsDecidedInRuns) {
  // Some twenty faces cover each pixel, and only rounding of their projection orders their depths. The test would take
  // minutes if each pixel compared them in unbounded precision.
  View view = scenes::view_of(360, 270, 300);
  view.pose.rotation = scenes::rotation(0.11, 0.07, 0.3);
  std::mt19937 random(6);
  Mesh mesh;
  constexpr int kCorners = 1000;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kCorners;
    const double radius = 3 + 0.8 * (static_cast<double>(random()) / 4294967296.0 - 0.5);
    mesh.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), 8});
    if (i >= 2) mesh.faces.push_back({0, i, i - 1});
  }
  Drawn drawn(mesh, view);
  EXPECT_GT(drawn.scan.claims.size(), drawn.ivm.size());
  expect_same_visibility(drawn.classify(), drawn.classify_undrawn());
}

TEST(CpuIvm, SliversAndFacesLargerThanManyTiles) {
  // Large enough that a face of the whole image is not listed tile by tile.
  const View view = scenes::view_of(2200, 2150, 2000);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{-90, -70, 11}, {-40, 4400, 14}, {4300, -30, 12}}});
  scenes::add_at_pixels(mesh, view.camera, {{{2150.3, 30.2, 9}, {20.4, 2100.1, 16}, {2190.2, 2140.7, 13}}});
  // Long, thin and at any angle, many of them a fraction of a pixel wide.
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (int i = 0; i < 120; ++i) {
    const double x = uniform(0, 2200), y = uniform(0, 2150), angle = uniform(0, 6.28), length = uniform(200, 2500);
    const double dx = length * std::cos(angle), dy = length * std::sin(angle), width = uniform(0.1, 6);
    const double z = uniform(8, 12);
    scenes::add_at_pixels(mesh, view.camera,
                          {{{x, y, z},
                            {x + dx, y + dy, z * uniform(0.9, 1.4)},
                            {x + dx - width * std::sin(angle), y + dy + width * std::cos(angle), z}}});
  }
  scenes::append(mesh, scenes::soup(view.camera, 400, 90, 8));
  Drawn drawn(mesh, view);
  const ViewVisibility found = drawn.classify();
  expect_same_visibility(found, drawn.classify_undrawn());
  EXPECT_EQ(found.classes, oracle_visibility(mesh, view).classes);
}

TEST(CpuIvm, FacesThatCrossTheCameraPlaneAreContestedInFull) {
  const View view = scenes::view_of(180, 130, 70);
  Mesh mesh;
  // A floor from behind the camera to the horizon, and things on it.
  scenes::add_face(mesh, {-1000, 1, -50}, {1000, 1, 1e4}, {1000, 1, -50});
  scenes::add_face(mesh, {-1000, 1, -50}, {-1000, 1, 1e4}, {1000, 1, 1e4});
  scenes::append(mesh, scenes::soup(view.camera, 150, 20, 31));
  for (std::size_t i = 6; i < mesh.positions.size(); ++i) mesh.positions[i].z -= 6;
  Drawn drawn(mesh, view);
  EXPECT_EQ(drawn.scan.codes[0], FaceCode::unsure);
  EXPECT_EQ(drawn.scan.codes[1], FaceCode::unsure);
  expect_oracle(mesh, view, drawn.classify());
}

/// A wall that recedes from 1 to 500 along the image, of `columns` strips, each of its depths `lift` further.
Mesh receding_wall(const Camera& camera, int columns, double lift) {
  Mesh mesh;
  for (int i = 0; i < columns; ++i) {
    const auto corner = [&](double across, double y) {
      // 1 / z is linear over the image.
      const double w = 1 + (1.0 / 500 - 1) * across;
      return std::array<double, 3>{0.4 + (camera.width - 1) * across, y, (1 + lift) / w};
    };
    const double from = static_cast<double>(i) / columns, to = (i + 1.0) / columns;
    const double bottom = camera.height - 0.7;
    scenes::add_at_pixels(mesh, camera, {corner(from, 0.3), corner(from, bottom), corner(to, 0.3)});
    scenes::add_at_pixels(mesh, camera, {corner(to, 0.3), corner(from, bottom), corner(to, bottom)});
  }
  return mesh;
}

TEST(CpuIvm, FacesThatRecedeFarAreNotTrustedToFloats) {
  // A wall of two faces and the same in strips, nearer or further by less than floats tell of the former.
  const View view = scenes::view_of(1003, 60, 900);
  for (const double lift : {-1e-5, -3e-6, -1e-6, -1e-9, 1e-9, 1e-6, 3e-6, 1e-5})
    for (const bool strips_first : {false, true}) {
      Mesh mesh = receding_wall(view.camera, strips_first ? 83 : 1, strips_first ? lift : 0);
      scenes::append(mesh, receding_wall(view.camera, strips_first ? 1 : 83, strips_first ? 0 : lift));
      Drawn drawn(mesh, view);
      EXPECT_GE(drawn.unsure(), 2U);
      EXPECT_EQ(drawn.classify().classes, oracle_visibility(mesh, view).classes) << lift;
    }
}

TEST(CpuIvm, OnlyFacesThatCoverAPixelExactlyClaimIt) {
  // Corners within rounding of pixel centres, twice, the second time nearer: doubles put many edges on the wrong side
  // of a centre. All faces are unsure, and cover one another and the faces behind.
  std::size_t claims = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
    };
    const auto whole = [&](int below) { return static_cast<int>(random() % static_cast<std::uint32_t>(below)); };
    const int width = 60 + whole(100), height = 60 + whole(100), reach = 4 + whole(20);
    View view = scenes::view_of(width, height, uniform(50, 300), width * uniform(0.3, 0.7), height * uniform(0.3, 0.7));
    view.camera.fy *= uniform(0.8, 1.25);
    Mesh mesh;
    for (int f = 0; f < 200; ++f) {
      const double x = whole(width) + 0.5, y = whole(height) + 0.5;
      std::array<std::array<double, 3>, 3> corners{};
      for (auto& corner : corners)
        corner = {x + whole(2 * reach + 1) - reach, y + whole(2 * reach + 1) - reach, uniform(9, 11)};
      scenes::add_at_pixels(mesh, view.camera, corners);
    }
    Mesh nearer = mesh;
    for (std::size_t i = 0; i < nearer.positions.size(); i += 3) {
      const double scale = 1 - uniform(1e-3, 1e-1);
      for (std::size_t k = i; k < i + 3; ++k) {
        WorldPoint& p = nearer.positions[k];
        p = {p.x * scale, p.y * scale, p.z * scale};
      }
    }
    scenes::append(mesh, nearer);
    scenes::add_at_pixels(mesh, view.camera, {{{-20.3, -11.7, 12}, {-5.1, 900.2, 12}, {1000.7, -30.9, 12}}});
    Drawn drawn(mesh, view);
    claims += drawn.scan.claims.size();
    const ViewVisibility expected = drawn.classify_undrawn();
    expect_same_visibility(drawn.classify(), expected);
    if (HasFailure()) FAIL() << "seed " << seed;
  }
  EXPECT_GT(claims, 100U);
}

TEST(CpuIvm, NeedlesBesideACornerOfTheFrame) {
  // Their rectangles reach into the image, they do not.
  const View view = scenes::view_of(700, 600, 500);
  Mesh mesh;
  for (double i = 0; i < 40; ++i) {
    // From below the image to the right of it.
    const double away = 350 + 5.1 * i, thin = 1e-5 * (i + 1);
    const double x = 700 - away, y = 600 - away;
    scenes::add_at_pixels(mesh, view.camera,
                          {{{x, 722 + away, 9}, {822.3 + away, y + thin, 9}, {822.3 + away, y - thin, 9}}});
  }
  ClassifyOptions unresolved;
  unresolved.subpixel = false;
  for (const ClassifyOptions& options : {ClassifyOptions{}, unresolved}) {
    Drawn drawn(mesh, view);
    expect_same_visibility(drawn.classify(options), drawn.classify_undrawn(options));
  }
}

TEST(CpuIvm, DepthsThatNoFloatHolds) {
  const View view = scenes::view_of(200, 160, 150);
  const Mesh mesh = scenes::soup(view.camera, 900, 9, 14);
  const ViewVisibility expected = Drawn(mesh, view).classify();
  for (const double scale : {0x1p-140, 0x1p-98, 0x1p97, 0x1p140}) {
    Mesh scaled = mesh;
    for (WorldPoint& p : scaled.positions) p = {p.x * scale, p.y * scale, p.z * scale};
    expect_same_visibility(Drawn(scaled, view).classify(), expected);
  }
}

TEST(CpuIvm, MasksAndLensesThatLeaveThePhoto) {
  View view = scenes::view_of(403, 331, 300, 190, 171);
  io::PhotoExclusion stripes{403, 331, 7, std::vector<std::uint64_t>(7 * 331)};
  for (std::size_t i = 0; i < stripes.words.size(); ++i) stripes.words[i] = i % 11 < 5 ? 0x00FFF0000F00FFFF : 0;
  const PhotoMask whole(view.camera), striped(whole, stripes);
  for (const double size : {0.8, 7.0, 90.0}) {
    const Mesh mesh = scenes::soup(view.camera, size > 50 ? 120 : 4000, size, 91);
    expect_classes_undrawn(mesh, view, striped);
    const Drawn drawn(mesh, view, striped);
    for (std::uint32_t pixel = 0; pixel < drawn.ivm.size(); ++pixel)
      ASSERT_TRUE(striped.contains(static_cast<int>(pixel % 403), static_cast<int>(pixel / 403)) ||
                  drawn.ivm[pixel] == kNoFace)
          << pixel;
    for (const Claim& claim : drawn.scan.claims)
      ASSERT_TRUE(striped.contains(static_cast<int>(claim.pixel % 403), static_cast<int>(claim.pixel / 403)));
  }
  view.camera.distortion.k1 = 0.3;
  limit_distortion(view.camera);
  const Mesh mesh = scenes::soup(view.camera, 4000, 7, 92);
  expect_classes_undrawn(mesh, view, PhotoMask(view.camera));
}

TEST(CpuIvm, NeitherTheOrderOfFacesNorThreadsMatter) {
  const View view = scenes::view_of(500, 400, 350);
  Mesh mesh = scenes::soup(view.camera, 6000, 9, 17);
  // So near each other that every comparison is a doubt, with ties among them.
  scenes::append(mesh, scenes::terrain(view.camera, 30, 30, 20, 20, 9.7, 16,
                                       [](int i, int j) { return 16 + 0.01 * ((i * 7 + j) % 5); }));
  scenes::append(mesh, scenes::terrain(view.camera, 30, 30, 20, 20, 9.7, 16,
                                       [](int i, int j) { return 16 + 0.01 * ((i * 7 + j) % 5); }));
  const Drawn usual(mesh, view);
  std::vector<std::uint32_t> order(mesh.faces.size());
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end() - 1800, std::mt19937(3));
  Mesh shuffled = mesh;
  for (std::size_t i = 0; i < order.size(); ++i) shuffled.faces[i] = mesh.faces[order[i]];
  const Drawn other(shuffled, view);
  for (std::size_t pixel = 0; pixel < usual.ivm.size(); ++pixel) {
    const FaceId face = other.ivm[pixel];
    ASSERT_EQ(face == kNoFace ? index(face) : order[index(face)], index(usual.ivm[pixel])) << pixel;
  }
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(other.scan.codes[i], usual.scan.codes[order[i]]);
  for (const std::size_t threads : {1U, 5U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Drawn again(mesh, view);
    EXPECT_EQ(again.ivm, usual.ivm);
    EXPECT_EQ(again.scan.codes, usual.scan.codes);
    EXPECT_EQ(again.scan.counts.samples, usual.scan.counts.samples);
    EXPECT_EQ(again.scan.counts.contested_samples, usual.scan.counts.contested_samples);
  }
}

// Boxes of faces in and around the frame, and across the camera plane: only such as have no face that is not outside().
TEST(FaceHulls, FacesOfABoxBesideTheFrameAreAllOutside) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> around(-60, 60), near_by(-1, 1);
  Mesh mesh;
  for (std::uint32_t box = 0; box < 3000; ++box) {
    const WorldPoint middle{around(random), around(random), around(random)};
    for (std::uint32_t f = 0; f < kFacesPerRectangle; ++f) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int i = 0; i < 3; ++i)
        mesh.positions.push_back(middle + WorldPoint{near_by(random), near_by(random), near_by(random)});
      mesh.faces.push_back({first, first + 1, first + 2});
    }
  }
  View view = scenes::view_of(130, 90, 100);
  view.pose.centre = {1, 2, 3};
  const double s = std::sqrt(0.5);
  view.pose.rotation = {s, 0, -s, 0, 1, 0, s, 0, s};
  ProjectedMesh projected;
  project_vertices(mesh, view.camera, view.pose, projected);
  const PhotoMask mask(view.camera);
  const std::vector<FaceId> nothing;
  const PreparedView prepared{mesh, view.camera, ViewId{}, mask, projected, nothing};
  std::vector<std::uint8_t> beside;
  FaceHulls(mesh).find_beside(view.camera, view.pose, beside);
  ASSERT_EQ(beside.size(), 3000u);
  std::size_t outside_boxes = 0, found = 0;
  for (std::uint32_t box = 0; box < 3000; ++box) {
    bool all = true;
    for (std::uint32_t f = 0; f < kFacesPerRectangle; ++f)
      all = all && outside(prepared.bounds(FaceId{box * std::uint32_t{kFacesPerRectangle} + f}), 130, 90);
    EXPECT_TRUE(beside[box] == 0 || all) << box;
    outside_boxes += all;
    found += beside[box];
  }
  EXPECT_GT(static_cast<double>(found), 0.9 * static_cast<double>(outside_boxes));
  EXPECT_LT(outside_boxes, 3000u);
}

TEST(CpuIvm, AViewBesideTheMeshIsEmpty) {
  View view = scenes::view_of(130, 90, 100);
  const Mesh mesh = scenes::soup(view.camera, 300, 9, 2);
  view.pose.centre = {1000, 0, 0};
  Drawn drawn(mesh, view);
  EXPECT_EQ(std::count(drawn.ivm.begin(), drawn.ivm.end(), kNoFace), 130 * 90);
  EXPECT_EQ(count_classes(drawn.classify().classes)[0], mesh.faces.size());
  const Mesh none;
  Drawn nothing(none, view);
  EXPECT_TRUE(nothing.classify().classes.empty());
}

}  // namespace
}  // namespace gpvc::visibility
