#include <algorithm>

#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// A frame sensor with every term, a fisheye, and one of the old kind; a chunk turned by a quarter about z, scaled by 2
// and moved. Written from the user manual.
const std::string kCameras = R"xml(<?xml version="1.0" encoding="UTF-8"?>
<document version="2.0.0">
  <chunk label="Chunk 1" enabled="true">
    <sensors next_id="3">
      <sensor id="0" label="unknown" type="frame">
        <resolution width="400" height="300"/>
        <calibration type="frame" class="initial">
          <resolution width="400" height="300"/><f>111</f>
        </calibration>
        <calibration type="frame" class="adjusted">
          <resolution width="400" height="300"/>
          <f>350</f><cx>3.5</cx><cy>-2.25</cy><b1>1.5</b1><b2>0.7</b2>
          <k1>-0.1</k1><k2>0.02</k2><k3>0.003</k3><k4>-0.001</k4>
          <p1>0.004</p1><p2>-0.002</p2><p3>0.1</p3><p4>0.2</p4>
        </calibration>
        <covariance><params>f cx</params><coeffs>1 2 3</coeffs></covariance>
      </sensor>
      <sensor id="1" label="round" type="fisheye">
        <resolution width="400" height="400"/>
        <calibration type="fisheye" class="adjusted">
          <resolution width="400" height="400"/>
          <f>120</f><k1>0.01</k1><p1>0.003</p1>
        </calibration>
      </sensor>
      <sensor id="2" label="old" type="frame">
        <resolution width="300" height="200"/>
        <calibration type="frame">
          <fx>250</fx><fy>251</fy><cx>151</cx><cy>99</cy><skew>0.5</skew><p1>0.004</p1><p2>-0.002</p2>
        </calibration>
      </sensor>
      <sensor id="9" label="panorama" type="spherical">
        <resolution width="8" height="4"/>
        <calibration type="spherical" class="adjusted"><resolution width="8" height="4"/><f>1</f></calibration>
      </sensor>
    </sensors>
    <cameras next_id="9">
      <camera id="0" sensor_id="0" label="DJI_0001">
        <transform>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</transform>
      </camera>
      <group id="0" label="more">
        <camera id="1" sensor_id="1" label="fish eye.png">
          <transform>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</transform>
        </camera>
        <group id="1" label="deeper">
          <camera id="2" sensor_id="2" label="older.jpg" enabled="1">
            <transform>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</transform>
          </camera>
        </group>
      </group>
      <camera id="3" sensor_id="0" label="off" enabled="false">
        <transform>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</transform>
      </camera>
      <camera id="4" sensor_id="0" label="unaligned"/>
    </cameras>
    <transform>
      <rotation locked="true">0 -1 0 1 0 0 0 0 1</rotation>
      <translation locked="true">1000 2000 50</translation>
      <scale locked="true">2</scale>
    </transform>
    <reference>LOCAL_CS["Local Coordinates (m)",LOCAL_DATUM["Local Datum",0],UNIT["metre",1]]</reference>
    <region><center>0 0 0</center><size>1 1 1</size><R>1 0 0 0 1 0 0 0 1</R></region>
  </chunk>
</document>
)xml";

// A rig of a master, turned by a quarter about its x, and of two slaves, one before it in the file.
const std::string kRig = R"xml(<?xml version="1.0" encoding="UTF-8"?>
<document version="2.1.0">
  <chunk label="Rig" enabled="true">
    <sensors next_id="3">
      <sensor id="0" label="down" type="frame">
        <resolution width="100" height="80"/>
        <bands><band label="Red"/><band label="Green"/><band label="Blue"/></bands>
        <calibration type="frame" class="adjusted"><resolution width="100" height="80"/><f>100</f></calibration>
        <rotation fixed="true"/>
        <location fixed="true"/>
      </sensor>
      <sensor id="1" label="left" type="frame" master_id="0">
        <resolution width="100" height="80"/>
        <bands><band label="Red"/><band label="Green"/><band label="Blue"/></bands>
        <calibration type="frame" class="adjusted"><resolution width="100" height="80"/><f>200</f></calibration>
        <rotation>0.8 0 0.6 0 1 0 -0.6 0 0.8</rotation>
        <location>0.5 -0.25 1</location>
      </sensor>
    </sensors>
    <components next_id="1">
      <component id="0"><transform>
        <rotation locked="true">0 -1 0 1 0 0 0 0 1</rotation>
        <translation locked="true">1000 2000 50</translation>
        <scale locked="true">2</scale>
      </transform></component>
    </components>
    <cameras next_id="4" next_group_id="2">
      <camera id="1" sensor_id="1" master_id="0" label="L1"><orientation>1</orientation></camera>
      <group id="0" label="100MEDIA" type="folder">
        <camera id="0" sensor_id="0" component_id="0" label="D1">
          <transform>1 0 0 1 0 0 -1 2 0 1 0 3 0 0 0 1</transform>
        </camera>
      </group>
      <group id="1" label="101MEDIA" type="folder">
        <camera id="2" sensor_id="0" component_id="0" label="D2">
          <transform>1 0 0 9 0 1 0 8 0 0 1 7 0 0 0 1</transform>
        </camera>
        <camera id="3" sensor_id="1" component_id="0" master_id="2" label="L2"/>
      </group>
    </cameras>
  </chunk>
</document>
)xml";

SceneFile parse(const std::string& text) { return test::parse_as("Metashape", text); }

/// The camera's (x, y, 1) * depth in the world: from the camera at (1, 2, 3) of the chunk, through its transform.
WorldPoint world_of(double x, double y, double depth) {
  const double cx = 1 + x * depth, cy = 2 + y * depth, cz = 3 + depth;
  return {1000 - 2 * cy, 2000 + 2 * cx, 50 + 2 * cz};
}

// Of a sensor that is fixed to what its photos' EXIF data say.
const std::string kFixed = R"xml(<property name="pixel_width" value="0.0025"/>
        <property name="pixel_height" value="0.002"/><property name="focal_length" value="0.5"/>
        <property name="fixed" value="true"/>)xml";
const std::string kOldCalibration =
    kCameras.substr(kCameras.find("<calibration type=\"frame\">"),
                    kCameras.find("<sensor id=\"9\"") - kCameras.find("<calibration type=\"frame\">"));

TEST(Metashape, TakesFixedSensorsFromTheSizeOfTheirPixels) {
  const SceneFile scene = parse(replaced(kCameras, kOldCalibration, kFixed + "</sensor>"));
  const Camera& camera = view_named(scene, "older.jpg").camera;
  EXPECT_NEAR(camera.fx, 200, 1e-9);
  EXPECT_NEAR(camera.fy, 250, 1e-9);
  EXPECT_EQ(camera.cx, 150);
  EXPECT_EQ(camera.cy, 100);
  EXPECT_EQ(camera.distortion.k1, 0);
  EXPECT_EQ(std::ranges::count(scene.warnings,
                               "the sensor 'old' has no calibration: its focal length of 0.5 mm is taken, "
                               "and no distortion"),
            1);
  for (const auto& [from, to] : {std::pair("pixel_height", "height"), std::pair("\"0.002\"", "\"0\"")})
    EXPECT_TRUE(contains(input_error([&, &a = from, &b = to] {
                           parse(replaced(kCameras, kOldCalibration, replaced(kFixed, a, b) + "</sensor>"));
                         }),
                         "no calibration, and no positive 'pixel_height'"));
}

TEST(Metashape, LeavesOutCamerasWhoseLabelNamesNoPhoto) {
  for (const char* label : {"", " label=\"\"", " label=\"..\"", " label=\"photos/\""}) {
    const SceneFile scene = parse(replaced(kCameras, " label=\"DJI_0001\"", label));
    EXPECT_EQ(scene.views.size(), 2u) << label;
    EXPECT_TRUE(std::ranges::any_of(scene.warnings, [](const std::string& warning) {
      return contains(warning, "1 cameras are left out, as their label names no photo: ") && contains(warning, "line ");
    })) << label;
  }
  const std::string one = replaced(kRig, " label=\"D2\"", "");
  EXPECT_NO_THROW(parse(one));
  std::string none = kRig;
  for (const char* label : {"L1", "D1", "D2", "L2"}) none = replaced(none, std::string(" label=\"") + label + "\"", "");
  EXPECT_TRUE(contains(input_error([&] { parse(none); }), "expected the name of a photo"));
}

TEST(Metashape, ProjectsAKnownPointThroughChunkAndLens) {
  const double x = 0.3, y = -0.2, r2 = 0.13;
  const double radial = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2 - 0.001 * r2 * r2 * r2 * r2;
  const double more = 1 + 0.1 * r2 + 0.2 * r2 * r2;
  const double u = x * radial + (0.004 * (r2 + 2 * x * x) + 2 * -0.002 * x * y) * more;
  const double v = y * radial + (-0.002 * (r2 + 2 * y * y) + 2 * 0.004 * x * y) * more;
  expect_photo_point(view_named(parse(kCameras), "DJI_0001"), world_of(x, y, 7),
                     200 + 3.5 + u * 350 + u * 1.5 + v * 0.7, 150 - 2.25 + v * 350);
}

TEST(Metashape, BendsAFisheye) {
  const double x0 = 0.9, y0 = 1.2, angle = std::atan(1.5), x = x0 * angle / 1.5, y = y0 * angle / 1.5;
  const double r2 = x * x + y * y, radial = 1 + 0.01 * r2;
  const double u = x * radial + 0.003 * (r2 + 2 * x * x), v = y * radial + 2 * 0.003 * x * y;
  expect_photo_point(view_named(parse(kCameras), "fish eye.png"), world_of(x0, y0, 4), 200 + 120 * u, 200 + 120 * v);
}

// 36.87 degrees off the axis: 2 sin(18.43) is 2 / sqrt(10).
TEST(Metashape, BendsAnEquisolidFisheye) {
  const double x0 = 0.45, y0 = 0.6, r = 2 / std::sqrt(10), x = x0 * r / 0.75, y = y0 * r / 0.75;
  const double r2 = x * x + y * y, radial = 1 + 0.01 * r2;
  const double u = x * radial + 0.003 * (r2 + 2 * x * x), v = y * radial + 2 * 0.003 * x * y;
  const SceneFile scene =
      parse(replaced(kCameras, "<calibration type=\"fisheye\"", "<calibration type=\"equisolid_fisheye\""));
  expect_photo_point(view_named(scene, "fish eye.png"), world_of(x0, y0, 4), 200 + 120 * u, 200 + 120 * v);
}

TEST(Metashape, ReadsCalibrationsOfOldFiles) {
  const double x = 0.3, y = -0.2, r2 = 0.13;
  const double u = x + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * x * x);
  const double v = y + 0.004 * (r2 + 2 * y * y) + 2 * -0.002 * x * y;
  expect_photo_point(view_named(parse(kCameras), "older.jpg"), world_of(x, y, 7), 151 + 250 * u + 0.5 * v,
                     99 + 251 * v);
}

TEST(Metashape, LeavesOutWhatIsDisabledOrUnaligned) {
  const SceneFile scene = parse(kCameras);
  EXPECT_EQ(scene.views.size(), 3);
  ASSERT_EQ(scene.warnings.size(), 2);
  EXPECT_TRUE(contains(scene.warnings[0], "1 cameras without a transform"));
  EXPECT_TRUE(contains(scene.warnings[1], "1 disabled cameras"));
  EXPECT_EQ(scene.srs, "");
}

TEST(Metashape, SaysThatGeoreferencedChunksAreGeocentric) {
  const SceneFile scene = parse(replaced(kCameras, "LOCAL_CS[", "PROJCS["));
  EXPECT_EQ(scene.srs, "EPSG:4978");
  // Meshes may be in the chunk's own coordinates: the camera's transform without the chunk's.
  ASSERT_EQ(scene.other_frames.size(), 2u);
  const SceneFrame& own = scene.other_frames[0];
  const WorldPoint c = view_named(scene, "DJI_0001").pose.centre;
  const std::array<double, 3> d{c.x - own.origin.x, c.y - own.origin.y, c.z - own.origin.z};
  for (std::size_t row = 0; row < 3; ++row) {
    double x = 0;
    for (std::size_t k = 0; k < 3; ++k) x += own.scale * own.rotation[3 * row + k] * d[k];
    EXPECT_NEAR(x, static_cast<double>(row + 1), 1e-9);
  }
  EXPECT_EQ(scene.other_frames[1].scale, 1);
  EXPECT_FALSE(scene.reference.empty());
}

TEST(Metashape, PlacesComponents) {
  std::string text = replaced(kCameras, "    <cameras next_id",
                              "    <components><component id=\"5\"><transform><translation>7 8 9</translation>"
                              "</transform></component></components>\n    <cameras next_id");
  text = replaced(text, "<camera id=\"0\"", "<camera component_id=\"5\" id=\"0\"");
  text = replaced(text, "<camera id=\"1\"", "<camera component_id=\"5\" id=\"1\"");
  const SceneFile scene = parse(text);
  EXPECT_EQ(scene.views.size(), 2);
  EXPECT_EQ(view_named(scene, "DJI_0001").pose.centre, (WorldPoint{8, 10, 12}));
  EXPECT_TRUE(contains(scene.warnings.back(), "1 cameras of other components"));
}

// By hand: (1, -0.5, 5) of the slave, whose photo shows it at (50 + 200 / 5, 40 - 100 / 5), is turned by the rotation
// to (3.8, -0.5, 3.4) and moved to (4.3, -0.75, 4.4) of the master; that takes (x, y, z) to (1 + x, 2 - z, 3 + y) of
// the chunk: (5.3, -2.4, 2.25); and its component to 2 (2.4, 5.3, 2.25) + (1000, 2000, 50). The other master's axes are
// the chunk's: (13.3, 7.25, 11.4), 2 (-7.25, 13.3, 11.4) + ...
const WorldPoint kOfFirstSlave{1004.8, 2010.6, 54.5}, kOfSecondSlave{985.5, 2026.6, 72.8};

TEST(Metashape, PlacesSlavesOfARig) {
  const SceneFile scene = parse(kRig);
  EXPECT_EQ(scene.views.size(), 4);
  expect_photo_point(view_named(scene, "L1"), kOfFirstSlave, 90, 20);
  expect_photo_point(view_named(scene, "L2"), kOfSecondSlave, 90, 20);
  expect_photo_point(view_named(scene, "D1"), kOfFirstSlave, 50 + 430 / 4.4, 40 - 75 / 4.4);
  ASSERT_EQ(scene.warnings.size(), 1);
  EXPECT_TRUE(contains(scene.warnings[0], "2 cameras are placed by their master"));
}

// The master's own place in the rig, a quarter about z and then (1, 2, 0), is undone: (4.3, -0.75, 4.4) of the rig is
// (-2.75, -3.3, 4.4) of the master, so (-1.75, -2.4, -0.3) of the chunk.
TEST(Metashape, PlacesSlavesOfAMasterThatHasAPlaceInTheRigItself) {
  const SceneFile scene = parse(replaced(kRig, "<rotation fixed=\"true\"/>\n        <location fixed=\"true\"/>",
                                         "<rotation>0 -1 0 1 0 0 0 0 1</rotation><location>1 2 0</location>"));
  expect_photo_point(view_named(scene, "L1"), {1004.8, 1996.5, 49.4}, 90, 20);
}

TEST(Metashape, PlacesSlavesThatStateNothingWhereTheirMasterIs) {
  std::string text = replaced(kRig, "<rotation>0.8 0 0.6 0 1 0 -0.6 0 0.8</rotation>", "");
  text = replaced(text, "<location>0.5 -0.25 1</location>", "");
  const SceneFile scene = parse(text);
  EXPECT_EQ(view_named(scene, "L1").pose.rotation, view_named(scene, "D1").pose.rotation);
  EXPECT_EQ(view_named(scene, "L1").pose.centre, view_named(scene, "D1").pose.centre);
}

TEST(Metashape, PlacesSlavesOfADisabledMaster) {
  const SceneFile scene = parse(replaced(kRig, "label=\"D1\"", "label=\"D1\" enabled=\"false\""));
  EXPECT_EQ(scene.views.size(), 3);
  expect_photo_point(view_named(scene, "L1"), kOfFirstSlave, 90, 20);
}

TEST(Metashape, LeavesOutSlavesWhoseMasterIsNotPlaced) {
  const SceneFile unplaced =
      parse(replaced(kRig, "<transform>1 0 0 1 0 0 -1 2 0 1 0 3 0 0 0 1</transform>", "<transform/>"));
  EXPECT_EQ(unplaced.views.size(), 2);
  EXPECT_TRUE(contains(unplaced.warnings[0], "2 cameras without a transform"));
  for (const char* master : {"77", "1", ""}) {  // unknown, itself, none
    const SceneFile scene =
        parse(replaced(kRig, "master_id=\"0\" label=\"L1\"", std::string("master_id=\"") + master + "\" label=\"L1\""));
    EXPECT_EQ(scene.views.size(), 3);
    EXPECT_TRUE(contains(scene.warnings[0], "1 cameras without a transform"));
  }
}

TEST(Metashape, PrefersTheTransformOfASlave) {
  const SceneFile scene =
      parse(replaced(kRig, "label=\"L1\"><orientation>1</orientation>",
                     "component_id=\"0\" label=\"L1\"><transform>1 0 0 9 0 1 0 8 0 0 1 7 0 0 0 1</transform>"));
  EXPECT_EQ(view_named(scene, "L1").pose.rotation, view_named(scene, "D2").pose.rotation);
  EXPECT_EQ(view_named(scene, "L1").pose.centre, view_named(scene, "D2").pose.centre);
  EXPECT_TRUE(contains(scene.warnings[0], "1 cameras are placed by their master"));
}

TEST(Metashape, SaysThatBandsWouldBeMixed) {
  const SceneFile scene =
      parse(replaced(kRig, "<bands><band label=\"Red\"/><band label=\"Green\"/><band label=\"Blue\"/></bands>",
                     "<bands><band label=\"NIR\"/></bands>"));
  EXPECT_EQ(scene.views.size(), 4);
  EXPECT_TRUE(contains(scene.warnings.back(), "different bands, 'NIR', 'Red Green Blue',"));
}

// Of four D1, two lie in 101MEDIA and one in none; L2 is unique, and named as before.
TEST(Metashape, TellsRepeatedLabelsApartByTheirGroup) {
  std::string text = replaced(kRig, "label=\"D2\"", "label=\"D1\"");
  text = replaced(text, "<camera id=\"3\"",
                  "<camera id=\"4\" sensor_id=\"0\" component_id=\"0\" label=\"D1\">"
                  "<transform>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</transform></camera><camera id=\"3\"");
  text = replaced(text, "label=\"L1\"", "label=\"D1\"");
  const SceneFile scene = parse(text);
  ASSERT_EQ(scene.views.size(), 4);
  expect_photo_point(view_named(scene, "D1"), kOfFirstSlave, 90, 20);
  expect_photo_point(view_named(scene, "100MEDIA/D1"), kOfFirstSlave, 50 + 430 / 4.4, 40 - 75 / 4.4);
  EXPECT_EQ(view_named(scene, "101MEDIA/D1").pose.centre, (WorldPoint{1000 - 16, 2000 + 18, 50 + 14}));
  expect_photo_point(view_named(scene, "L2"), kOfSecondSlave, 90, 20);
  EXPECT_EQ(scene.warnings[0], "1 cameras are left out: others have their label and group, as '101MEDIA/D1'");
}

// A label that is unique is never taken by one that a group makes; of the group only folders' names count.
TEST(Metashape, KeepsNamesPlainAndUniqueOnesAsTheyAre) {
  std::string text = replaced(kRig, "label=\"D2\"", "label=\"D1\"");
  text = replaced(text, "label=\"100MEDIA\"", "label=\"C:\\flight\\..\\.\\one/\"");
  text = replaced(text, "label=\"L1\"", "label=\"101MEDIA/D1\"");
  const SceneFile scene = parse(text);
  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_NO_THROW(view_named(scene, "flight/one/D1"));
  expect_photo_point(view_named(scene, "101MEDIA/D1"), kOfFirstSlave, 90, 20);
  EXPECT_TRUE(contains(scene.warnings[0], "1 cameras are left out: others"));
  const std::string path = "label=\"C:/photos/D1.JPG\"";
  const SceneFile twice = parse(replaced(replaced(kRig, "label=\"D1\"", path), "label=\"D2\"", path));
  EXPECT_EQ(twice.views.size(), 3);
  EXPECT_NO_THROW(view_named(twice, "C:/photos/D1.JPG"));
}

TEST(Metashape, FindsPhotosOfRepeatedLabels) {
  const test::TemporaryFolder folder;
  folder.write("cameras.xml",
               replaced(replaced(kRig, "label=\"D2\"", "label=\"D1\""), "label=\"L1\"", "enabled=\"0\" label=\"L1\""));
  for (const char* photo : {"100MEDIA/D1.JPG", "101MEDIA/D1.JPG", "101MEDIA/L2.JPG"})
    test::write_photo(folder.path() / "images/flight" / photo, 100, 80);
  const Scene scene = read_scene(folder.path(), {});
  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_EQ(scene.views[0].photo, folder.path() / "images/flight/100MEDIA/D1.JPG");
  EXPECT_EQ(scene.views[1].photo, folder.path() / "images/flight/101MEDIA/D1.JPG");
}

TEST(Metashape, LeavesOutLensesThatItDoesNotKnow) {
  std::string text = replaced(kCameras, "sensor_id=\"2\"", "sensor_id=\"9\"");
  text = replaced(replaced(text, "type=\"spherical\"", "type=\"cylindrical\""), "type=\"spherical\"",
                  "type=\"cylindrical\"");
  const SceneFile scene = parse(text);
  EXPECT_EQ(scene.views.size(), 2);
  EXPECT_EQ(scene.warnings.back(),
            "1 cameras are left out: their lens, 'cylindrical', is no perspective, fisheye or spherical one");
}

TEST(Metashape, ReadsPanoramas) {
  std::string text = replaced(kCameras, "sensor_id=\"2\"", "sensor_id=\"9\"");
  const Camera camera = view_named(parse(text), "older.jpg").camera;
  EXPECT_EQ(camera, test::panorama_of(8, 4, 4 / std::numbers::pi));
  // They are exported without a calibration, too.
  text = replaced(text,
                  "<calibration type=\"spherical\" class=\"adjusted\"><resolution width=\"8\" "
                  "height=\"4\"/><f>1</f></calibration>",
                  "");
  EXPECT_EQ(view_named(parse(text), "older.jpg").camera, camera);
}

const char* const kUnknownMotion =
    "cameras moved while their photos were read out (rolling shutter), and how is not stated in a known way: they are "
    "taken to stand still";

// A turn by 0.1 about z and a step of a unit of the chunk, which is 2 of the world, from the middle row to the last.
TEST(Metashape, ReadsTheMovementWhilePhotosAreReadOut) {
  const double c = std::cos(0.1), s = std::sin(0.1);
  const auto with = [](const std::string& shutter) {
    return parse(replaced(kCameras, "label=\"DJI_0001\">",
                          "label=\"DJI_0001\"><rolling_shutter>" + shutter + "</rolling_shutter>"));
  };
  const std::string rotation = "<rotation>" + std::to_string(c) + " " + std::to_string(-s) + " 0 " + std::to_string(s) +
                               " " + std::to_string(c) + " 0 0 0 1</rotation>";
  const std::string translation = "<translation>0 1 -0.5</translation>";
  const SceneFile scene = with(rotation + translation);
  const Motion& motion = view_named(scene, "DJI_0001").camera.distortion.motion;
  EXPECT_EQ(motion.across, 0);
  EXPECT_EQ(motion.down, 2);
  EXPECT_NEAR(motion.turn[2], 0.1, 1e-6);
  EXPECT_EQ(motion.turn[0], 0);
  EXPECT_EQ(motion.step, (std::array<double, 3>{0, 2, -1}));
  EXPECT_EQ(motion.nearness, Motion{}.nearness);
  EXPECT_FALSE(view_named(scene, "older.jpg").camera.distortion.motion.moves());
  for (const std::string& warning : scene.warnings) EXPECT_FALSE(contains(warning, "rolling shutter")) << warning;
  EXPECT_EQ(view_named(with(translation), "DJI_0001").camera.distortion.motion.turn, Motion{}.turn);
  EXPECT_EQ(view_named(with(rotation), "DJI_0001").camera.distortion.motion.step, Motion{}.step);
  EXPECT_FALSE(view_named(with("<rotation>1 0 0 0 1 0 0 0 1</rotation>"), "DJI_0001").camera.distortion.motion.moves());
  EXPECT_TRUE(contains(input_error([&] { with("<translation>0 1</translation>"); }), "expected 3 numbers"));
  EXPECT_TRUE(contains(input_error([&] { with("<rotation>2 0 0 0 1 0 0 0 1</rotation>"); }), "is no rotation"));
}

TEST(Metashape, WarnsOfRollingShuttersThatItDoesNotKnow) {
  const auto warning = [](const std::string& text) {
    const SceneFile scene = parse(text);
    return scene.warnings.empty() ? std::string() : scene.warnings.back();
  };
  const std::string sensor =
      "<resolution width=\"400\" height=\"300\"/>\n        <calibration type=\"frame\" class=\"initial\">";
  const auto with = [&](const std::string& member) { return replaced(kCameras, sensor, member + sensor); };
  EXPECT_FALSE(contains(warning(kCameras), kUnknownMotion));
  for (const char* off :
       {"<rolling_shutter>0</rolling_shutter>", "<property name=\"rolling_shutter\" value=\"disabled\"/>"})
    EXPECT_FALSE(contains(warning(with(off)), kUnknownMotion)) << off;
  for (const char* on : {"<rolling_shutter>1</rolling_shutter>", "<property name=\"rolling_shutter\" value=\"full\"/>"})
    EXPECT_EQ(warning(with(on)), std::string("1 ") + kUnknownMotion) << on;
  EXPECT_EQ(warning(replaced(kCameras, "label=\"DJI_0001\">",
                             "label=\"DJI_0001\"><rolling_shutter>1 0 0 0</rolling_shutter>")),
            std::string("1 ") + kUnknownMotion);
}

// Whose axes a slave's movement is stated in, is not known.
TEST(Metashape, TakesSlavesOfARigToStandStill) {
  const SceneFile scene = parse(replaced(
      kRig, "label=\"L1\">", "label=\"L1\"><rolling_shutter><translation>0 1 0</translation></rolling_shutter>"));
  EXPECT_FALSE(view_named(scene, "L1").camera.distortion.motion.moves());
  EXPECT_EQ(scene.warnings.back(), std::string("1 ") + kUnknownMotion);
}

TEST(Metashape, MatchesLabelsWithoutExtension) {
  const test::TemporaryFolder folder;
  folder.write("cameras.xml", kCameras);
  test::write_photo(folder.path() / "images/a/DJI_0001.JPG", 400, 300);
  test::write_photo(folder.path() / "images/fish eye.png", 800, 800);  // twice the size: scaled
  test::write_photo(folder.path() / "images/older.jpg", 300, 200);
  const Scene scene = read_scene(folder.path(), {.whole_fisheyes = true});
  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_EQ(scene.format, "Metashape");
  EXPECT_EQ(scene.views[0].photo, folder.path() / "images/a/DJI_0001.JPG");
  EXPECT_EQ(scene.views[1].camera.fx, 240);
  EXPECT_EQ(scene.views[1].camera.cx, 400);
  EXPECT_TRUE(contains(scene.warnings.back(), "the cameras of 1 photos were scaled"));
  test::write_photo(folder.path() / "images/b/DJI_0001.tif", 400, 300);
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path(), {}); }), "'DJI_0001' could be any of 2 files"));
}

TEST(Metashape, RefusesWithLineAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kCameras, from, to)); });
  };
  std::string other = replaced(kCameras, "type=\"spherical\" class", "type=\"cylindrical\" class");
  for (const char* sensor : {"0", "1", "2"})
    other = replaced(other, std::string(" sensor_id=\"") + sensor + "\" label", " sensor_id=\"9\" label");
  EXPECT_TRUE(contains(input_error([&] { parse(other); }),
                       "a camera of type 'cylindrical' is not supported; frame, fisheye and spherical are"));
  EXPECT_TRUE(contains(error("sensor_id=\"2\"", "sensor_id=\"8\""), "sensor '8' is not in the file"));
  EXPECT_TRUE(contains(error("1 0 0 1 0 1 0 2", "1 0 0 1 0 1 0"), "expected 16 numbers in transform, found 15"));
  EXPECT_TRUE(contains(error("1 0 0 1 0 1 0 2", "1 0 0 1 0 1 0 2 3"), "more than 16 numbers"));
  EXPECT_TRUE(contains(error("1 0 0 1 0 1 0 2", "1 1 0 1 0 1 0 2"), "is no rotation"));
  EXPECT_TRUE(contains(error("1 0 0 1 0 1 0 2", "1 0 0 1e999 0 1 0 2"), "line 38: expected finite numbers"));
  EXPECT_TRUE(contains(error("<f>350</f>", ""), "calibration has no f"));
  EXPECT_TRUE(contains(error("<f>350</f>", "<f>-350</f>"), "focal length is not positive"));
  EXPECT_TRUE(contains(error("<scale locked=\"true\">2", "<scale locked=\"true\">0"), "scale is not positive"));
  EXPECT_TRUE(contains(input_error([] { parse("<document><chunk/></document>"); }), "no camera has a transform"));
}

TEST(Metashape, RefusesMalformedRigs) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kRig, from, to)); });
  };
  EXPECT_TRUE(contains(error("0.8 0 0.6 0", "0.9 0 0.6 0"), "line 16: the matrix in rotation is no rotation"));
  EXPECT_TRUE(contains(error("0.8 0 0.6 0", "-0.8 0 -0.6 0"), "is no rotation"));  // a mirror
  EXPECT_TRUE(contains(error("0.8 0 0.6 0", "0.8 0 0.6"), "expected 9 numbers in rotation, found 8"));
  EXPECT_TRUE(contains(error("0.5 -0.25 1", "0.5 -0.25"), "expected 3 numbers in location, found 2"));
  EXPECT_TRUE(
      contains(error("sensor_id=\"0\" component_id", "sensor_id=\"8\" component_id"), "sensor '8' is not in the file"));
}

TEST(Metashape, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("Metashape", kCameras, 1);
  test::expect_changes_survived("Metashape", kCameras);
  test::expect_cuts_refused("Metashape", kRig, 1);
  test::expect_changes_survived("Metashape", kRig);
}

}  // namespace
}  // namespace gpvc::io
