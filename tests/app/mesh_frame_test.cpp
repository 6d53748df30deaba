// Meshes in other coordinates than the cameras.
#include "app/checks/mesh_frame.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/checks/frame_check.h"
#include "io/reference_system.h"
#include "io/vector.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/without_grids.h"

namespace gpvc {
namespace {

using test::contains;

// A meadow of 40 m near Brighton in UTM, and a camera in geocentric coordinates 50 m above its middle.
class MeshFrame : public testing::Test {
 protected:
  static constexpr WorldPoint kMiddle{701400, 5633700, 120};

  MeshFrame() {
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x)
        utm_.positions.push_back({kMiddle.x + 10 * x - 20, kMiddle.y + 10 * y - 20, kMiddle.z});
    for (std::uint32_t y = 0; y < 4; ++y)
      for (std::uint32_t x = 0; x < 4; ++x) {
        const std::uint32_t a = 5 * y + x;
        utm_.faces.push_back({a, a + 1, a + 6});
        utm_.faces.push_back({a, a + 6, a + 5});
      }
    geocentric_ = utm_;
    io::transform_points("EPSG:32630", io::kGeocentric, geocentric_.positions);
    std::vector<WorldPoint> axes{kMiddle,
                                 {kMiddle.x + 1, kMiddle.y, kMiddle.z},
                                 {kMiddle.x, kMiddle.y, kMiddle.z + 1},
                                 {kMiddle.x, kMiddle.y, kMiddle.z + 50}};
    io::transform_points("EPSG:32630", io::kGeocentric, axes);
    const auto towards = [&](std::size_t i) {
      const WorldPoint d{axes[i].x - axes[0].x, axes[i].y - axes[0].y, axes[i].z - axes[0].z};
      const double length = std::hypot(d.x, d.y, d.z);
      return WorldPoint{d.x / length, d.y / length, d.z / length};
    };
    const WorldPoint east = towards(1), up = towards(2);
    const WorldPoint north{up.y * east.z - up.z * east.y, up.z * east.x - up.x * east.z, up.x * east.y - up.y * east.x};
    View view;
    view.name = "a.jpg";
    view.camera = {400, 400, 400, 400, 200, 200, {}};
    view.pose = {{east.x, east.y, east.z, -north.x, -north.y, -north.z, -up.x, -up.y, -up.z}, axes[3]};
    scene_.views.push_back(view);
    scene_.srs = io::kGeocentric;
    // The chunk: turned by a quarter about x, 5 m a unit, its origin beside the meadow.
    frame_ = {"the chunk's own coordinates", {1, 0, 0, 0, 0, 1, 0, -1, 0}, axes[1], 0.2};
    SceneFrame metres = frame_;
    metres.name += " in metres";
    metres.scale = 1;
    scene_.other_frames = {frame_, metres};
    before_ = scene_;
  }
  Mesh in_chunk(double scale) const {
    Mesh mesh = geocentric_;
    for (WorldPoint& p : mesh.positions) {
      const WorldPoint d{p.x - frame_.origin.x, p.y - frame_.origin.y, p.z - frame_.origin.z};
      p = {scale * d.x, scale * d.z, scale * -d.y};
    }
    return mesh;
  }
  std::string match(Mesh& mesh, const std::string& crs = {}) {
    return checks::match_frames(scene_, mesh, kUsed, "m.ply", crs).text;
  }
  // The pixel of a vertex must be what it is in geocentric coordinates.
  void expect_seen_rightly(const Mesh& mesh, double error_px = 1e-4) const {
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const View &now = scene_.views[0], &then = before_.views[0];
      const PixelPoint a = pixel_from_camera(now.camera, camera_from_world(now.pose, mesh.positions[v]));
      const PixelPoint b = pixel_from_camera(then.camera, camera_from_world(then.pose, geocentric_.positions[v]));
      EXPECT_NEAR(a.x, b.x, error_px);
      EXPECT_NEAR(a.y, b.y, error_px);
    }
  }

  const std::vector<ViewId> kUsed{ViewId{0}};
  Mesh utm_, geocentric_;
  Scene scene_, before_;
  SceneFrame frame_;
};

TEST_F(MeshFrame, WhatFitsIsLeftAlone) {
  Mesh mesh = geocentric_;
  EXPECT_EQ(match(mesh), "");
  EXPECT_EQ(mesh.positions, geocentric_.positions);
  EXPECT_TRUE(mesh.file_positions.empty());
  EXPECT_EQ(scene_.srs, io::kGeocentric);
}

TEST_F(MeshFrame, UtmIsFoundAndKeptForTheFiles) {
  Mesh mesh = utm_;
  EXPECT_TRUE(contains(match(mesh), "EPSG:32630"));
  expect_seen_rightly(mesh);
  EXPECT_EQ(mesh.written_positions(), utm_.positions);
  EXPECT_EQ(mesh.file_srs, "EPSG:32630");
}

TEST_F(MeshFrame, LocalCoordinatesAreTakenToTheOriginThatMetadataStates) {
  const test::TemporaryFolder folder;
  const auto tile = folder.write("Data/Tile_0/Tile_0.obj", "");
  Mesh local = utm_;
  for (WorldPoint& p : local.positions) p = {p.x - 700000, p.y - 5600000, p.z - 50};
  const Mesh before = local;
  const auto match_tile = [&] { return checks::match_frames(scene_, local, kUsed, tile).text; };
  scene_.other_frames.clear();
  EXPECT_EQ(match_tile(), "");
  const std::string xml =
      "<ModelMetadata><SRS>EPSG:32630</SRS><SRSOrigin>700000,5600000,50</SRSOrigin></ModelMetadata>";
  folder.write("metadata.xml", test::replaced(xml, "700000,", "7e5,5e6,"));
  EXPECT_EQ(match_tile(), "") << "an origin elsewhere";
  folder.write("metadata.xml", xml);
  EXPECT_TRUE(contains(match_tile(), "metadata.xml states"));
  expect_seen_rightly(local);
  EXPECT_EQ(local.written_positions(), before.positions);
}

// The training saw the meadow's own axes, about its middle, at a hundredth of its size.
TEST_F(MeshFrame, TheCoordinatesOfATrainingAreFound) {
  const test::TemporaryFolder folder;
  const WorldPoint& o = frame_.origin;
  folder.write(
      "dataparser_transforms.json",
      fmt::format(R"({{"transform": [[-1, 0, 0, {:.17g}], [0, 0, 1, {:.17g}], [0, 1, 0, {:.17g}]], "scale": 0.01}})",
                  o.x, -o.z, -o.y));
  Mesh mesh = geocentric_;
  for (WorldPoint& p : mesh.positions) p = {0.01 * (o.x - p.x), 0.01 * (p.z - o.z), 0.01 * (p.y - o.y)};
  scene_.other_frames.clear();
  const std::string text = checks::match_frames(scene_, mesh, kUsed, folder.path() / "mesh.ply").text;
  EXPECT_TRUE(contains(text, "dataparser_transforms.json states: they are taken there")) << text;
  expect_seen_rightly(mesh);
}

TEST_F(MeshFrame, GltfIsTurnedWhereItFitsWithZUp) {
  scene_ = {};
  View view;
  view.name = "a.jpg";
  view.camera = {400, 400, 400, 400, 200, 200, {}};
  view.pose = {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 50}};
  scene_.views.push_back(view);
  Mesh ground = utm_;
  for (WorldPoint& p : ground.positions) p = p - kMiddle;
  Mesh mesh = ground;
  for (WorldPoint& p : mesh.positions) p = {p.x, p.z, -p.y};
  const Mesh upright = mesh;
  EXPECT_EQ(checks::match_frames(scene_, mesh, kUsed, "m.ply").text, "") << "the axes of other formats are as they are";
  EXPECT_EQ(mesh.positions, upright.positions);
  EXPECT_TRUE(contains(checks::match_frames(scene_, mesh, kUsed, "m.glb").text, "it is turned"));
  EXPECT_EQ(mesh.positions, ground.positions);
  EXPECT_EQ(checks::match_frames(scene_, mesh, kUsed, "m.glb").text, "") << "it has z up now";
  EXPECT_EQ(mesh.positions, ground.positions);
}

TEST_F(MeshFrame, ASceneWithoutASystemNamesTheFrameAlone) {
  scene_.srs.clear();
  Mesh mesh = in_chunk(1);
  EXPECT_TRUE(contains(match(mesh), "cameras in their own coordinates, but in the chunk's own coordinates in metres"));
  expect_seen_rightly(mesh);
}

// A camera 50 m above the origin frames 50 m each way. In its own coordinates the mesh begins 10 m beside the middle.
TEST_F(MeshFrame, AFrameThatFitsClearlyBetterIsTaken) {
  scene_.srs.clear();
  scene_.views[0].pose = {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, 50}};
  SceneFrame moved;
  moved.name = "those of the mesh";
  moved.origin = {-30, 0, 0};
  scene_.other_frames = {moved};
  Mesh mesh = utm_;
  for (WorldPoint& p : mesh.positions) p = {p.x - kMiddle.x + 30, p.y - kMiddle.y, 0};
  EXPECT_EQ(
      match(mesh),
      "the mesh fits the cameras better in those of the mesh than in their own coordinates: they are taken there");
  EXPECT_EQ(scene_.views[0].pose.centre, (WorldPoint{30, 0, 50}));
  // Now as well as it can; taken back, it would fit less.
  scene_.other_frames = {moved};
  scene_.other_frames[0].origin = {30, 0, 0};
  EXPECT_EQ(match(mesh), "");
}

TEST_F(MeshFrame, TheScenesReferenceIsTriedFirst) {
  scene_.reference = "EPSG:4326";
  Mesh mesh = utm_;
  io::transform_points("EPSG:32630", "EPSG:4326", mesh.positions);
  EXPECT_TRUE(contains(match(mesh), "EPSG:4326"));
  expect_seen_rightly(mesh);
}

TEST_F(MeshFrame, CamerasGoToTheChunksCoordinates) {
  Mesh own = in_chunk(0.2);
  EXPECT_TRUE(contains(match(own), "in the chunk's own coordinates:"));
  expect_seen_rightly(own);
  EXPECT_EQ(scene_.srs, "");
  EXPECT_TRUE(own.file_positions.empty());
}

TEST_F(MeshFrame, TheFrameThatShowsMostIsTaken) {
  Mesh metres = in_chunk(1);
  EXPECT_TRUE(contains(match(metres), "in metres"));
  expect_seen_rightly(metres);
}

// A corner of the meadow lies where the camera looks, so that it would be textured. It is better not taken to be there.
TEST_F(MeshFrame, AMeshMovedByAnUnnamedOffsetFitsNoFrame) {
  Mesh mesh = in_chunk(1);
  for (WorldPoint& p : mesh.positions) p.x += 20;
  const std::vector<WorldPoint> positions = mesh.positions;
  EXPECT_EQ(match(mesh), "");
  EXPECT_EQ(mesh.positions, positions);
  EXPECT_EQ(scene_.views[0].pose.centre, before_.views[0].pose.centre);
  Mesh less = in_chunk(1);
  for (WorldPoint& p : less.positions) p.x += 4;
  EXPECT_TRUE(contains(match(less), "in metres"));
}

// Steps of a camera that moved while it was read out count in the scene's units.
TEST_F(MeshFrame, MovingCamerasAreScaledToo) {
  scene_.views[0].camera.distortion.motion = {.down = 1, .step = {5, 0, -10}};
  Mesh own = in_chunk(0.2);
  match(own);
  EXPECT_EQ(scene_.views[0].camera.distortion.motion.step, (std::array<double, 3>{1, 0, -2}));
}

// Too small a mesh is framed whole, but fills little of the photos. This chunk has 0.25 m a unit.
TEST_F(MeshFrame, AMeshInMetresIsNotTakenForASmallerOne) {
  frame_.scale = 4;
  scene_.other_frames[0].scale = 4;
  Mesh metres = in_chunk(1);
  EXPECT_TRUE(contains(match(metres), "in metres"));
  expect_seen_rightly(metres);
}

TEST_F(MeshFrame, LocalCoordinatesAreNotTakenForDegrees) {
  scene_.reference = "EPSG:4326";
  scene_.other_frames.clear();
  Mesh mesh = utm_;
  for (WorldPoint& p : mesh.positions) p = {p.x - kMiddle.x, p.y - kMiddle.y - 65, 0};
  // As degrees, they lie on the other side of the earth, where the camera looks.
  EXPECT_EQ(match(mesh), "");
  EXPECT_TRUE(mesh.file_positions.empty());
}

TEST_F(MeshFrame, ANamedSystemIsTaken) {
  Mesh mesh = utm_;
  io::transform_points("EPSG:32630", "EPSG:3857", mesh.positions);
  Mesh unnamed = mesh;
  EXPECT_EQ(match(unnamed), "");
  EXPECT_EQ(unnamed.positions, mesh.positions);
  EXPECT_EQ(checks::ways_out(scene_).cures, std::vector{Cure::name_mesh_crs});
  scene_.format = "transforms.json";
  EXPECT_TRUE(contains(checks::ways_out(scene_).text, "dataparser_transforms.json"));
  for (const char* format : {"RealityCapture", "RealityCapture CSV"}) {
    scene_.format = format;
    EXPECT_TRUE(contains(checks::ways_out(scene_).text, "'Same as XMP'"));
  }
  EXPECT_EQ(match(mesh, "EPSG:3857"), "");
  expect_seen_rightly(mesh);
}

// The National Grid's ellipsoid lies 46 m above that of WGS 84 there; the camera is 50 m above the meadow.
TEST_F(MeshFrame, HeightsMayBeAboveEitherEllipsoid) {
  constexpr double kDatumPx =
      0.02;  // 2.5 mm: a datum's shift is undone approximately, and depends a little on the height
  for (const char* crs : {"EPSG:27700", "EPSG:32630"}) {
    Mesh mesh = geocentric_;
    io::transform_points(io::kGeocentric, crs, mesh.positions);
    Mesh other = mesh;
    for (std::size_t i = 0; i < other.positions.size(); ++i) other.positions[i].z = kMiddle.z;
    const std::string said = match(mesh, crs);
    EXPECT_TRUE(said.empty() || contains(said, "PROJ lacks the grid uk_os_OSTN15")) << said;
    expect_seen_rightly(mesh, kDatumPx);
    const std::string assumed = match(other, crs);
    EXPECT_EQ(contains(assumed, "with heights above the ellipsoid of EPSG:4978 instead of its own"),
              std::string_view(crs) == "EPSG:27700")
        << assumed;
    expect_seen_rightly(other, kDatumPx);
  }
}

// Left as they are, they would be 45 m off.
TEST_F(MeshFrame, HeightsThatNeedAMissingGridAreRefused) {
  const std::string crs = "EPSG:32630+3855";  // above the geoid of 2008
  const test::WithoutGrids without;
  Mesh mesh = utm_;
  const std::string error = test::input_error([&] { match(mesh, crs); });
  EXPECT_TRUE(contains(error, "m.ply: cannot be brought to the scene's EPSG:4978: PROJ lacks the grid ")) << error;
  EXPECT_TRUE(contains(error, "Debian's package proj-data")) << error;
  scene_.other_frames.clear();
  scene_.reference = crs;
  const std::string found = test::input_error([&] { match(mesh); });
  EXPECT_TRUE(contains(found, "m.ply: PROJ lacks the grid ")) << found;
}

TEST_F(MeshFrame, WhatCannotBeUsedIsRefused) {
  Mesh mesh = utm_;
  EXPECT_TRUE(contains(test::input_error([&] { match(mesh, "EPSG:99999"); }), "m.ply: cannot be brought"));
  scene_.srs.clear();
  EXPECT_TRUE(contains(test::input_error([&] { match(mesh, "EPSG:3857"); }), "names no reference system"));
}

}  // namespace
}  // namespace gpvc
