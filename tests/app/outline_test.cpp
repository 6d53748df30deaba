// Outlines of parts of a mesh from above, and what areas of lacking coverage are.
#include "app/query/outline.h"

#include <gtest/gtest.h>

#include "app/query/coverage.h"
#include "app/query/sharpness.h"

namespace gpvc::query {
namespace {

// Two faces for each mark of a picture whose last line is the south; the marks are a unit wide.
Mesh squares(const std::vector<std::string>& rows) {
  Mesh mesh;
  for (std::size_t j = 0; j < rows.size(); ++j)
    for (std::size_t i = 0; i < rows[j].size(); ++i) {
      if (rows[j][i] != '#') continue;
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      const double x = static_cast<double>(i), y = static_cast<double>(rows.size() - 1 - j);
      // A tenth inside, so that no corner lies on the border of a cell.
      for (const auto& [dx, dy] : {std::pair{0.1, 0.1}, {0.9, 0.1}, {0.9, 0.9}, {0.1, 0.9}})
        mesh.positions.push_back({x + dx, y + dy, 5});
      mesh.faces.push_back({first, first + 1, first + 2});
      mesh.faces.push_back({first, first + 2, first + 3});
    }
  return mesh;
}

std::vector<FaceId> all_faces(const Mesh& mesh) {
  std::vector<FaceId> faces;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) faces.push_back(FaceId{f});
  return faces;
}

double area_of(const GroundRing& ring) {
  double twice = 0;
  for (std::size_t n = 0; n + 1 < ring.size(); ++n) twice += ring[n][0] * ring[n + 1][1] - ring[n][1] * ring[n + 1][0];
  return twice / 2;
}

// Over 20 x 20 cells of a unit.
constexpr CellGrid kUnits{0, 0, 1, 20, 20};

TEST(Outline, RingsRunAroundCellsAndHoles) {
  const Mesh mesh = squares({"####",  //
                             "#..#",  //
                             "####",  //
                             "...#"});
  const auto polygons = outline_of(mesh, all_faces(mesh), kUnits);
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_EQ(area_of(polygons[0].outer), 13);
  EXPECT_EQ(polygons[0].outer.size(), 7U) << "six corners, and the first again";
  ASSERT_EQ(polygons[0].holes.size(), 1U);
  EXPECT_EQ(area_of(polygons[0].holes[0]), -2);
}

TEST(Outline, CellsThatMeetInACornerBecomeOnePolygonWithoutATouch) {
  const Mesh mesh = squares({"#..",  //
                             ".#.",  //
                             "..#"});
  const auto polygons = outline_of(mesh, all_faces(mesh), kUnits);
  ASSERT_EQ(polygons.size(), 1U);
  std::set<std::array<double, 2>> corners(polygons[0].outer.begin(), polygons[0].outer.end());
  EXPECT_EQ(corners.size() + 1, polygons[0].outer.size()) << "no corner twice but the first";
}

TEST(Outline, PartsAreApartAndWallsAreARowOfCells) {
  Mesh mesh = squares({"#.#"});
  mesh.positions.insert(mesh.positions.end(), {{8.5, 1.5, 0}, {8.5, 6.5, 0}, {8.5, 6.5, 9}});
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() - 3);
  mesh.faces.push_back({first, first + 1, first + 2});
  const auto polygons = outline_of(mesh, all_faces(mesh), kUnits);
  ASSERT_EQ(polygons.size(), 3U);
  double area = 0;
  for (const GroundPolygon& polygon : polygons) area += area_of(polygon.outer);
  EXPECT_EQ(area, 8);
}

TEST(Areas, AreNeighboursThatLackTheSame) {
  // A strip of four squares that share their sides.
  Mesh mesh;
  for (int i = 0; i <= 4; ++i) {
    mesh.positions.push_back({static_cast<double>(i), 0, 0});
    mesh.positions.push_back({static_cast<double>(i), 1, 0});
  }
  for (std::uint32_t i = 0; i < 4; ++i) {
    mesh.faces.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    mesh.faces.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  const float none = std::numeric_limits<float>::infinity();
  const FaceCoverage coverage{
      {0, 0, 1, 3, 3, 3, 0, 3}, {none, none, 1, 1, 1, 9, none, 1}, {none, none, 0, 0, 80, 0, none, 0}};
  const Wanted wanted = resolved({}, mesh, coverage);
  EXPECT_EQ(wanted.gsd, 2) << "twice the median";
  const std::vector<Lack> lacks = lacks_of(coverage, wanted);
  using enum Lack;
  EXPECT_EQ(lacks, (std::vector{unseen, unseen, few, nothing, grazing, coarse, unseen, nothing}));
  const std::vector<Area> areas = areas_of(mesh, coverage, lacks);
  ASSERT_EQ(areas.size(), 5U);
  EXPECT_EQ(areas[0].lack, unseen);
  EXPECT_EQ(areas[0].faces, (std::vector{FaceId{0}, FaceId{1}}));
  EXPECT_EQ(areas[0].surface, 1);
  EXPECT_NEAR(areas[0].middle.x, 0.5, 1e-12);
  EXPECT_EQ(areas[0].normal.z, 1);
}

TEST(Sharpness, GroundSamplingDistanceCountsTheSlant) {
  View view;
  view.camera = {1000, 1000, 500, 500, 500, 500, {}};
  view.reduction = 2;  // so that a pixel as taken is half as large
  const Sharpness straight = sharpness_of(view, {0, 0, 10}, {0, 0, -3});
  EXPECT_NEAR(straight.gsd, 10.0 / 500 / 2, 1e-12);
  EXPECT_NEAR(straight.angle, 0, 1e-6);
  const Sharpness slanted = sharpness_of(view, {0, 0, 10}, {std::sqrt(3.0), 0, -1});
  EXPECT_NEAR(slanted.angle, 60, 1e-9);
  EXPECT_NEAR(slanted.gsd, straight.gsd * std::sqrt(2.0), 1e-12) << "twice the surface in a pixel";
}

}  // namespace
}  // namespace gpvc::query
