#include "io/scene_files.h"
#include "tests/support/scene_folder.h"
#include "tests/support/zip_archive.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::expect_photo_point;
using test::input_error;
using test::replaced;
using test::view_named;

// Two photogroups written from the format's documentation. The first looks straight down with angles, in millimetres,
// with every lens term; the second is a matrix under the photogrammetrist's axes, in pixels.
const std::string kBlocks = R"(<?xml version="1.0" encoding="utf-8"?>
<!-- a comment <BlocksExchange> in front -->
<BlocksExchange version="2.1">
  <SpatialReferenceSystems>
    <SRS><Id>0</Id><Name>Lambert 93</Name><Definition>EPSG:2154</Definition></SRS>
    <SRS><Id>7</Id><Name>degrees</Name><Definition>EPSG:4326</Definition></SRS>
  </SpatialReferenceSystems>
  <BaseImagePath>D:\data\flight</BaseImagePath>
  <Block>
    <Name>Block 1</Name>
    <SRSId>0</SRSId>
    <Photogroups>
      <Photogroup>
        <ImageDimensions><Width>400</Width><Height>300</Height></ImageDimensions>
        <CameraModelType>Perspective</CameraModelType>
        <FocalLength>25</FocalLength>
        <SensorSize>20</SensorSize>
        <CameraOrientation>XRightYDown</CameraOrientation>
        <PrincipalPoint><x>201.25</x><y>148.5</y></PrincipalPoint>
        <Distortion><K1>-0.1</K1><K2>0.02</K2><K3>0.003</K3><P1>0.004</P1><P2>-0.002</P2></Distortion>
        <AspectRatio>1.01</AspectRatio>
        <Skew>0.75</Skew>
        <Photo>
          <Id>1</Id><ImagePath>north\one two.jpg</ImagePath><Component>1</Component>
          <Pose>
            <Rotation><Omega>180</Omega><Phi>0</Phi><Kappa>30</Kappa></Rotation>
            <Center><x>652000</x><y>6863000</y><z>100</z></Center>
          </Pose>
        </Photo>
        <Photo><Id>2</Id><ImagePath>north\lost.jpg</ImagePath></Photo>
        <Photo>
          <Id>4</Id><ImagePath>north\aside.jpg</ImagePath><Component>0</Component>
          <Pose>
            <Rotation><Omega>180</Omega><Phi>0</Phi><Kappa>30</Kappa></Rotation>
            <Center><x>652000</x><y>6863000</y><z>100</z></Center>
          </Pose>
        </Photo>
      </Photogroup>
      <Photogroup>
        <ImageDimensions><Width>300</Width><Height>400</Height></ImageDimensions>
        <FocalLengthPixels>350</FocalLengthPixels>
        <PixelSize>0.01</PixelSize>
        <CameraOrientation>XRightYUp</CameraOrientation>
        <PrincipalPoint><xmm>0.05</xmm><ymm>0.02</ymm></PrincipalPoint>
        <Photo>
          <Id>3</Id><ImagePath>E:/elsewhere/three.jpg</ImagePath>
          <Pose>
            <Rotation>
              <M_00>1</M_00><M_01>0</M_01><M_02>0</M_02>
              <M_10>0</M_10><M_11>1</M_11><M_12>0</M_12>
              <M_20>0</M_20><M_21>0</M_21><M_22>1</M_22>
            </Rotation>
            <Center><x>652010</x><y>6863000</y><z>100</z></Center>
          </Pose>
        </Photo>
      </Photogroup>
    </Photogroups>
  </Block>
</BlocksExchange>
)";

SceneFile parse(const std::string& text) { return test::parse_as("BlocksExchange", text); }

// Omega 180 turns the camera's z down, kappa 30 turns it about the plumb line: Rx(180) Rz(30) has the columns (cos,
// -sin, 0), (-sin, -cos, 0), (0, 0, -1): camera x is the first of them.
TEST(BlocksExchange, ProjectsAKnownPointWithAnglesAndLens) {
  const SceneFile scene = parse(kBlocks);
  const double c = std::cos(30 * std::acos(-1.0) / 180), s = 0.5;
  // Ten east, five north of the nadir, 100 m below.
  const double x = (c * 10 - s * 5) / 100, y = (-s * 10 - c * 5) / 100, r2 = x * x + y * y;
  const double radial = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
  const double u = x * radial + 2 * -0.002 * x * y + 0.004 * (r2 + 2 * x * x);
  const double v = y * radial + 2 * 0.004 * x * y - 0.002 * (r2 + 2 * y * y);
  const double f = 25 / (20.0 / 400);
  // The centre of the upper left pixel is (0, 0) there and (0.5, 0.5) here.
  expect_photo_point(view_named(scene, "D:/data/flight/north/one two.jpg"), {652010, 6863005, 0},
                     f * u + 0.75 * v + 201.25 + 0.5, 1.01 * f * v + 148.5 + 0.5);
}

// The guide's example has P1 = 1 and no other term: 90 degrees lie on a circle of the focal matrix's size. Without that
// matrix, a pixel beside the axis is as large as the focal length says.
TEST(BlocksExchange, ProjectsThroughAFisheye) {
  const std::string matrix =
      "<FisheyeFocalMatrix><M_00>190</M_00><M_01>0</M_01><M_10>0</M_10><M_11>191</M_11></FisheyeFocalMatrix>";
  const std::string terms =
      "<FisheyeDistortion><P0>0</P0><P1>1</P1><P2>0.02</P2><P3>-0.1</P3><P4>0.03</P4></FisheyeDistortion>";
  const auto view = [&](const std::string& lens) {
    const std::string type = "<CameraModelType>Fisheye</CameraModelType>";
    const std::string text =
        replaced(kBlocks, "<PixelSize>0.01</PixelSize>", "<PixelSize>0.01</PixelSize>" + type + lens);
    return view_named(parse(text), "E:/elsewhere/three.jpg");
  };
  // 3 units east, 4 north, 10 below: right and up in the photo.
  const WorldPoint point{652013, 6863004, 90};
  const double pi = std::acos(-1), t = 2 / pi * std::atan(0.5), cx = 150 + 5, cy = 200 - 2;
  const double rho = t + 0.02 * t * t - 0.1 * t * t * t + 0.03 * t * t * t * t;
  expect_photo_point(view(matrix + terms), point, cx + 190 * rho * 0.6, cy - 191 * rho * 0.8);
  expect_photo_point(view(matrix), point, cx + 190 * t * 0.6, cy - 191 * t * 0.8);
  expect_photo_point(view(""), point, cx + 350 * std::atan(0.5) * 0.6, cy - 350 * std::atan(0.5) * 0.8);
  EXPECT_TRUE(contains(input_error([&] { view(replaced(terms, "<P0>0", "<P0>0.1")); }), "line 39: the fisheye's"));
}

TEST(BlocksExchange, TurnsThePhotogrammetristsAxes) {
  const SceneFile scene = parse(kBlocks);
  const View& view = view_named(scene, "E:/elsewhere/three.jpg");
  // Its z points up, so it looks down at a point one unit east and two north: right and up in the photo.
  expect_photo_point(view, {652011, 6863002, 90}, 150 + 0.05 / 0.01 + 350 * 0.1, 200 - 0.02 / 0.01 - 350 * 0.2);
}

// The example of the documentation states one rotation both ways.
TEST(BlocksExchange, AgreesWithTheDocumentedAngles) {
  const std::string matrix =
      "<M_00>-0.9999982912233401</M_00><M_01>-0.001636319085375301</M_01><M_02>-0.0008602425863163225</M_02>"
      "<M_10>-0.001631068695467463</M_10><M_11>0.9999802528616577</M_11><M_12>-0.00606906089589293</M_12>"
      "<M_20>0.0008701565192966738</M_20><M_21>-0.006067647409696231</M_21><M_22>-0.9999812130648239</M_22>";
  const std::string angles =
      "<Omega>179.6523471469934</Omega><Phi>0.04985630236313049</Phi><Kappa>179.9065465708369</Kappa>";
  const std::string here = "<Omega>180</Omega><Phi>0</Phi><Kappa>30</Kappa>";
  const SceneFile a = parse(replaced(kBlocks, here, matrix)), b = parse(replaced(kBlocks, here, angles));
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(a.views[0].pose.rotation[i], b.views[0].pose.rotation[i], 1e-10);
}

// A camera that looks the same way under every orientation: rows are the named axes in the world.
TEST(BlocksExchange, KnowsEveryCameraOrientation) {
  const char* kNames[] = {"XRightYDown", "XRightYUp",  "XLeftYDown", "XLeftYUp",
                          "XDownYRight", "XDownYLeft", "XUpYRight",  "XUpYLeft"};
  // Canonical: right = +x, down = -y, forward = -z.
  const WorldPoint right{1, 0, 0}, down{0, -1, 0};
  const auto minus = [](const WorldPoint& p) { return WorldPoint{-p.x, -p.y, -p.z}; };
  for (const std::string name : kNames) {
    const auto axis = [&](std::size_t at) {
      const std::string word = name.substr(at);
      if (word.starts_with("Right")) return right;
      if (word.starts_with("Left")) return minus(right);
      return word.starts_with("Down") ? down : minus(down);
    };
    const WorldPoint x = axis(1), y = axis(name.find('Y') + 1);
    const WorldPoint z{x.y * y.z - x.z * y.y, x.z * y.x - x.x * y.z, x.x * y.y - x.y * y.x};
    std::string rows;
    const double m[] = {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
    for (int i = 0; i < 9; ++i) {
      const std::string tag = "M_" + std::to_string(i / 3) + std::to_string(i % 3);
      rows += "<" + tag + ">" + std::to_string(m[i]) + "</" + tag + ">";
    }
    std::string text = replaced(kBlocks, "<Omega>180</Omega><Phi>0</Phi><Kappa>30</Kappa>", rows);
    text = replaced(text, "<CameraOrientation>XRightYDown", "<CameraOrientation>" + name);
    const SceneFile scene = parse(text);
    const CameraPoint p = camera_from_world(scene.views[0].pose, {652001, 6863002, 97});
    EXPECT_NEAR(p.x, 1, 1e-9) << name;
    EXPECT_NEAR(p.y, -2, 1e-9) << name;
    EXPECT_NEAR(p.z, 3, 1e-9) << name;
  }
}

TEST(BlocksExchange, CarriesTheSystemAndSaysWhatItLeavesOut) {
  const SceneFile scene = parse(kBlocks);
  EXPECT_EQ(scene.srs, "EPSG:2154");
  EXPECT_EQ(scene.views.size(), 2);
  ASSERT_EQ(scene.warnings.size(), 2);
  EXPECT_TRUE(contains(scene.warnings[0], "1 photos without a pose"));
  EXPECT_TRUE(contains(scene.warnings[1], "1 photos outside the main component"));
  // The block with the most photos is read.
  const std::string two = replaced(kBlocks, "<Block>", "<Block><Name>empty</Name></Block><Block>");
  EXPECT_EQ(parse(two).views.size(), 2);
  EXPECT_TRUE(contains(parse(two).warnings[0], "2 blocks; 'Block 1'"));
}

TEST(BlocksExchange, LocalCoordinatesAreNoReferenceSystem) {
  const auto srs = [](const std::string& definition) { return parse(replaced(kBlocks, "EPSG:2154", definition)).srs; };
  EXPECT_EQ(srs("LOCAL_CS[\"Local coordinates; m\",LOCAL_DATUM[\"Local\",0]]"), "");
  EXPECT_EQ(srs("PROJCS[\"a\",\n  UNIT[\"metre\",1]]"), "PROJCS[\"a\",UNIT[\"metre\",1]]");
}

TEST(BlocksExchange, FindsPhotosByTheirTails) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("out/block.xml", kBlocks);
  test::write_photo(folder.path() / "copied/north/one two.JPG", 400, 300);
  test::write_photo(folder.path() / "copied/south/one two.jpg.txt/one.png", 40, 30);
  test::write_photo(folder.path() / "copied/three.jpg", 300, 400);
  EXPECT_TRUE(contains(input_error([&] { read_scene(file, {}); }), "2 of 2 photos are not in"));
  for (const auto& source : {file, folder.path() / "out"}) {
    const Scene scene = read_scene(source, {.images_dir = folder.path() / "copied"});
    ASSERT_EQ(scene.views.size(), 2);
    EXPECT_EQ(scene.format, "BlocksExchange");
    EXPECT_EQ(scene.views[0].name, "data/flight/north/one two.jpg");
    EXPECT_EQ(scene.views[0].photo, folder.path() / "copied/north/one two.JPG");
    EXPECT_EQ(scene.views[1].name, "elsewhere/three.jpg");
  }
}

// "If not absolute, relative to BaseImagePath if defined, or otherwise to the directory of the exchange file."
TEST(BlocksExchange, UsesTheMasksItStates) {
  const test::TemporaryFolder folder;
  const auto root = folder.path();
  const std::string name = "<ImagePath>north\\one two.jpg</ImagePath>",
                    masked = replaced(kBlocks, name, name + "<MaskPath>masks\\one msk.png</MaskPath>");
  const auto file = folder.write("out/block.xml", masked);
  test::write_photo(root / "copied/north/one two.jpg", 400, 300);
  test::write_photo(root / "copied/three.jpg", 300, 400);
  SceneOptions options;
  options.images_dir = root / "copied";
  EXPECT_EQ(read_scene(file, options).warnings.back(),
            "1 masks that the scene names are not found, among them D:/data/flight/masks/one msk.png");
  EXPECT_TRUE(read_scene(file, options).views[0].mask.empty());
  // Beside a photo that has moved, and in a folder that the user names.
  test::write_photo(root / "copied/north/one msk.png", 400, 300);
  const Scene moved = read_scene(file, options);
  EXPECT_EQ(moved.views[0].mask, root / "copied/north/one msk.png");
  EXPECT_TRUE(moved.views[1].mask.empty());
  EXPECT_TRUE(contains(moved.warnings.back(), "main component"));
  options.masks_dir = root / "elsewhere";
  test::write_photo(root / "elsewhere/one msk.png", 400, 300);
  EXPECT_EQ(read_scene(file, options).views[0].mask, root / "elsewhere/one msk.png");
  options.masks = false;
  EXPECT_TRUE(read_scene(file, options).views[0].mask.empty());
  EXPECT_TRUE(contains(read_scene(file, options).warnings.back(), "main component"));
  // From the file's folder, where no base is given.
  options = {};
  options.images_dir = root / "copied";
  folder.write("out/block.xml", replaced(masked, "<BaseImagePath>D:\\data\\flight</BaseImagePath>", ""));
  test::write_photo(root / "out/masks/one msk.png", 400, 300);
  EXPECT_EQ(read_scene(file, options).views[1].mask, root / "out/masks/one msk.png");
  test::write_photo(root / "out/masks/one msk.png", 300, 300);
  EXPECT_TRUE(contains(input_error([&] { read_scene(file, options); }), "is 300 x 300 pixels, its photo"));
}

// A folder of the same name where the program happens to run is none of the scene's.
TEST(BlocksExchange, LooksForRelativeMasksFromItsOwnFolder) {
  const test::TemporaryFolder folder, elsewhere;
  const std::string name = "<ImagePath>north\\one two.jpg</ImagePath>";
  const auto file =
      folder.write("out/block.xml", replaced(replaced(kBlocks, name, name + "<MaskPath>masks\\m.png</MaskPath>"),
                                             "<BaseImagePath>D:\\data\\flight</BaseImagePath>", ""));
  test::write_photo(folder.path() / "copied/north/one two.jpg", 400, 300);
  test::write_photo(folder.path() / "copied/three.jpg", 300, 400);
  test::write_photo(elsewhere.path() / "masks/m.png", 400, 300);
  const test::WorkingFolder running(elsewhere.path());
  SceneOptions options;
  options.images_dir = folder.path() / "copied";
  EXPECT_TRUE(contains(read_scene(file, options).warnings.back(), "1 masks that the scene names are not found"));
  test::write_photo(folder.path() / "out/masks/m.png", 400, 300);
  EXPECT_EQ(read_scene(file, options).views[1].mask, folder.path() / "out/masks/m.png");
}

TEST(BlocksExchange, RefusesWithLineAndExpectation) {
  const auto error = [](std::string_view from, std::string_view to) {
    return input_error([&] { parse(replaced(kBlocks, from, to)); });
  };
  EXPECT_TRUE(contains(error("<SRSId>0", "<SRSId>7"), "line 6: the positions are degrees of 'EPSG:4326'"));
  EXPECT_TRUE(contains(error("<SRSId>0", "<SRSId>9"), "SRS '9' is not defined"));
  EXPECT_TRUE(
      contains(error("E:/elsewhere/three.jpg", "E:/elsewhere/"), "expected the name of a photo, found 'E:/else"));
  EXPECT_TRUE(contains(error("XRightYDown", "XSideways"), "line 18: expected a CameraOrientation"));
  const std::string spherical = replaced(kBlocks, "Perspective", "Spherical");
  EXPECT_TRUE(contains(input_error([&] {
                         parse(replaced(spherical, "<FocalLengthPixels>",
                                        "<CameraModelType>Spherical</CameraModelType><FocalLengthPixels>"));
                       }),
                       "line 15: camera model 'Spherical' is not supported"));
  // Where there are others its photos are left out.
  ASSERT_EQ(parse(spherical).views.size(), 1);
  EXPECT_EQ(parse(spherical).views[0].name, "E:/elsewhere/three.jpg");
  EXPECT_EQ(parse(spherical).warnings.at(0), "1 photos are left out: their lens, 'Spherical', is not supported");
  EXPECT_TRUE(contains(error("<SensorSize>20</SensorSize>", ""), "SensorSize or PixelSize"));
  EXPECT_TRUE(contains(error("<FocalLength>25</FocalLength>", ""), "Photogroup has no FocalLength"));
  EXPECT_TRUE(contains(error("<K1>-0.1", "<K1>much"), "a finite number in K1, found 'much'"));
  EXPECT_TRUE(contains(error("<Width>400", "<Width>1e18"), "whole number"));
  EXPECT_TRUE(contains(error("<M_00>1", "<M_00>2"), "is no rotation"));
  EXPECT_TRUE(contains(error("<M_00>1", "<M_00>-1"), "is no rotation"));
  EXPECT_TRUE(contains(error("<Phi>0</Phi>", ""), "Rotation has no Phi"));
  EXPECT_TRUE(contains(error("<Omega>180</Omega>", "<Heading>3</Heading>"), "other angles are not read"));
  EXPECT_TRUE(contains(error("</Photogroups>", ""), "well-formed XML"));
  EXPECT_TRUE(contains(input_error([] { parse("<BlocksExchange/>"); }), "no photo has a pose"));
  EXPECT_TRUE(contains(input_error([] { parse("<other/>"); }), "expected <BlocksExchange>"));
  EXPECT_TRUE(contains(input_error([] { parse(""); }), "XML"));
}

TEST(BlocksExchange, ReadsXmlz) {
  const test::TemporaryFolder folder;
  test::write_photo(folder.path() / "north/one two.jpg", 400, 300);
  test::write_photo(folder.path() / "three.jpg", 300, 400);
  folder.write("block.xml", kBlocks);
  const SceneOptions options{.images_dir = folder.path()};
  const Scene plain = read_scene(folder.path() / "block.xml", options);
  std::filesystem::remove(folder.path() / "block.xml");
  // The guide does not say how the document is called, nor that it is alone.
  folder.write("block.xmlz", test::zipped({{"Block 1/export.XML", kBlocks}, {"other.xml", "<other/>"}, {"a.txt", ""}}));
  for (const std::filesystem::path& source : {folder.path(), folder.path() / "block.xmlz"}) {
    const Scene scene = read_scene(source, options);
    EXPECT_EQ(scene.format, "BlocksExchange");
    EXPECT_EQ(scene.read_from, folder.path() / "block.xmlz");
    ASSERT_EQ(scene.views.size(), plain.views.size());
    for (std::size_t v = 0; v < plain.views.size(); ++v) {
      EXPECT_EQ(scene.views[v].name, plain.views[v].name);
      EXPECT_EQ(scene.views[v].camera, plain.views[v].camera);
      EXPECT_EQ(scene.views[v].pose.centre, plain.views[v].pose.centre);
    }
  }
  const auto error = [&](const std::string& bytes) { return input_error([&] { parse(bytes); }); };
  EXPECT_TRUE(contains(error(test::zipped({{"other.xml", "<other/>"}})), "holds no BlocksExchange XML"));
  EXPECT_TRUE(contains(error(test::zipped({{"a.xml", kBlocks}, {"b.xml", kBlocks}})),
                       "holds 2 BlocksExchange documents, among them 'a.xml' and 'b.xml'"));
  EXPECT_TRUE(contains(error(test::zipped({{"a.xml", replaced(kBlocks, "<M_00>1", "<M_00>2")}})), "no rotation"));
}

TEST(BlocksExchange, TellsDegreesByTheirSystem) {
  const auto read = [](const std::string& definition) { return parse(replaced(kBlocks, "EPSG:2154", definition)); };
  const std::string geographic = "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]]]";
  for (const std::string& degrees :
       {std::string("EPSG:4490"), std::string("EPSG:4326+5773"), std::string("epsg: 4258"), std::string("WGS84"),
        std::string("urn:ogc:def:crs:EPSG::4269"), std::string("+proj=longlat +datum=WGS84 +no_defs"),
        std::string("+proj=latlong +ellps=GRS80"), geographic,
        "COMPD_CS[\"WGS 84 + EGM96\"," + geographic + ",VERT_CS[\"EGM96\"]]",
        std::string("GEOGCRS[\"ETRS89\",CS[ellipsoidal,2]]")})
    EXPECT_TRUE(contains(input_error([&] { read(degrees); }), "the positions are degrees of")) << degrees;
  for (const std::string& metres :
       {std::string("EPSG:32632+5773"), std::string("EPSG:4978"), std::string("EPSG:4547"),
        "PROJCS[\"WGS 84 / UTM zone 32N\"," + geographic + "]", std::string("+proj=utm +zone=32"),
        std::string("GEODCRS[\"WGS 84\",CS[Cartesian,3]]"), "PROJCRS[\"a\",BASE" + std::string("GEOGCRS[\"ETRS89\"]]")})
    EXPECT_EQ(read(metres).srs, metres);
}

TEST(BlocksExchange, SurvivesCutsAndChanges) {
  test::expect_cuts_refused("BlocksExchange", kBlocks, 1);
  test::expect_changes_survived("BlocksExchange", kBlocks);
}

}  // namespace
}  // namespace gpvc::io
