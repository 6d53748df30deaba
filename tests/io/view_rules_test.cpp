#include "io/view_rules.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

using test::contains;

std::vector<io::ListedViewRule> parse(std::string_view text) { return io::parse_view_rules("rules", text); }

// One triangle at each of the points, so small that its middle is there.
Mesh triangles_at(const std::vector<WorldPoint>& points) {
  Mesh mesh;
  for (const WorldPoint& p : points) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(),
                          {{p.x - 0.01, p.y, p.z}, {p.x + 0.01, p.y - 0.01, p.z}, {p.x, p.y + 0.01, p.z}});
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

using Flags = std::vector<std::uint8_t>;

const std::string kJson = R"({"rules": [
  {"box": [[4, 0, 2], [0, 1, 3]], "forbid": "DJI_0012.JPG", "note": "the crane"},
  {"polygon": [[0, 0], [10, 0], [0, 10]], "z": [-1, 5], "allow": ["nadir_*", "east 7.jpg"]},
  {"faces": [7, [100, 120]], "forbid": ["*"]}]})";
const std::string kCsv =
    "# x y z\nbox, 4 0 2 0 1 3 ,forbid,DJI_0012.JPG\r\n\npolygon,0 0 10 0 0 10,allow,nadir_*; east 7.jpg\n"
    "faces,7 100-120,forbid,*";

TEST(ViewRules, JsonAndCsvSayTheSame) {
  const auto json = parse(kJson), csv = parse("\xEF\xBB\xBF" + kCsv);
  ASSERT_EQ(json.size(), 3u);
  ASSERT_EQ(csv.size(), 3u);
  for (const auto* rules : {&json, &csv}) {
    const auto& box = std::get<io::BoxRegion>((*rules)[0].region);
    EXPECT_EQ(box.low, (WorldPoint{0, 0, 2}));
    EXPECT_EQ(box.high, (WorldPoint{4, 1, 3}));
    EXPECT_FALSE((*rules)[0].allow);
    EXPECT_EQ((*rules)[0].photos, std::vector<std::string>{"DJI_0012.JPG"});
    const auto& ground = std::get<io::GroundRegion>((*rules)[1].region);
    EXPECT_EQ(ground.corners, (std::vector<std::array<double, 2>>{{0, 0}, {10, 0}, {0, 10}}));
    EXPECT_TRUE((*rules)[1].allow);
    EXPECT_EQ((*rules)[1].photos, (std::vector<std::string>{"nadir_*", "east 7.jpg"}));
    const auto& faces = std::get<io::FaceRegion>((*rules)[2].region);
    EXPECT_EQ(faces.ranges, (std::vector<std::array<std::uint32_t, 2>>{{7, 7}, {100, 120}}));
  }
  EXPECT_EQ(std::get<io::GroundRegion>(json[1].region).low, -1);
  EXPECT_EQ(std::get<io::GroundRegion>(json[1].region).high, 5);
  EXPECT_EQ(json[1].place, "rule 2");
  EXPECT_EQ(csv[1].place, "line 4");
}

TEST(ViewRules, ARectangleOfAPhotoIsAboutThatPhotoUnlessItSaysMore) {
  for (const char* text : {"photo,DJI 12.JPG 300 40 1 2.5\nphoto,a 1 2 3 4,allow,b;c",
                           R"({"rules": [{"photo": "DJI 12.JPG", "pixels": [[300, 40], [1, 2.5]]},
                      {"photo": "a", "pixels": [[1, 2], [3, 4]], "allow": ["b", "c"]}]})"}) {
    const auto rules = parse(text);
    ASSERT_EQ(rules.size(), 2u) << text;
    const auto& shown = std::get<io::PhotoRegion>(rules[0].region);
    EXPECT_EQ(shown.photo, "DJI 12.JPG");
    EXPECT_EQ((std::array{shown.low.x, shown.low.y, shown.high.x, shown.high.y}), (std::array{1.0, 2.5, 300.0, 40.0}));
    EXPECT_FALSE(rules[0].allow);
    EXPECT_EQ(rules[0].photos, std::vector<std::string>{"DJI 12.JPG"});
    EXPECT_TRUE(rules[1].allow);
    EXPECT_EQ(rules[1].photos, (std::vector<std::string>{"b", "c"}));
  }
}

// A square with a hole, and a second one beside it.
const std::string kGeoJson = R"({"type": "FeatureCollection",
  "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}, "features": [
  {"type": "Feature", "properties": {"id": 7, "allow": null, "forbid": "a.jpg; b*", "z": [-1, 1]},
   "geometry": {"type": "MultiPolygon", "coordinates": [
     [[[0, 0, 9], [9, 0, 9], [9, 9, 9], [0, 9, 9], [0, 0, 9]], [[3, 3], [3, 6], [6, 6], [6, 3], [3, 3]]],
     [[[20, 0], [21, 0], [21, 1], [20, 1], [20, 0]]]]}}]})";

TEST(ViewRules, GeoJsonHasHolesAndSeveralPolygonsAndItsSystem) {
  const auto rules = parse(kGeoJson);
  ASSERT_EQ(rules.size(), 1u);
  EXPECT_EQ(rules[0].srs, "urn:ogc:def:crs:EPSG::25832");
  EXPECT_EQ(rules[0].place, "feature 1");
  EXPECT_EQ(rules[0].photos, (std::vector<std::string>{"a.jpg", "b*"}));
  EXPECT_FALSE(rules[0].allow);
  const auto& ground = std::get<io::GroundRegion>(rules[0].region);
  EXPECT_EQ(ground.low, -1);
  EXPECT_EQ(ground.high, 1);
  const Mesh mesh = triangles_at({{1, 1, 0}, {4, 5, 0}, {8, 2, 0}, {20.5, 0.5, 0}, {15, 0.5, 0}, {2, 4, 0}, {1, 1, 2}});
  EXPECT_EQ(io::faces_in(ground, mesh), (Flags{1, 0, 1, 1, 0, 1, 0}));
  // Rings that are left open mean the same.
  std::string open = kGeoJson;
  for (const char* last : {", [0, 0, 9]]", ", [3, 3]]", ", [20, 0]]"})
    open.replace(open.find(last), std::strlen(last), "]");
  EXPECT_EQ(std::get<io::GroundRegion>(parse(open)[0].region).corners, ground.corners);
  std::string plain = kGeoJson;
  plain.replace(plain.find(R"("crs")"), 5, R"("src")");
  EXPECT_EQ(parse(plain)[0].srs, io::kGeoJsonSystem);
}

TEST(ViewRules, WhatIsWrongIsSaidWithItsPlace) {
  const struct {
    std::string text, place, reason;
  } kWrong[] = {
      {"", "rules", "expected at least one rule"},
      {"# nothing\n", "rules", "expected at least one rule"},
      {R"({"rules": []})", "rules", "expected at least one rule"},
      {R"({"rules": 3})", "rules", "expected a list as 'rules'"},
      {R"({"rules": [)", "byte", "well-formed"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "forbid": "a"}, {"forbid": "a"}]})", "rule 2", "one of 'box'"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "faces": [1], "forbid": "a"}]})", "rule 1", "one of 'box'"},
      {R"({"rules": [{"box": [[0,0,0],[1,1]], "forbid": "a"}]})", "rule 1", "2 rows of 3 numbers"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]]}]})", "rule 1", "one of 'allow' and 'forbid'"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "allow": "a", "forbid": "b"}]})", "rule 1", "one of 'allow'"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "forbid": []}]})", "rule 1", "at least one photo"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "forbid": [7]}]})", "rule 1", "names of photos"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "z": [0,1], "forbid": "a"}]})", "rule 1", "belongs to a polygon"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "forbids": "a", "forbid": "a"}]})", "rule 1", "'forbids'"},
      {R"({"rules": [{"polygon": [[0,0],[1,1]], "forbid": "a"}]})", "rule 1", "at least three corners"},
      {R"({"rules": [{"polygon": [], "forbid": "a"}]})", "rule 1", "rows of 2 numbers"},
      {R"({"rules": [{"polygon": [[0,0],[1,1],[0,1]], "z": [1,0], "forbid": "a"}]})", "rule 1", "lower and the higher"},
      {R"({"rules": [{"faces": [], "forbid": "a"}]})", "rule 1", "a list of faces"},
      {R"({"rules": [{"faces": [-1], "forbid": "a"}]})", "rule 1", "whole numbers from 0"},
      {R"({"rules": [{"faces": [[9, 3]], "forbid": "a"}]})", "rule 1", "from the lower"},
      {R"({"rules": [{"faces": [4294967296], "forbid": "a"}]})", "rule 1", "whole numbers from 0"},
      {"\nbox,0 0 0 1 1 1,forbid", "line 2", "expected REGION,NUMBERS"},
      {"box,0 0 0 1 1,forbid,a", "line 1", "found 5"},
      {"box,0 0 0 1 1 nan,forbid,a", "line 1", "finite number, found 'nan'"},
      {"box,0 0 0 1 1 1,veto,a", "line 1", "found 'veto'"},
      {"ball,0 0 0 1,forbid,a", "line 1", "found 'ball'"},
      {"box,0 0 0 1 1 1,forbid, ;", "line 1", "at least one photo"},
      {"polygon,0 0 1 1 2,allow,a", "line 1", "found 5 numbers"},
      {"faces,,allow,a", "line 1", "at least one face"},
      {"faces,3-,allow,a", "line 1", "whole numbers from 0"},
      {"faces,1.5,allow,a", "line 1", "whole numbers from 0"},
      {"photo,a 1 2 3", "line 1", "a photo and two corners"},
      {"photo,1 2 3 4", "line 1", "a photo and two corners"},
      {"photo,a 1 2 3 x", "line 1", "found 'x'"},
      {R"({"rules": [{"photo": "a", "forbid": "a"}]})", "rule 1", "'pixels'"},
      {R"({"rules": [{"box": [[0,0,0],[1,1,1]], "pixels": [[0,1],[2,3]], "forbid": "a"}]})", "rule 1", "to a photo"},
      {R"({"type": "Topology"})", "rules", "found 'Topology'"},
      {R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"forbid": "a"},
           "geometry": {"type": "Point", "coordinates": [1, 2]}}]})",
       "feature 1", "found 'Point'"},
      {R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"note": "a"},
           "geometry": {"type": "Polygon", "coordinates": [[[0,0],[1,0],[1,1],[0,0]]]}}]})",
       "feature 1", "one of 'allow' and 'forbid'"},
      {R"({"type": "Feature", "properties": {"forbid": "a"},
           "geometry": {"type": "Polygon", "coordinates": [[[0,0],[1,0],[0,0]]]}})",
       "the feature", "three corners"}};
  for (const auto& wrong : kWrong) {
    const std::string said = test::input_error([&] { parse(wrong.text); });
    EXPECT_TRUE(contains(said, wrong.place)) << wrong.text << " gave " << said;
    EXPECT_TRUE(contains(said, wrong.reason)) << wrong.text << " gave " << said;
  }
}

TEST(ViewRules, TruncatedFilesAreReadOrRefused) {
  for (const std::string& whole : {kJson, kCsv, kGeoJson})
    for (std::size_t length = 0; length < whole.size(); ++length) {
      try {
        EXPECT_LE(parse(std::string_view(whole).substr(0, length)).size(), 3u);
      } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
}

TEST(ViewRules, FilesAreRead) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(io::read_view_rules(folder.write("rules.json", kJson)).size(), 3u);
  EXPECT_EQ(io::read_view_rules(folder.write("rules.csv", kCsv)).size(), 3u);
  EXPECT_TRUE(contains(test::input_error([&] { io::read_view_rules(folder.path() / "none.csv"); }), "none.csv"));
}

// As a mesh editor's selection, or a script, writes them.
TEST(ViewRules, AListOfFacesMayBeAFile) {
  const test::TemporaryFolder folder;
  folder.write("lists/roof.txt", "\xEF\xBB\xBF# the roof\r\n7, 9\r\n100-120 # and its dormers\n\n3\n");
  for (const auto& [name, text] :
       {std::pair{"rules.csv", R"(faces,@lists/roof.txt,forbid,DJI_0012.JPG)"},
        {"rules.json", R"({"rules": [{"faces": "lists/roof.txt", "forbid": "DJI_0012.JPG"}]})"}}) {
    const auto rules = io::read_view_rules(folder.write(name, text));
    ASSERT_EQ(rules.size(), 1u) << name;
    EXPECT_EQ(std::get<io::FaceRegion>(rules[0].region).ranges,
              (std::vector<std::array<std::uint32_t, 2>>{{7, 7}, {9, 9}, {100, 120}, {3, 3}}));
    EXPECT_EQ(rules[0].photos, std::vector<std::string>{"DJI_0012.JPG"});
  }
  const auto error = [&](const std::string& list, const std::string& text) {
    folder.write("wrong.txt", text);
    const auto rules = folder.write("wrong.csv", "\nfaces,@" + list + ",allow,a");
    return test::input_error([&] { io::read_view_rules(rules); });
  };
  EXPECT_TRUE(contains(error("none.txt", ""), "wrong.csv: line 2: there is no list of faces "));
  EXPECT_TRUE(contains(error("wrong.txt", "1\n2.5\n"), "wrong.txt: line 2: expected faces as whole numbers from 0"));
  EXPECT_TRUE(contains(error("wrong.txt", "# none\n"), "wrong.txt: expected at least one face"));
}

TEST(ViewRules, BoxesHoldTheFacesWhoseMiddleIsInside) {
  const Mesh mesh = triangles_at({{1, 1, 1}, {1, 1, 3}, {-1, 1, 1}, {1.99, 1.99, 1.99}});
  EXPECT_EQ(io::faces_in(io::BoxRegion{{0, 0, 0}, {2, 2, 2}}, mesh), (Flags{1, 0, 0, 1}));
}

TEST(ViewRules, PolygonsMayBeConcaveAndEndAtHeights) {
  // An L around the square from (1, 1) to (2, 2), wound either way.
  io::GroundRegion ell{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
  const Mesh mesh =
      triangles_at({{0.5, 0.5, 0}, {1.5, 0.5, 9}, {0.5, 1.5, -9}, {1.5, 1.5, 0}, {-0.5, 1, 0}, {3, 1, 0}});
  EXPECT_EQ(io::faces_in(ell, mesh), (Flags{1, 1, 1, 0, 0, 0}));
  std::reverse(ell.corners.begin(), ell.corners.end());
  EXPECT_EQ(io::faces_in(ell, mesh), (Flags{1, 1, 1, 0, 0, 0}));
  ell.low = -1;
  ell.high = 1;
  EXPECT_EQ(io::faces_in(ell, mesh), (Flags{1, 0, 0, 0, 0, 0}));
}

// By crossing every side.
bool is_inside(const io::GroundRegion& region, double x, double y) {
  bool inside = false;
  for (std::size_t i = 0, j = region.corners.size() - 1; i < region.corners.size(); j = i++) {
    const auto &a = region.corners[i], &b = region.corners[j];
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]))) inside = !inside;
  }
  return inside;
}

TEST(ViewRules, PolygonsOfAnyShapeHoldWhatAnOddNumberOfSidesIsBeyond) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> place(0, 12);  // so that corners and points are at the same heights
  const auto any = [&] { return static_cast<double>(place(random)); };
  for (int n = 3; n < 60; ++n) {
    io::GroundRegion region;
    for (int i = 0; i < n; ++i) region.corners.push_back({any(), any()});
    Mesh mesh;
    for (std::uint32_t i = 0; i < 200; ++i) {
      mesh.positions.push_back({any(), any(), 0});
      mesh.faces.push_back({i, i, i});
    }
    const Flags inside = io::faces_in(region, mesh);
    for (std::size_t f = 0; f < inside.size(); ++f) {
      // The mean of three equal corners may be a unit in the last place away.
      const WorldPoint& p = mesh.positions[f];
      const double x = p.x / 3 + p.x / 3 + p.x / 3, y = p.y / 3 + p.y / 3 + p.y / 3;
      EXPECT_EQ(inside[f] != 0, is_inside(region, x, y)) << n << " corners, at " << x << " " << y;
    }
  }
}

// Each point compared with each side takes minutes; so does each face with each rule.
TEST(ViewRules, ManyCornersAndManyRegionsTakeNoMinutes) {
  std::vector<WorldPoint> points;
  for (int i = 0; i < 300000; ++i) points.push_back({0.01 * (i % 1000), 0.03 * (i / 1000), 0});
  const Mesh mesh = triangles_at(points);
  io::GroundRegion circle;
  for (int i = 0; i < 200000; ++i)
    circle.corners.push_back(
        {5 + 4 * std::cos(i * 3.14159265358979 / 100000), 5 + 4 * std::sin(i * 3.14159265358979 / 100000)});
  const auto start = std::chrono::steady_clock::now();
  const Flags inside = io::faces_in(circle, mesh);
  const auto count = static_cast<double>(std::ranges::count(inside, 1));
  EXPECT_NEAR(count / 300000, 3.14159 * 16 / (10 * 9), 0.01);
  const io::FaceLocator locator(mesh);
  std::size_t found = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = 0.01 * (i % 1000), y = 0.03 * (i / 1000);
    found += locator.faces_in(io::BoxRegion{{x - 0.004, y - 0.004, -1}, {x + 0.004, y + 0.004, 1}}).size();
  }
  EXPECT_EQ(found, 100000u);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

TEST(ViewRules, ListedFacesAreTaken) {
  const Mesh mesh = triangles_at({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  EXPECT_EQ(io::faces_in(io::FaceRegion{{{0, 0}, {2, 9}}}, mesh), (Flags{1, 0, 1, 1}));
}

}  // namespace
}  // namespace gpvc
