// The tree of tiles, its levels of detail, and tileset.json.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "app/pipeline/texture_files.h"
#include "app/tileset/tile_files.h"
#include "app/tileset/tile_tree.h"
#include "app/tileset/tileset_json.h"
#include "io/error.h"
#include "io/mesh.h"
#include "io/reference_system.h"
#include "io/vector.h"
#include "tests/support/errors.h"
#include "tests/support/grid_mesh.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/without_grids.h"
#include "visibility/baselines/ray_mesh.h"

namespace gpvc::tileset {
namespace {

using Json = nlohmann::json;

// Hills of 64 x 48 squares of 1 m.
Mesh hills() {
  Mesh mesh = test::grid_mesh(64, 48, 1);
  for (WorldPoint& p : mesh.positions)
    p.z = 2 * std::sin(0.2 * p.x) * std::cos(0.15 * p.y) + 0.3 * std::sin(p.x + 2 * p.y);
  return mesh;
}

using Corner = std::array<double, 3>;
using Edge = std::set<Corner>;

Corner place(const WorldPoint& p) { return {p.x, p.y, p.z}; }

// Per tile, the edges that a single one of its faces has. \param shift bits of the tile's number that are dropped
std::map<std::uint32_t, std::set<Edge>> borders(const Mesh& mesh, const std::vector<std::uint32_t>& tile, int shift) {
  std::map<std::uint32_t, std::map<Edge, int>> faces_of;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t e = 0; e < 3; ++e) {
      const auto &a = mesh.positions[mesh.faces[f][e]], &b = mesh.positions[mesh.faces[f][(e + 1) % 3]];
      ++faces_of[tile[f] >> shift][{place(a), place(b)}];
    }
  std::map<std::uint32_t, std::set<Edge>> result;
  for (const auto& [t, edges] : faces_of)
    for (const auto& [edge, count] : edges)
      if (count == 1) result[t].insert(edge);
  return result;
}

TEST(TileTree, DepthIsTheLeastThatFits) {
  for (const auto& [faces, leaves, depth] :
       std::vector<std::array<std::size_t, 3>>{{100, 1, 0}, {101, 2, 1}, {400, 4, 1}, {401, 5, 2}, {0, 1, 0}}) {
    EXPECT_EQ(leaf_count(faces, 100), leaves);
    EXPECT_EQ(tree_depth(leaves), static_cast<int>(depth));
  }
}

TEST(TileTree, LeavesHaveEquallyManyFacesAndDoNotOverlap) {
  const Mesh mesh = hills();
  const std::vector<std::uint32_t> leaf = leaf_of_faces(mesh, io::UpAxis::pos_z, 16);
  std::vector<std::size_t> count(16, 0);
  std::vector<std::array<double, 4>> box(16, {1e9, -1e9, 1e9, -1e9});
  for (std::size_t f = 0; f < leaf.size(); ++f) {
    ASSERT_LT(leaf[f], 16u);
    ++count[leaf[f]];
    WorldPoint m;
    for (const std::uint32_t v : mesh.faces[f]) m = m + mesh.positions[v] * (1.0 / 3);
    auto& b = box[leaf[f]];
    b = {std::min(b[0], m.x), std::max(b[1], m.x), std::min(b[2], m.y), std::max(b[3], m.y)};
  }
  for (std::size_t a = 0; a < 16; ++a) {
    EXPECT_EQ(count[a], mesh.faces.size() / 16);
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_TRUE(box[a][1] <= box[b][0] || box[b][1] <= box[a][0] || box[a][3] <= box[b][2] || box[b][3] <= box[a][2])
          << a << " and " << b;
  }
}

// A tree of which all leaves are taken would leave a third of the faces that were asked for to each.
TEST(TileTree, LeavesHaveAboutAsManyFacesAsWereAskedFor) {
  const Mesh mesh = hills();
  const std::size_t most = 1200, leaves = leaf_count(mesh.faces.size(), most);
  EXPECT_EQ(leaves, 6u);
  std::map<std::uint32_t, std::size_t> faces, of_parent;
  for (const std::uint32_t leaf : leaf_of_faces(mesh, io::UpAxis::pos_z, leaves)) {
    ++faces[leaf];
    ++of_parent[leaf / 4];
  }
  EXPECT_EQ(faces.size(), leaves);
  for (const auto& [leaf, count] : faces) {
    EXPECT_LT(leaf, 16u);
    EXPECT_NEAR(static_cast<double>(count), static_cast<double>(mesh.faces.size()) / 6, 1);
  }
  EXPECT_EQ(of_parent.size(), 4u) << "no tile above is empty";
}

TEST(TileTree, TheVerticalAxisIsNotDivided) {
  Mesh mesh = hills();
  for (WorldPoint& p : mesh.positions) p = {p.x, 100 * p.z, -p.y};  // y up, and higher than the ground is wide
  const Mesh upright = hills();
  EXPECT_EQ(leaf_of_faces(mesh, io::UpAxis::pos_y, 1), std::vector<std::uint32_t>(mesh.faces.size(), 0));
  const std::vector<std::uint32_t> leaf = leaf_of_faces(mesh, io::UpAxis::pos_y, 4);
  for (std::size_t f = 0; f < leaf.size(); ++f) {
    double x = 0;
    for (const std::uint32_t v : mesh.faces[f]) x += mesh.positions[v].x / 3;
    EXPECT_EQ(leaf[f] < 2, x < 32) << "the first cut is across x, the longer axis";
  }
}

TEST(LevelsOfDetail, TilesOfAnyLevelsMeetWithoutACrack) {
  for (const std::size_t leaves : {std::size_t{16}, std::size_t{6}}) {
    const Mesh mesh = hills();
    const std::vector<std::uint32_t> leaf = leaf_of_faces(mesh, io::UpAxis::pos_z, leaves);
    std::vector<double> error(16, 0);
    LevelMesh level = coarser_level(mesh, leaf, error);
    for (int k = 1; k <= 2; ++k) {
      ASSERT_EQ(level.error.size(), std::size_t{16} >> (2 * k));
      EXPECT_LT(level.mesh.faces.size(), mesh.faces.size() >> (2 * k - 1)) << "level " << k;
      EXPECT_TRUE(std::ranges::is_sorted(level.tile));
      // A tile's border is that of the leaves below it: the same vertices, and the same edges between them.
      EXPECT_EQ(borders(level.mesh, level.tile, 0), borders(mesh, leaf, 2 * k)) << "level " << k;
      for (const double e : level.error) {
        EXPECT_GT(e, 0.01) << "ripples of 0.3 m are simplified away";
        EXPECT_LT(e, 4) << "hills are 4 m high";
      }
      if (k == 1) level = coarser_level(level.mesh, level.tile, level.error);
    }
  }
}

// Points on the edges that two tiles share.
std::vector<WorldPoint> shared_border(const Mesh& mesh, const std::vector<std::uint32_t>& tile) {
  std::map<Edge, int> tiles_of;
  for (const auto& [t, edges] : borders(mesh, tile, 0))
    for (const Edge& edge : edges) ++tiles_of[edge];
  std::vector<WorldPoint> points;
  for (const auto& [edge, count] : tiles_of) {
    if (count != 2) continue;
    const Corner &a = *edge.begin(), &b = *edge.rbegin();
    for (const double s : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      const auto between = [&](std::size_t axis) { return (1 - s) * a[axis] + s * b[axis]; };
      points.push_back({between(0), between(1), between(2)});
    }
  }
  return points;
}

// How many rays straight down, beside the places and at most 3 mm from them, find nothing to stop them.
std::size_t rays_that_pass(const Mesh& mesh, std::span<const WorldPoint> places) {
  const visibility::RayMesh traced(mesh);
  std::size_t passed = 0;
  for (const WorldPoint& place : places) {
    std::vector<visibility::RayMesh::Target> below;
    Pose above;
    above.centre = place + WorldPoint{0, 0, 20};
    for (const double x : {-0.002, 0.0, 0.002})
      for (const double y : {-0.002, 0.0, 0.002}) below.push_back(traced.target(place + WorldPoint{x, y, -20}, above));
    traced.trace(above, 0, below);
    passed += static_cast<std::size_t>(std::ranges::count_if(below, [](const auto& t) { return t.visible; }));
  }
  return passed;
}

// The tiles of a mesh and of the levels above it.
struct Level {
  Mesh mesh;
  std::vector<std::uint32_t> tile;
};

void append(Mesh& to, const Level& level, std::uint32_t tile) {
  const auto first = static_cast<std::uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), level.mesh.positions.begin(), level.mesh.positions.end());
  for (std::size_t f = 0; f < level.mesh.faces.size(); ++f) {
    if (level.tile[f] != tile) continue;
    const Triangle& face = level.mesh.faces[f];
    to.faces.push_back({first + face[0], first + face[1], first + face[2]});
  }
}

TEST(LevelsOfDetail, NoRayPassesBetweenTilesOfDifferentLevels) {
  std::vector<Level> levels(1);
  levels[0].mesh = hills();
  levels[0].tile = leaf_of_faces(levels[0].mesh, io::UpAxis::pos_z, 64);
  std::vector<double> error(64, 0);
  for (int k = 1; k <= 2; ++k) {
    LevelMesh coarser = coarser_level(levels.back().mesh, levels.back().tile, error);
    error = coarser.error;
    levels.push_back({std::move(coarser.mesh), std::move(coarser.tile)});
  }
  const std::vector<WorldPoint> places = shared_border(levels[0].mesh, levels[0].tile);
  ASSERT_GT(places.size(), 1000u);
  // What a viewer may show: each of the four quarters as one tile of level 2, four of level 1 or 16 of level 0, or two of
  // level 1 beside eight of level 0.
  for (std::uint32_t cut = 0; cut < 24; ++cut) {
    Mesh shown;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
      const std::uint32_t way = (cut >> quarter ^ cut * quarter) % 4;
      if (way == 0) append(shown, levels[2], quarter);
      for (std::uint32_t t = 4 * quarter; way > 0 && t < 4 * quarter + 4; ++t) {
        if (way == 1 || (way == 3 && t % 2 == 0)) {
          append(shown, levels[1], t);
        } else {
          for (std::uint32_t leaf = 4 * t; leaf < 4 * t + 4; ++leaf) append(shown, levels[0], leaf);
        }
      }
    }
    EXPECT_EQ(rays_that_pass(shown, places), 0u) << "cut " << cut;
  }
  // A crack of 1 cm is found.
  Mesh cracked;
  for (std::uint32_t quarter = 0; quarter < 3; ++quarter) append(cracked, levels[2], quarter);
  Level moved = levels[2];
  for (WorldPoint& p : moved.mesh.positions) p = p + WorldPoint{0.01, 0.01, 0};
  append(cracked, moved, 3);
  EXPECT_GT(rays_that_pass(cracked, places), 100u);
}

TEST(LevelsOfDetail, FlatGroundKeepsFacesOfModestSize) {
  const Mesh flat = test::grid_mesh(96, 96, 1);
  LevelMesh level{flat, leaf_of_faces(flat, io::UpAxis::pos_z, 16), {}};
  level.error.assign(16, 0);
  for (int k = 1; k <= 2; ++k) {
    level = coarser_level(level.mesh, level.tile, level.error);
    EXPECT_LT(level.mesh.faces.size(), flat.faces.size() >> (2 * k - 1)) << "level " << k;
    double area = 0, longest = 0;
    for (const Triangle& t : level.mesh.faces) {
      const auto edge = [&](std::size_t i) {
        return level.mesh.positions[t[(i + 1) % 3]] - level.mesh.positions[t[i]];
      };
      area += length(cross(edge(0), edge(1))) / 2;
      for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, length(edge(i)));
    }
    EXPECT_DOUBLE_EQ(area, 96 * 96);
    const double mean_edge = 1 << k;
    EXPECT_LT(longest, 6 * mean_edge) << "level " << k;
  }
}

// Every second copy of a mesh turned over, or corners that no two faces share.
Mesh doubled(const Mesh& mesh, bool alternating) {
  Mesh both = mesh;
  both.faces.clear();
  for (const Triangle& t : mesh.faces) {
    both.faces.push_back(t);
    if (alternating) both.faces.push_back({t[0], t[2], t[1]});
  }
  for (const Triangle& t : mesh.faces)
    if (!alternating) both.faces.push_back({t[0], t[2], t[1]});
  return both;
}

Mesh unshared(const Mesh& mesh) {
  Mesh apart;
  for (const Triangle& t : mesh.faces) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t v : t) apart.positions.push_back(mesh.positions[v]);
    apart.faces.push_back({first, first + 1, first + 2});
  }
  return apart;
}

TEST(LevelsOfDetail, NoRayPassesWhereFacesHaveTwoSidesOrShareNoVertex) {
  for (const Mesh& mesh : {doubled(hills(), false), doubled(hills(), true), unshared(hills())}) {
    Level finest{mesh, leaf_of_faces(mesh, io::UpAxis::pos_z, 16)};
    const LevelMesh coarse = coarser_level(finest.mesh, finest.tile, std::vector<double>(16, 0));
    EXPECT_LT(coarse.mesh.faces.size(), mesh.faces.size() / 3);
    EXPECT_GT(coarse.mesh.faces.size(), mesh.faces.size() / 8);
    const Mesh& plain = hills();
    const std::vector<WorldPoint> places = shared_border(plain, leaf_of_faces(plain, io::UpAxis::pos_z, 4));
    ASSERT_GT(places.size(), 100u);
    Mesh shown;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
      if (quarter % 2 == 0) append(shown, {coarse.mesh, coarse.tile}, quarter);
      for (std::uint32_t leaf = 4 * quarter; quarter % 2 != 0 && leaf < 4 * quarter + 4; ++leaf)
        append(shown, finest, leaf);
    }
    EXPECT_EQ(rays_that_pass(shown, places), 0u);
  }
}

// --- tileset.json

WorldPoint placed(const std::array<double, 16>& m, const TilePoint& p) {
  std::array<double, 3> q{};
  for (std::size_t row = 0; row < 3; ++row)
    q[row] = m[row] * p.at[0] + m[4 + row] * p.at[1] + m[8 + row] * p.at[2] + m[12 + row];
  return {q[0], q[1], q[2]};
}

TEST(TilesetJson, UtmIsPlacedOnTheEarth) {
  for (const char* srs : {"EPSG:25832", "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs"})
    for (const io::UpAxis up : {io::UpAxis::pos_z, io::UpAxis::pos_y, io::UpAxis::neg_x}) {
      io::ModelOptions options;
      options.srs = srs;
      options.offset = {400, 300, 20};
      options.srs_offset = {690000, 5330000, 500};
      options.up = up;
      const auto matrix = geocentric_from_tile(options);
      ASSERT_TRUE(matrix);
      for (const WorldPoint& p : {WorldPoint{400, 300, 20}, {450, 280, 35}, {380, 360, 10}}) {
        std::array<WorldPoint, 1> truth{p + options.srs_offset};
        io::transform_points(options.srs, io::kGeocentric, truth);
        // Over 70 m the ellipsoid falls from its tangent plane by 0.4 mm.
        EXPECT_LT(length(placed(*matrix, tile_from_world(options, p)) - truth[0]), 0.001);
      }
    }
}

TEST(TilesetJson, EastNorthUpIsPlacedOnTheEarth) {
  io::ModelOptions options;
  options.srs = "ENU:48.5,11.25";
  options.up = io::UpAxis::pos_z;
  const auto matrix = geocentric_from_tile(options);
  ASSERT_TRUE(matrix);
  std::array<WorldPoint, 2> truth{WorldPoint{11.25, 48.5, 0}, {11.25, 48.5, 30}};
  io::transform_points("EPSG:4979", io::kGeocentric, truth);
  EXPECT_LT(length(placed(*matrix, tile_from_world(options, {0, 0, 0})) - truth[0]), 1e-6);
  EXPECT_LT(length(placed(*matrix, tile_from_world(options, {0, 0, 30})) - truth[1]), 1e-6);
  const WorldPoint north = placed(*matrix, tile_from_world(options, {0, 100, 0})) - truth[0];
  EXPECT_GT(north.z, 0.6 * 100) << "north is towards the pole";
}

// Left as they are, heights above the geoid would put tiles 48 m into the ground.
TEST(TilesetJson, HeightsWhoseGridIsMissingAreNotPlaced) {
  io::ModelOptions options;
  options.srs = "EPSG:32632+3855";
  options.srs_offset = {500000, 5600000, 100};
  const test::WithoutGrids without;
  EXPECT_FALSE(geocentric_from_tile(options));
  EXPECT_TRUE(obstacle_to_geocentric(options).starts_with("PROJ lacks the grid ")) << obstacle_to_geocentric(options);
}

TEST(TilesetJson, WithoutAKnownSystemThereIsNoTransform) {
  for (const char* srs : {"", "LOCAL", "ENU:north"}) {
    io::ModelOptions options;
    options.srs = srs;
    EXPECT_FALSE(geocentric_from_tile(options)) << srs;
    EXPECT_FALSE(obstacle_to_geocentric(options).empty()) << srs;
  }
}

io::ModelOptions local_options(io::UpAxis up) {
  io::ModelOptions options;
  options.offset = {4000, 3000, 20};
  options.up = up;
  return options;
}

TEST(TilesetJson, WithoutASystemTilesKeepTheScenesCoordinates) {
  for (const io::UpAxis up : {io::UpAxis::pos_z, io::UpAxis::neg_y, io::UpAxis::pos_x}) {
    const io::ModelOptions options = local_options(up);
    for (const WorldPoint& p : {WorldPoint{4000, 3000, 20}, {4010, 2990, 25}})
      EXPECT_LT(length(placed(root_transform(options, {}), tile_from_world(options, p)) - p), 1e-9);
    EXPECT_EQ(remark_on_placing(options, {}),
              "the tiles are in the scene's own coordinates: no reference system is known");
  }
}

TEST(TilesetJson, APlaceIsEastNorthUpTurnedByTheHeading) {
  const io::ModelOptions options = local_options(io::UpAxis::pos_z);
  for (const double heading : {0.0, 90.0, 30.0}) {
    const Matrix matrix = root_transform(options, Place{48.5, 11.25, 600, heading});
    std::array<WorldPoint, 2> truth{WorldPoint{11.25, 48.5, 600}, {11.25, 48.5, 640}};
    io::transform_points("EPSG:4979", io::kGeocentric, truth);
    const auto at = [&](const WorldPoint& p) { return placed(matrix, tile_from_world(options, options.offset + p)); };
    EXPECT_LT(length(at({0, 0, 0}) - truth[0]), 1e-6);
    EXPECT_LT(length(at({0, 0, 40}) - truth[1]), 1e-6);
    std::array<WorldPoint, 2> ground{at({0, 100, 0}), at({100, 0, 0})};
    io::transform_points(io::kGeocentric, "EPSG:4979", ground);
    const double metre = 180 / std::numbers::pi / 6.38e6, radians = heading * std::numbers::pi / 180;
    const auto east = [&](const WorldPoint& p) {
      return (p.x - 11.25) * std::cos(48.5 * std::numbers::pi / 180) / metre;
    };
    const auto north = [&](const WorldPoint& p) { return (p.y - 48.5) / metre; };
    EXPECT_NEAR(east(ground[0]), 100 * std::sin(radians), 1) << "y points where the heading is, from north to east";
    EXPECT_NEAR(north(ground[0]), 100 * std::cos(radians), 1);
    EXPECT_NEAR(east(ground[1]), 100 * std::cos(radians), 1);
    EXPECT_NEAR(north(ground[1]), -100 * std::sin(radians), 1);
  }
}

TEST(TilesetJson, APlaceIsForScenesWithoutASystem) {
  Scene scene;
  scene.source = "site";
  const Place place{48.5, 11.25, 600, 0};
  EXPECT_NO_THROW(refuse_place(scene, {}, place));
  scene.srs = "LOCAL";
  EXPECT_NO_THROW(refuse_place(scene, {}, place));
  scene.srs = "EPSG:25832";
  scene.offset = {691000, 5334000, 0};
  EXPECT_NO_THROW(refuse_place(scene, {}, {}));
  const std::optional<Error> error = test::caught([&] { refuse_place(scene, {}, place); });
  ASSERT_TRUE(error);
  EXPECT_TRUE(test::contains(error->what(), "site: names the reference system EPSG:25832, which places the tiles"));
}

TEST(TilesetJson, SaysWhatHeightsAreAbove) {
  io::ModelOptions options;
  options.srs = "EPSG:32632+5773";
  options.srs_offset = {691000, 5334000, 100};
  const std::string remark = remark_on_placing(options, {});
  EXPECT_TRUE(test::contains(remark,
                             "heights of EPSG:32632+5773 are above EGM96 geoid, those of the tiles above the "
                             "ellipsoid: 145."))
      << remark << " (the geoid is 46 m above the ellipsoid in Munich)";
  EXPECT_TRUE(test::contains(remark, " m where the scene's is 100")) << remark;
  options.srs = "EPSG:25832";
  EXPECT_EQ(remark_on_placing(options, {}),
            "EPSG:25832 says nothing of heights: the scene's are taken for heights above the ellipsoid");
  options.srs = "ENU:48.5,11.25";
  EXPECT_EQ(remark_on_placing(options, {}), "");
}

TEST(TilesetJson, TheAssetTellsWhoseItIsAndWhereItLies) {
  std::vector<std::vector<Tile>> levels(1);
  levels[0].push_back({"tiles/0_0.glb", {}, 0});
  levels[0][0].box.add(TilePoint{{1, 1, 1}});
  const auto asset = [&](const io::ModelOptions& options) {
    return Json::parse(tileset_text(levels, options, {}))["asset"];
  };
  EXPECT_FALSE(asset({}).contains("copyright"));
  io::ModelOptions options;
  options.copyright = "City of \xC3\x9Clm, 2026";
  options.srs = "EPSG:25832";
  options.offset = {400, 300, 20};
  options.srs_offset = {690000, 5330000, 500};
  const Json json = asset(options);
  EXPECT_EQ(json["copyright"], options.copyright);
  EXPECT_EQ(json["extras"]["srs"], "EPSG:25832");
  EXPECT_EQ(json["extras"]["offset"], Json({690400, 5330300, 520}));
  EXPECT_TRUE(json["extras"]["program"].get<std::string>().starts_with("gpvc "));
  EXPECT_EQ(json["extras"]["date"].get<std::string>().size(), std::string("2026-11-27").size());
}

TEST(TilesetJson, TilesWhoseYIsUpAreTurned) {
  io::ModelOptions options;
  options.up = io::UpAxis::pos_y;
  const TilePoint p = tile_from_world(options, {1, 2, 3});
  EXPECT_EQ(p.at, (std::array<double, 3>{1, -3, 2}));
  options.up = io::UpAxis::pos_z;
  EXPECT_EQ(tile_from_world(options, {1, 2, 3}).at, (std::array<double, 3>{1, 2, 3}));
}

TEST(TilesetJson, ParentsHoldTheirChildren) {
  std::vector<std::vector<Tile>> levels(2);
  for (int n = 0; n < 4; ++n) {
    Tile tile{"tiles/0_" + std::to_string(n) + ".glb", {}, 0};
    tile.box.add(TilePoint{{10.0 * n, 0, 0}});
    tile.box.add(TilePoint{{10.0 * n + 8, 6, 4}});
    levels[0].push_back(tile);
  }
  levels[0][2] = {};  // without faces
  levels[1].push_back({"tiles/1_0.glb", {}, 0.5});
  levels[1][0].box.add(TilePoint{{1, 1, 1}});
  io::ModelOptions options;
  options.up = io::UpAxis::pos_z;
  const Json json = Json::parse(tileset_text(levels, options, {}));
  EXPECT_EQ(json["asset"]["version"], "1.1");
  const Json& root = json["root"];
  EXPECT_EQ(root["refine"], "REPLACE");
  EXPECT_EQ(root["geometricError"], 0.5);
  EXPECT_GT(json["geometricError"], root["geometricError"]);
  EXPECT_EQ(root["boundingVolume"]["box"], Json({19, 3, 2, 19, 0, 0, 0, 3, 0, 0, 0, 2}));
  ASSERT_EQ(root["children"].size(), 3u);
  EXPECT_EQ(root["children"][2]["content"]["uri"], "tiles/0_3.glb");
  EXPECT_EQ(root["children"][0]["geometricError"], 0);
  EXPECT_FALSE(root.contains("transform"));
}

// --- the photos of a tile's faces

// A camera 50 m above flat ground shows it with pixels of 50 m / 500.
TEST(TileFiles, PagesOfAnEarlierResultAreGone) {
  const test::TemporaryFolder folder;
  for (const char* name : {"model_0.jpg", "model_1.jpg", "model_2.jpg"}) std::ofstream(folder.path() / name) << "page";
  const pipeline::OutputSettings settings;
  PageFiles pages(folder.path(), "", settings, {}, false);
  atlas::AtlasEstimate size;
  size.pages = 1;
  pages.begin(size);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "model_0.jpg")) << "replaced when the page is written";
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "model_1.jpg"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "model_2.jpg"));
}

TEST(TilePhotos, HaveTheGroundSamplingDistanceOfTheirFaces) {
  const Mesh ground = test::grid_mesh(8, 8, 1);
  Scene scene;
  for (const double height : {50.0, 100.0}) {
    View& view = scene.views.emplace_back();
    view.name = "DJI_" + std::to_string(scene.views.size()) + ".JPG";
    view.camera = {1000, 800, 500, 500, 500, 400, {}};
    view.pose = {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {4, 4, height}};
    view.reduction = 2;
  }
  TileModel tile;
  tile.mesh = ground;
  std::vector<std::uint32_t> faces(ground.faces.size());
  std::iota(faces.begin(), faces.end(), 0u);
  std::vector<ViewId> labels(faces.size(), ViewId{1});
  for (std::size_t f = 0; f < 40; ++f) labels[f] = f < 10 ? kNoView : ViewId{0};
  add_photos(tile, scene, faces, labels);
  const auto row = [&](std::size_t face) { return tile.photos.of_face[face]; };
  EXPECT_EQ(tile.photos.name.size(), 3u);
  EXPECT_EQ(tile.photos.name[row(0)], "");
  EXPECT_EQ(tile.photos.name[row(10)], "DJI_1.JPG");
  EXPECT_EQ(tile.photos.name[row(40)], "DJI_2.JPG");
  EXPECT_EQ(tile.photos.gsd[row(0)], 0);
  EXPECT_NEAR(tile.photos.gsd[row(10)], 0.05, 1e-6)
      << "of the photo as taken, two of whose pixels are one of the camera's";
  EXPECT_NEAR(tile.photos.gsd[row(40)], 0.1, 1e-6);
}

// --- metadata.xml

TEST(Metadata, StatesWhereAnObjLies) {
  const test::TemporaryFolder folder;
  const auto written = [&](const std::string& srs) {
    io::ModelOptions options;
    options.srs = srs;
    options.offset = {400, 300, 20};
    options.srs_offset = {690000, 5330000.5, 500};
    pipeline::write_metadata(options, folder.path() / "metadata.xml");
    return io::read_mesh_origin(folder.path() / "model.obj").value();
  };
  EXPECT_EQ(written("EPSG:25832").srs, "EPSG:25832");
  EXPECT_EQ(written("EPSG:25832").origin, (WorldPoint{690400, 5330300.5, 520}));
  EXPECT_EQ(written("ENU:48.5,11.25").srs, "ENU:48.5,11.25");
  EXPECT_EQ(written("+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs").srs, "EPSG:32632")
      << "as OpenDroneMap writes it";
  EXPECT_EQ(written("LOCAL_CS[\"<a & b>\"]").srs, "LOCAL_CS[\"<a & b>\"]");
}

}  // namespace
}  // namespace gpvc::tileset
