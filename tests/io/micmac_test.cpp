#include "io/scenes/micmac_scene.h"

#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;

// As Tapas writes them: of FraserBasic, whose distortion is centred on the principal point.
const std::string kCamera = R"(<?xml version="1.0" ?>
<ExportAPERO>
     <CalibrationInternConique>
          <KnownConv>eConvApero_DistM2C</KnownConv>
          <PP>201.5 148.25</PP>
          <F>360</F>
          <SzIm>400 300</SzIm>
          <CalibDistortion>
               <ModPhgrStd>
                    <RadialePart>
                         <CDist>201.5 148.25</CDist>
                         <CoeffDist>-8e-07</CoeffDist>
                         <CoeffDist>1.5e-12</CoeffDist>
                         <CoeffDist>-2e-18</CoeffDist>
                         <PPaEqPPs>true</PPaEqPPs>
                    </RadialePart>
                    <P1>1.1e-06</P1>
                    <P2>-2.2e-06</P2>
                    <b1>0</b1>
                    <b2>0</b2>
               </ModPhgrStd>
          </CalibDistortion>
     </CalibrationInternConique>
</ExportAPERO>
)";

// Looks down from 50 m, its right to the north-east.
const std::string kOrientation = R"(<?xml version="1.0" ?>
<ExportAPERO>
     <OrientationConique>
          <OrIntImaM2C>
               <I00>0 0</I00>
               <V10>1 0</V10>
               <V01>0 1</V01>
          </OrIntImaM2C>
          <TypeProj>eProjStenope</TypeProj>
          <ZoneUtileInPixel>true</ZoneUtileInPixel>
          <FileInterne>Ori-Terrain/AutoCal_Foc-24000_Cam-NIKON_D3X.xml</FileInterne>
          <RelativeNameFI>true</RelativeNameFI>
          <Externe>
               <AltiSol>-3.5</AltiSol>
               <Profondeur>53.5</Profondeur>
               <Time>0</Time>
               <KnownConv>eConvApero_DistM2C</KnownConv>
               <Centre>1000 2000 50</Centre>
               <IncCentre>1 1 1</IncCentre>
               <ParamRotation>
                    <CodageMatr>
                         <L1>0.8 0.6 0</L1>
                         <L2>0.6 -0.8 0</L2>
                         <L3>0 0 -1</L3>
                         <TrueRot>true</TrueRot>
                    </CodageMatr>
               </ParamRotation>
          </Externe>
          <ConvOri>
               <KnownConv>eConvApero_DistM2C</KnownConv>
          </ConvOri>
     </OrientationConique>
</ExportAPERO>
)";

SceneFile parse(const std::string& orientation, const std::string& camera = kCamera) {
  return parse_micmac("Ori-Terrain/Orientation-DSC_1.JPG.xml", orientation, "AutoCal.xml", camera);
}

/// MicMac's formula, in its pixels.
struct Stated {
  double ppx = 201.5, ppy = 148.25, f = 360, cx = 201.5, cy = 148.25;
  double r3 = -8e-7, r5 = 1.5e-12, r7 = -2e-18, p1 = 1.1e-6, p2 = -2.2e-6, b1 = 0, b2 = 0;
  PixelPoint shown(double x, double y) const {
    const double px = ppx + f * x, py = ppy + f * y, qx = px - cx, qy = py - cy, q2 = qx * qx + qy * qy;
    const double radial = r3 * q2 + r5 * q2 * q2 + r7 * q2 * q2 * q2;
    return {px + radial * qx + p1 * (q2 + 2 * qx * qx) + 2 * p2 * qx * qy + b1 * qx + b2 * qy,
            py + radial * qy + p2 * (q2 + 2 * qy * qy) + 2 * p1 * qx * qy};
  }
};

TEST(Micmac, ProjectsAKnownPoint) {
  const SceneFile scene = parse(kOrientation);
  ASSERT_EQ(scene.views.size(), 1);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.views[0].name, "DSC_1.JPG");
  EXPECT_EQ(scene.views[0].camera.width, 400);
  // 40 m ahead of the camera, 8 to its right and 10 down: the columns of the matrix are its axes in the world.
  const WorldPoint point{1000 + 0.8 * 8 + 0.6 * 10, 2000 + 0.6 * 8 - 0.8 * 10, 10};
  const PixelPoint expected = Stated().shown(0.2, 0.25);
  EXPECT_GT(std::abs(expected.x - 201.5 - 72), 0.5);  // the lens shows
  expect_photo_point(scene.views[0], point, expected.x + 0.5, expected.y + 0.5);
}

TEST(Micmac, TakesRadialLensesAndNone) {
  const std::string from =
      kCamera.substr(kCamera.find("<ModPhgrStd>"), kCamera.find("</ModPhgrStd>") + 13 - kCamera.find("<ModPhgrStd>"));
  const WorldPoint point{1000 + 0.8 * 8 + 0.6 * 10, 2000 + 0.6 * 8 - 0.8 * 10, 10};
  // Converters write a term without a number.
  for (const char* none : {"<ModNoDist/>", "<ModRad><CDist>201.5 148.25</CDist><CoeffDist></CoeffDist></ModRad>"}) {
    const SceneFile scene = parse(kOrientation, replaced(kCamera, from, none));
    EXPECT_TRUE(scene.views[0].camera.distortion.is_identity()) << none;
    expect_photo_point(scene.views[0], point, 201.5 + 72 + 0.5, 148.25 + 90 + 0.5);
  }
  const SceneFile radial =
      parse(kOrientation,
            replaced(kCamera, from, "<ModRad><CDist>201.5 148.25</CDist><CoeffDist>-8e-07</CoeffDist></ModRad>"));
  Stated stated;
  stated.r5 = stated.r7 = stated.p1 = stated.p2 = 0;
  expect_photo_point(radial.views[0], point, stated.shown(0.2, 0.25).x + 0.5, stated.shown(0.2, 0.25).y + 0.5);
}

// As Tapas' Fraser leaves it: 2 pixels at a focal length of 360 are 20 at one of 3600.
TEST(Micmac, TakesACentreBesideThePrincipalPoint) {
  const std::string camera =
      replaced(replaced(replaced(kCamera, "<CDist>201.5 148.25", "<CDist>203.5 147.05"), "<b1>0", "<b1>0.0001"),
               "<b2>0", "<b2>-0.0002");
  const SceneFile scene = parse(kOrientation, camera);
  Stated stated;
  stated.cx = 203.5;
  stated.cy = 147.05;
  stated.b1 = 1e-4;
  stated.b2 = -2e-4;
  double worst = 0, without = 0;
  for (double y = -0.4; y <= 0.41; y += 0.1)
    for (double x = -0.55; x <= 0.56; x += 0.1) {
      const WorldPoint point{1000 + 40 * (0.8 * x + 0.6 * y), 2000 + 40 * (0.6 * x - 0.8 * y), 10};
      const View& view = scene.views.at(0);
      const auto photo =
          photo_from_pixel(view.camera, pixel_from_camera(view.camera, camera_from_world(view.pose, point)));
      ASSERT_TRUE(photo);
      const PixelPoint expected = stated.shown(x, y), other = Stated().shown(x, y);
      worst = std::max(worst, std::hypot(photo->x - 0.5 - expected.x, photo->y - 0.5 - expected.y));
      without = std::max(without, std::hypot(other.x - expected.x, other.y - expected.y));
    }
  EXPECT_GT(without, 0.15);
  EXPECT_LT(worst, 0.02);
  const std::string far = replaced(camera, "<CDist>203.5", "<CDist>283.5");
  EXPECT_TRUE(contains(input_error([&] { parse(kOrientation, far); }),
                       "the centre of distortion lies so far from the principal point that the terms of ModPhgrStd"));
}

// A camera of IGN's Stereopolis (conic.ori.xml of github.com/LI3DS/cli-li3ds), whose points of symmetry lie 6 pixels apart.
TEST(Micmac, TakesARealLensOfTwoCentres) {
  const std::string text =
      "<ExportAPERO><CalibrationInternConique><KnownConv>eConvApero_DistM2C</KnownConv><PP>960.860 536.884</PP>"
      "<F>1396.439</F><SzIm>1920 1080</SzIm><CalibDistortion><ModRad><CDist>954.876 537.357</CDist>"
      "<CoeffDist>-5.811586e-008</CoeffDist><CoeffDist>5.119552e-014</CoeffDist><CoeffDist>-1.267293e-020</CoeffDist>"
      "</ModRad></CalibDistortion></CalibrationInternConique></ExportAPERO>";
  const SceneFile scene = parse(kOrientation, text);
  EXPECT_EQ(scene.warnings.at(0),
            "the lens is distorted about another point than its principal point, which is modelled to 0.03 pixels");
  const Stated stated{960.860, 536.884, 1396.439, 954.876, 537.357, -5.811586e-8, 5.119552e-14, -1.267293e-20, 0, 0};
  const Camera& camera = scene.views.at(0).camera;
  for (double y = -0.38; y <= 0.39; y += 0.076)
    for (double x = -0.68; x <= 0.69; x += 0.068) {
      const auto photo = photo_from_pixel(camera, pixel_from_camera(camera, {x, y, 1}));
      ASSERT_TRUE(photo);
      EXPECT_NEAR(photo->x - 0.5, stated.shown(x, y).x, 0.035);
      EXPECT_NEAR(photo->y - 0.5, stated.shown(x, y).y, 0.035);
    }
}

TEST(Micmac, ReadsAFolder) {
  const test::TemporaryFolder folder;
  folder.write("Ori-Terrain/Orientation-a.JPG.xml", kOrientation);
  folder.write("Ori-Terrain/Orientation-b.JPG.xml", replaced(kOrientation, "1000 2000 50", "1001 2000 50"));
  folder.write("Ori-Terrain/AutoCal_Foc-24000_Cam-NIKON_D3X.xml", kCamera);
  folder.write("Ori-Terrain/Residus.xml", "<other/>");
  test::write_photo(folder.path() / "a.JPG", 400, 300);
  test::write_photo(folder.path() / "b.JPG", 400, 300);
  for (const std::filesystem::path& source : {folder.path(), folder.path() / "Ori-Terrain"}) {
    const Scene scene = read_scene(source, {});
    EXPECT_EQ(scene.format, "MicMac");
    ASSERT_EQ(scene.views.size(), 2);
    EXPECT_EQ(scene.views[1].pose.centre, (WorldPoint{1001, 2000, 50}));
    EXPECT_EQ(scene.files.size(), 3);
  }
  // The camera lies where its path says if it is not beside the orientation.
  folder.write("Ori-Moved/Orientation-a.JPG.xml", kOrientation);
  EXPECT_EQ(read_scene(folder.path() / "Ori-Moved", {}).views.size(), 1);
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path(), {}); }),
                       "holds 2 of MicMac's orientations, among them Ori-Moved and Ori-Terrain"));
  std::filesystem::remove(folder.path() / "Ori-Terrain/AutoCal_Foc-24000_Cam-NIKON_D3X.xml");
  EXPECT_TRUE(contains(input_error([&] { read_scene(folder.path() / "Ori-Moved", {}); }),
                       "the camera 'Ori-Terrain/AutoCal_Foc-24000_Cam-NIKON_...' of its photos is not in it"));
}

TEST(Micmac, ReadsCamerasWithinOrientations) {
  std::string inner = kCamera.substr(kCamera.find("<CalibrationInternConique>"));
  inner = replaced(
      replaced(replaced(inner, "<CalibrationInternConique>", "<Interne>"), "</CalibrationInternConique>", "</Interne>"),
      "</ExportAPERO>", "");
  const SceneFile scene = parse(
      replaced(kOrientation, "<FileInterne>Ori-Terrain/AutoCal_Foc-24000_Cam-NIKON_D3X.xml</FileInterne>", inner), "");
  EXPECT_EQ(scene.views.at(0).camera, parse(kOrientation).views.at(0).camera);
}

TEST(Micmac, RefusesWithPlaceAndExpectation) {
  const auto error = [](const std::string& from, const std::string& to) {
    return input_error([&] { parse(replaced(kOrientation, from, to)); });
  };
  const auto of_camera = [](const std::string& from, const std::string& to) {
    return input_error([&] { parse(kOrientation, replaced(kCamera, from, to)); });
  };
  EXPECT_TRUE(contains(error("<V10>1 0", "<V10>2 0"), "Orientation-DSC_1.JPG.xml: line 4: an affine map"));
  EXPECT_TRUE(contains(error("eProjStenope", "eProjOrtho"), "a projection of the type 'eProjOrtho' is not read"));
  EXPECT_TRUE(contains(error("<KnownConv>eConvApero_DistM2C", "<KnownConv>eConvApero_DistC2M"),
                       "line 17: the convention 'eConvApero_DistC2M' is not read, eConvApero_DistM2C is"));
  EXPECT_TRUE(contains(error("<Centre>1000 2000 50", "<Centre>1000 2000"), "expected 3 numbers in Centre, found 2"));
  EXPECT_TRUE(contains(error("CodageMatr>", "CodageAngulaire>"), "XML"));
  EXPECT_TRUE(contains(error("<L1>0.8", "<L1>0.9"), "L1, L2 and L3 are no rotation"));
  EXPECT_TRUE(contains(error("<FileInterne>Ori-Terrain/AutoCal_Foc-24000_Cam-NIKON_D3X.xml</FileInterne>", ""),
                       "states no camera"));
  EXPECT_TRUE(contains(of_camera("<F>360", "<F>0"), "AutoCal.xml: line 3: the focal length"));
  EXPECT_TRUE(contains(of_camera("<SzIm>400", "<SzIm>4e9"), "two whole numbers"));
  EXPECT_TRUE(contains(of_camera("<PP>201.5 148.25</PP>", ""), "has no PP"));
  EXPECT_TRUE(contains(of_camera("<CoeffDist>-8e-07", "<CoeffDist>much"), "expected finite numbers in CoeffDist"));
  std::string fisheye = replaced(kCamera, "<ModPhgrStd>", "<ModUnif><TypeModele>eModele_FishEye_10_5_5</TypeModele>");
  fisheye = replaced(fisheye, "</ModPhgrStd>", "</ModUnif>");
  EXPECT_TRUE(
      contains(input_error([&] { parse(kOrientation, fisheye); }),
               "line 9: distortion of the kind 'eModele_FishEye_10_5_5' is not read, ModRad and ModPhgrStd are; "
               "undistort the photos by 'mm3d Drunk'"));
}

TEST(Micmac, SurvivesCuts) {
  for (std::size_t size = 0; size + 1 < kOrientation.size(); ++size)
    EXPECT_THROW(parse(kOrientation.substr(0, size)), InputError) << size;
  for (std::size_t size = 0; size + 1 < kCamera.size(); ++size)
    EXPECT_THROW(parse(kOrientation, kCamera.substr(0, size)), InputError) << size;
}

}  // namespace
}  // namespace gpvc::io
