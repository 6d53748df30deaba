// What one view says of each face it sees: area, gradient, colour, and how close to a silhouette it lies.
#include "labeling/costs/view_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "labeling/costs/photo_lookup.h"
#include "labeling/costs/silhouettes.h"
#include "labeling/labeling.h"
#include "tests/labeling/view_scene.h"

namespace gpvc::labeling {
namespace {

using namespace test;

// --- statistics

ViewScratch scratch;  // shared by the tests, whose scenes differ

// A square of 24 x 24 pixels before a ramp of 2 grey levels a pixel, in two triangles of 288 px.
TEST(ViewStatistics, AreaGradientAndColor) {
  Mesh mesh;
  add_rectangle(mesh, -1.5, -1.5, 1.5, 1.5, 8, 1);
  const View view = view_from(0);
  const visibility::ViewVisibility visibility = look(mesh, view);
  const Image ramp = paint([](int x, int) { return Color{2 * x, 2 * x, 2 * x}; });
  CostOptions options;
  options.margin_px = 0;
  for (const auto& [term, expected] : {std::pair{DataTerm::area, 288.0}, {DataTerm::gmi, 576.0}}) {
    options.term = term;
    const auto records = view_statistics(mesh, view, ramp, visibility, options, scratch);
    ASSERT_EQ(records.size(), 2u);
    for (const FaceRecord& record : records) {
      EXPECT_NEAR(static_cast<double>(record.quality), expected, 1e-3);
      EXPECT_TRUE(record.is_full());
      EXPECT_EQ(record.margin, 0);
      EXPECT_EQ(record.steps(), 2 * 256);
    }
    // Columns 20 to 43; the first triangle has the left upper half of them, 24 pixels in the first column, one less in
    // each of the next: the centres on the diagonal belong to neither here, so 23.
    double sum = 0, count = 0;
    for (int column = 0; column < 24; ++column) {
      sum += (23 - column) * 2.0 * (20 + column);
      count += 23 - column;
    }
    EXPECT_NEAR(records[0].color[1] / 256.0, sum / count, 1.0 / 256);
  }
}

TEST(ViewStatistics, AngleCountsByItsSquaredCosine) {
  // The plane z = 8 + x tan(60 deg), seen at its centre under 60 degrees.
  Mesh mesh;
  add_rectangle(mesh, -0.05, -0.05, 0.05, 0.05, 8, 1);
  for (WorldPoint& p : mesh.positions) p.z += p.x * std::sqrt(3.0);
  const View view = view_from(0);
  visibility::ViewVisibility visibility = look(mesh, view);
  visibility.classes.assign(2, visibility::FaceClass::full);
  const Image ramp = paint([](int x, int) { return Color{2 * x, 2 * x, 2 * x}; });
  CostOptions options;
  const auto quality = [&](DataTerm term) {
    options.term = term;
    return static_cast<double>(view_statistics(mesh, view, ramp, visibility, options, scratch)[0].quality);
  };
  EXPECT_NEAR(quality(DataTerm::gmi_angle) / quality(DataTerm::gmi), 0.25, 0.01);
  EXPECT_NEAR(quality(DataTerm::area_angle) / quality(DataTerm::area), 0.25, 0.01);
}

// The projection of ground beside a level camera is of any size: what counts is what shows.
TEST(ViewStatistics, ProjectionsWithoutEndCountByTheirPixels) {
  const View view = view_from(0);
  for (const double ahead : {1e-3, 1e-9, 1e-17}) {
    Mesh mesh;
    mesh.positions = {{-1, 0.5, ahead}, {11, 0.5, ahead}, {0, 0.5, 10}};
    mesh.faces = {{0, 1, 2}};
    visibility::ViewVisibility visibility = look(mesh, view);
    visibility.classes = {visibility::FaceClass::partial};
    std::fill(visibility.ivm.faces.begin(), visibility.ivm.faces.end(), kNoFace);
    std::fill_n(visibility.ivm.faces.begin() + 100, 5, FaceId{0});
    visibility::FaceCoverage entry;
    entry.face = FaceId{0};
    entry.visible = 5;
    entry.visible_share = 0.5F;
    visibility.coverage.entries = {entry};
    CostOptions options;
    options.term = DataTerm::area;
    options.margin_px = 0;
    const auto records = view_statistics(mesh, view, grey(100), visibility, options, scratch);
    ASSERT_EQ(records.size(), 1u);
    EXPECT_EQ(records[0].quality, 5.0F) << ahead;
  }
}

// Rows are summed in blocks, by several threads.
TEST(ViewStatistics, FacesInSeveralBlocksOfRowsAreSummedOnce) {
  Mesh mesh;
  add_rectangle(mesh, -1.5, -1.5, 1.5, 1.5, 8, 1);
  View view = view_from(0);
  view.camera.height = 1000;
  visibility::ViewVisibility visibility;
  visibility.classes.assign(2, visibility::FaceClass::full);
  visibility.ivm = {kWidth, 1000, {}};
  Image photo{kWidth, 1000, 3, {}};
  std::array<std::uint64_t, 2> sum{}, pixels{};
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      const std::uint32_t face = x < y / 20 ? 0 : 1;
      visibility.ivm.faces.push_back(FaceId{face});
      photo.pixels.insert(photo.pixels.end(), 3, static_cast<std::uint8_t>(y / 4));
      sum[face] += static_cast<std::uint64_t>(y / 4);
      ++pixels[face];
    }
  for (int repeat = 0; repeat < 20; ++repeat) {
    const auto records = view_statistics(mesh, view, photo, visibility, CostOptions{}, scratch);
    ASSERT_EQ(records.size(), 2u);
    for (std::size_t f = 0; f < 2; ++f) EXPECT_EQ(records[f].color[1], (sum[f] * 256 + pixels[f] / 2) / pixels[f]);
  }
}

TEST(ViewStatistics, FaceWithoutAPixelIsLookedUpAtItsCentroid) {
  // A face of 0.2 px in pixel (40, 10), between four centres.
  Mesh mesh;
  mesh.positions = {{8.1 / 8, -13.9 / 8, 8}, {8.1 / 8, -13.7 / 8, 8}, {8.3 / 8, -13.9 / 8, 8}};
  mesh.faces = {{0, 1, 2}};
  const View view = view_from(0);
  visibility::ViewVisibility visibility = look(mesh, view);
  visibility.classes = {visibility::FaceClass::full};
  const Image photo = paint([](int x, int y) { return Color{x, y, 7}; });
  CostOptions options;
  options.term = DataTerm::area;
  const auto records = view_statistics(mesh, view, photo, visibility, options, scratch);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].color, (std::array<std::uint16_t, 3>{40 * 256, 10 * 256, 7 * 256}));
  EXPECT_NEAR(static_cast<double>(records[0].quality), 0.02, 1e-6);
}

TEST(ViewStatistics, CentroidFarOutsideThePhotoIsLookedUpAtItsBorder) {
  const View view = view_from(0);
  const Image photo = paint([](int x, int y) { return Color{x, y, 7}; });
  for (const double side : {-1.0, 1.0}) {
    Mesh mesh;
    mesh.positions = {{100 * side, -1, 1e-9}, {101 * side, -1, 1e-9}, {100 * side, 2, 1e-9}};
    mesh.faces = {{0, 1, 2}};
    visibility::ViewVisibility visibility = look(mesh, view);
    visibility.classes = {visibility::FaceClass::full};
    const auto records = view_statistics(mesh, view, photo, visibility, CostOptions{}, scratch);
    ASSERT_EQ(records.size(), 1u);
    EXPECT_EQ(records[0].color[0], side < 0 ? 0 : (kWidth - 1) * 256);
    EXPECT_EQ(records[0].color[1], 24 * 256);
  }
}

TEST(PhotoLookup, AgreesWithTheLensModel) {
  Camera camera{900, 700, 800, 810, 440, 360, {}};
  camera.distortion.k1 = -0.15;
  camera.distortion.k2 = 0.03;
  camera.distortion.p1 = 1e-3;
  limit_distortion(camera);
  const PhotoLookup lookup(camera);
  for (int y = 0; y < camera.height; y += 7) {
    std::vector<std::uint32_t> row;
    lookup.find_row(y, row);
    ASSERT_EQ(row.size(), 900u);
    for (int x = 0; x < camera.width; ++x) {
      const auto exact = photo_from_pixel(camera, {x + 0.5, y + 0.5});
      ASSERT_TRUE(exact.has_value());
      const std::uint32_t found = row[static_cast<std::size_t>(x)];
      ASSERT_NE(found, PhotoLookup::kNoPixel);
      // The exact point lies in the pixel found, or outside by no more than the lattice's error.
      const double px = found % 900, py = found / 900;
      const double ex = std::clamp(exact->x, 0.0, 900.0), ey = std::clamp(exact->y, 0.0, 700.0);
      EXPECT_LE(std::max({px - ex, ex - (px + 1), py - ey, ey - (py + 1)}), 0.03) << x << ' ' << y;
    }
  }
}

// --- silhouettes

TEST(Silhouettes, StripOnBothSidesOfAnOccluder) {
  // A board at z = 4 covers columns 24..39 and rows 16..31 of a wall at z = 8 (no centre on the wall's diagonal).
  Mesh mesh;
  add_rectangle(mesh, -8.1, -8.2, 8.3, 8.4, 8, 1);
  add_rectangle(mesh, -0.5, -0.5, 0.5, 0.505, 4, 1);
  for (const int margin_px : {1, 3, 5}) {
    const auto margin = margin_of(mesh, view_from(0), margin_px);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        // Distances to the board's outline, counted in pixels from 1, inside positive.
        const int inside = std::min(std::min(x - 23, 40 - x), std::min(y - 15, 32 - y));
        const int outside = std::max(std::max(24 - x, x - 39), std::max(16 - y, y - 31));
        const bool expected = inside > 0 ? inside <= margin_px : outside <= margin_px;
        // Beyond the outline's corners the strip may be round or square: not tested.
        if (inside <= 0 && (x < 24 || x > 39) && (y < 16 || y > 31)) continue;
        ASSERT_EQ(margin[static_cast<std::size_t>(y * kWidth + x)] != 0, expected)
            << x << ' ' << y << " margin " << margin_px;
      }
  }
}

TEST(Silhouettes, FoldAndSlopeAreNone) {
  // A roof: two steep planes that meet in the middle, each in several triangles.
  Mesh mesh;
  add_rectangle(mesh, -8, -8, 0, 8, 8, 2);
  add_rectangle(mesh, 0, -8, 8, 8, 8, 2);
  for (WorldPoint& p : mesh.positions) p.z += 0.6 * std::abs(p.x);
  const auto margin = margin_of(mesh, view_from(0), 3);
  EXPECT_EQ(std::count(margin.begin(), margin.end(), 1), 0);
}

TEST(Silhouettes, StepOfLessThanTheMarginsFootprintsIsNone) {
  // A pixel is 1/8 at z = 8; a step of 0.3 is 2.4 of them.
  Mesh mesh;
  add_rectangle(mesh, -8, -8, 0, 8, 8, 1);
  add_rectangle(mesh, 0, -8, 8, 8, 7.7, 1);
  for (const auto& [margin_px, found] : {std::pair{2, true}, {3, false}}) {
    const auto margin = margin_of(mesh, view_from(0), margin_px);
    EXPECT_EQ(std::count(margin.begin(), margin.end(), 1) > 0, found) << margin_px;
  }
}

TEST(Silhouettes, SkyIsADiscontinuityAndThePhotosBorderIsNot) {
  // A board before nothing, columns 16..47 from the top to the bottom of the image.
  Mesh mesh;
  add_rectangle(mesh, -2, -8, 2, 8, 8, 1);
  const auto margin = margin_of(mesh, view_from(0), 2);
  for (int x = 0; x < kWidth; ++x)
    EXPECT_EQ(margin[static_cast<std::size_t>(20 * kWidth + x)] != 0, (x >= 14 && x < 18) || (x >= 46 && x < 50)) << x;
  // The same through a lens whose model ends 8 px from the centre: empty pixels beyond are not sky.
  View view = view_from(0);
  view.camera.distortion.k1 = 1e-9;
  view.camera.distortion.max_r2 = 0.125 * 0.125;
  visibility::ViewVisibility visibility = look(mesh, view);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (!in_photo(view.camera, {x + 0.5, y + 0.5}))
        visibility.ivm.faces[static_cast<std::size_t>(y * kWidth + x)] = kNoFace;
  const auto cleared = strip_of({view.camera, visibility.ivm, 2}, [](const auto&, const auto&) {});
  EXPECT_EQ(std::count(cleared.begin(), cleared.end(), 1), 0);
}

}  // namespace
}  // namespace gpvc::labeling
