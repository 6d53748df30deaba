#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>

#include "io/mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::bytes_of;
using test::contains;
using test::input_error;
using test::replaced;
using test::TemporaryFolder;

// Two triangles over a quad; a third of no area, a duplicate, a vertex nobody uses: all of it must survive.
//   3---2
//   | / |      4 unused
//   0---1
const std::vector<WorldPoint> kPositions{
    {0.1, 0.2, 0.3}, {1e6 + 1.0 / 3, 0, 0}, {4e6 + 0.1, 5e6 + 0.7, 1e-300}, {-0.0, 1, 2}, {9, 9, 9}};
const std::vector<Triangle> kFaces{{0, 1, 2}, {0, 2, 3}, {0, 0, 1}, {0, 1, 2}};

std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string ascii_ply(const std::string& line_end = "\n") {
  std::string text =
      "ply\nformat ascii 1.0\ncomment made by hand\nobj_info nothing\nelement vertex 5\nproperty uchar red\n"
      "property double x\nproperty double y\nproperty double z\nproperty list uchar float weights\n"
      "element face 4\nproperty list uchar int vertex_indices\nproperty int flags\nend_header\n";
  for (const WorldPoint& p : kPositions)
    text += "255 " + exact(p.x) + " " + exact(p.y) + " " + exact(p.z) + " 2 0.5 .5\n";
  for (const Triangle& f : kFaces)
    text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + " -7\n";
  std::string out;
  for (const char c : text) out += c == '\n' ? line_end : std::string(1, c);
  return out;
}

template <typename Count = std::uint8_t, typename Index = std::int32_t>
std::string binary_ply(bool big, const std::string& count_type = "uchar", const std::string& index_type = "int",
                       const std::string& line_end = "\n") {
  std::string text = "ply\nformat binary_" + std::string(big ? "big" : "little") +
                     "_endian 1.0\nelement camera 2\nproperty short id\nelement vertex 5\nproperty double x\n"
                     "property double y\nproperty double z\nproperty list ushort double extra\nproperty uchar red\n"
                     "element face 4\nproperty float quality\nproperty list " +
                     count_type + " " + index_type + " vertex_index\nproperty list uchar float texcoord\nend_header\n";
  std::string header;
  for (const char c : text) header += c == '\n' ? line_end : std::string(1, c);
  std::string body = bytes_of<std::int16_t>(1, big) + bytes_of<std::int16_t>(2, big);
  for (const WorldPoint& p : kPositions)
    body += bytes_of(p.x, big) + bytes_of(p.y, big) + bytes_of(p.z, big) + bytes_of<std::uint16_t>(1, big) +
            bytes_of(2.5, big) + bytes_of<std::uint8_t>(255);
  for (const Triangle& f : kFaces) {
    body += bytes_of(0.25f, big) + bytes_of(static_cast<Count>(3), big);
    for (const std::uint32_t v : f) body += bytes_of(static_cast<Index>(v), big);
    body += bytes_of<std::uint8_t>(6) + std::string(24, '\x01');
  }
  return header + body;
}

std::string obj_text() {
  std::string text = "# by hand\nmtllib none.mtl\no thing\n";
  for (const WorldPoint& p : kPositions) text += "v " + exact(p.x) + " " + exact(p.y) + " " + exact(p.z) + "\n";
  return text +
         "vt 0 0\nvn 0 0 1\ng first\nusemtl a\nf 1 2 3\nf 1/1 3/1 4/1\ng second\ns off\nf 1//1 1//1 2//1\nf "
         "1/1/1 "
         "2/1/1 3/1/1\n";
}

void expect_scene(const Mesh& mesh) {
  EXPECT_EQ(mesh.positions, kPositions);
  EXPECT_TRUE(std::signbit(mesh.positions[3].x));
  EXPECT_EQ(mesh.faces, kFaces);
}

TEST(MeshFile, KeepsEveryDigitAndEveryFace) {
  const TemporaryFolder folder;
  // Names say nothing about the content.
  expect_scene(read_mesh(folder.write("a.mesh", ascii_ply())));
  expect_scene(read_mesh(folder.write("b.obj", ascii_ply("\r\n"))));
  expect_scene(read_mesh(folder.write("c d.ply", binary_ply(false))));
  expect_scene(read_mesh(folder.write("d", binary_ply(true))));
  expect_scene(read_mesh(folder.write("e.ply", obj_text())));
}

TEST(MeshFile, ReadsBinaryBodyAfterHeaderWithCarriageReturns) {
  const TemporaryFolder folder;
  expect_scene(read_mesh(folder.write("a.ply", binary_ply(false, "uchar", "int", "\r\n"))));
}

TEST(MeshFile, ReadsEveryIntegerTypeOfAList) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& bytes) { expect_scene(read_mesh(folder.write("a.ply", bytes))); };
  for (const bool big : {false, true}) {
    read(binary_ply<std::int8_t, std::uint32_t>(big, "int8", "uint32"));
    read(binary_ply<std::int16_t, std::int8_t>(big, "short", "char"));
    read(binary_ply<std::uint16_t, std::uint8_t>(big, "uint16", "uint8"));
    read(binary_ply<std::int32_t, std::int16_t>(big, "int32", "int16"));
    read(binary_ply<std::uint32_t, std::uint16_t>(big, "uint", "ushort"));
  }
}

TEST(MeshFile, ReadsFloatAndIntegerCoordinates) {
  const TemporaryFolder folder;
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float z\nproperty short y\nproperty "
      "uint x\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  std::string body;
  for (int i = 0; i < 3; ++i)
    body += bytes_of(0.1f) + bytes_of<std::int16_t>(-3) + bytes_of<std::uint32_t>(4000000000u);
  body += bytes_of<std::uint8_t>(3) + bytes_of(0) + bytes_of(1) + bytes_of(2);
  const Mesh mesh = read_mesh(folder.write("a.ply", header + body));
  EXPECT_EQ(mesh.positions[2], (WorldPoint{4e9, -3, static_cast<double>(0.1f)}));
}

TEST(MeshFile, ReadsAsciiFloatsWithTheDigitsTheyHave) {
  const TemporaryFolder folder;
  const Mesh mesh = read_mesh(
      folder.write("a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                   "500000.12345678901 +1e3 -.5\n0 1e-400 0 1\n0 0\n3 0 1 2"));
  EXPECT_EQ(mesh.positions[0], (WorldPoint{500000.12345678901, 1000, -0.5}));
  EXPECT_EQ(mesh.positions[1].y, 0);
  EXPECT_EQ(mesh.positions[2].x, 1);
}

TEST(MeshFile, LeavesOutFacesOfTwoVerticesAndSaysSo) {
  const TemporaryFolder folder;
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 3\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  for (const auto& [name, text] :
       {std::pair{"a.ply", header + "2 0 1\n3 0 1 2\n3 2 1 0\n"},
        std::pair{"a.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\nf 3 2 1\n")}}) {
    const Mesh mesh = read_mesh(folder.write(name, text));
    EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 0}})) << name;
    EXPECT_EQ(mesh.source_face, (std::vector<std::uint32_t>{1, 2})) << name;
    ASSERT_EQ(mesh.warnings.size(), 1u) << name;
    EXPECT_TRUE(contains(mesh.warnings[0], "1 faces of fewer than three vertices are left out")) << mesh.warnings[0];
  }
}

TEST(MeshFile, ReadsTriangleStrips) {
  const TemporaryFolder folder;
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n10 0 1 2 3 -1 4 3 2 2 1\n";
  EXPECT_EQ(read_mesh(folder.write("a.ply", text)).faces, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {4, 3, 2}}));
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.write("b.ply", replaced(text, "-1 4", "-1 5"))); }),
                       "refers to vertex 5"));
}

TEST(MeshFile, LeavesOutValuesThatTheHeaderDoesNotDeclare) {
  const TemporaryFolder folder;
  const std::string text =
      "ply\nformat ascii 1.0\nCreated by Blender3D 247\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9 0.5 0.5 0.5\n3 2 1 0 9 0.5 0.5 0.5\n";
  const Mesh mesh = read_mesh(folder.write("a.ply", text));
  EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 0}}));
  ASSERT_EQ(mesh.warnings.size(), 2u);
  EXPECT_TRUE(contains(mesh.warnings[0], "line 3 of the header, which begins with 'Created'"));
  EXPECT_TRUE(contains(mesh.warnings[1], "left out in 2 lines"));
}

// Nine bytes of colours could be a polygon of nine of the mesh's vertices, or of fewer and a number of vertices.
TEST(MeshFile, TakesUndeclaredValuesForNoFaces) {
  const TemporaryFolder folder;
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 4 0 1 2 3\n3 2 1 3 4 0 1 2 3\n";
  const Mesh mesh = read_mesh(folder.write("a.ply", text));
  EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  ASSERT_EQ(mesh.warnings.size(), 1u);
  EXPECT_TRUE(contains(mesh.warnings[0], "left out in 2 lines"));
}

// As many lines as elements, which are not theirs.
TEST(MeshFile, ReadsValuesOnAnyLines) {
  const TemporaryFolder folder;
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0\n0 1 0 0\n0 1 0 3\n0 1 2\n";
  EXPECT_EQ(read_mesh(folder.write("a.ply", text)).faces, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(MeshFile, NamesWhatGitLfsLeft) {
  const TemporaryFolder folder;
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
  EXPECT_TRUE(
      contains(input_error([&] { read_mesh(folder.write("a.ply", pointer)); }), "a.ply: is a pointer that Git LFS"));
}

TEST(MeshFile, SplitsPolygonsAsFans) {
  const TemporaryFolder folder;
  const std::vector<Triangle> fan{{4, 3, 2}, {4, 2, 1}, {4, 1, 0}, {0, 1, 2}};
  const std::string vertices = "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 2 0\n";
  EXPECT_EQ(read_mesh(folder.write("a.ply",
                                   "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                                   "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
                                   "end_header\n" +
                                       vertices + "5 4 3 2 1 0\n3 0 1 2\n"))
                .faces,
            fan);
  EXPECT_EQ(read_mesh(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf 5 4 3 2 1\nf 1 2 3")).faces,
            fan);
}

// A triangle, a square, a triangle, a pentagon: the map back begins with the square and covers all.
TEST(MeshFile, MapsTrianglesBackToTheFilesFaces) {
  const TemporaryFolder folder;
  const std::string vertices = "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 2 0\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list ushort uint vertex_indices\nend_header\n" +
      vertices + "3 0 1 2\n4 0 1 2 3\n3 0 1 3\n5 0 1 2 3 4\n";
  const std::string obj =
      "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3\ng x\nf 1 2 3 4\nl 1 2\nf 1 2 4\nf 1/1 2/2 3/3 "
      "4/4 5/5\n";
  for (const std::string& text : {ply, obj}) {
    const Mesh mesh = read_mesh(folder.write("a", text));
    EXPECT_EQ(mesh.faces.size(), 7);
    EXPECT_EQ(mesh.source_face, (std::vector<std::uint32_t>{0, 1, 1, 2, 3, 3, 3}));
  }
  EXPECT_TRUE(read_mesh(folder.write("a", obj_text())).source_face.empty());
}

// An arrowhead at UTM coordinates. From some corners a fan would turn a triangle over:
//   3
//   |.
//   | 2 .       2 is the concave corner
//   |.    .
//   0-------1
TEST(MeshFile, CutsConcavePolygonsWithoutTurningATriangleOver) {
  const TemporaryFolder folder;
  const auto area = [](const Mesh& mesh, const Triangle& f) {
    const WorldPoint &a = mesh.positions[f[0]], &b = mesh.positions[f[1]], &c = mesh.positions[f[2]];
    return ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
  };
  // The concave corner at every position of the loop.
  const double x[] = {0, 4, 1, 0}, y[] = {0, 0, 1, 4};  // area 4
  for (int shift = 0; shift < 4; ++shift) {
    std::string text;
    for (int i = 0; i < 4; ++i)
      text += "v " + exact(500000.25 + x[(i + shift) % 4]) + " " + exact(5000000.5 + y[(i + shift) % 4]) + " 7\n";
    const Mesh mesh = read_mesh(folder.write("a.obj", text + "f 1 2 3 4\n"));
    ASSERT_EQ(mesh.faces.size(), 2);
    EXPECT_GT(area(mesh, mesh.faces[0]), 0) << shift;
    EXPECT_GT(area(mesh, mesh.faces[1]), 0) << shift;
    EXPECT_DOUBLE_EQ(area(mesh, mesh.faces[0]) + area(mesh, mesh.faces[1]), 4) << shift;
  }
  // A comb of nine corners.
  const Mesh comb = read_mesh(folder.write("b.obj",
                                           "v 0 0 0\nv 6 0 0\nv 6 3 0\nv 5 1 0\nv 4 3 0\nv 3 1 0\nv 2 3 0\nv "
                                           "1 1 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8 9\n"));
  ASSERT_EQ(comb.faces.size(), 7);
  double sum = 0;
  for (const Triangle& face : comb.faces) {
    EXPECT_GT(area(comb, face), 0);
    sum += area(comb, face);
  }
  EXPECT_DOUBLE_EQ(sum, 18 - 3 * 2);
  // A bow tie has no ears to cut: the fan stays, every corner is named.
  const Mesh tie = read_mesh(folder.write("c.obj", "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 1 0\nf 1 2 3 4\n"));
  EXPECT_EQ(tie.faces.size(), 2);
  EXPECT_TRUE(contains(tie.warnings.at(0), "1 polygons cross themselves"));
  // A square with a hole that is joined to its outline, as programs of buildings write it: from every corner on, with the
  // doubled corners as the same vertices and as vertices of their own.
  for (const std::string loop : {"1 2 3 4 1 5 6 7 8 5", "1 2 3 4 9 10 6 7 8 5"})
    for (int shift = 0; shift < 10; ++shift) {
      std::istringstream words(loop);
      std::vector<std::string> corners{std::istream_iterator<std::string>(words), {}};
      std::rotate(corners.begin(), corners.begin() + shift, corners.end());
      std::string face = "f";
      for (const std::string& corner : corners) face += " " + corner;
      const Mesh key = read_mesh(folder.write("d.obj",
                                              "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 4 4 0\nv 4 6 0\nv 6 6 0\n"
                                              "v 6 4 0\nv 0 0 0\nv 4 4 0\n" +
                                                  face + "\n"));
      ASSERT_EQ(key.faces.size(), 8);
      double whole = 0;
      for (const Triangle& triangle : key.faces) {
        EXPECT_GE(area(key, triangle), 0) << loop << shift;
        whole += area(key, triangle);
      }
      EXPECT_DOUBLE_EQ(whole, 96) << loop << shift;
      EXPECT_TRUE(key.warnings.empty());
    }
}

TEST(MeshFlaws, CountsWhatIsOddAndKeepsIt) {
  Mesh mesh;
  mesh.positions = kPositions;
  mesh.faces = kFaces;
  mesh.positions.push_back(kPositions[0]);
  mesh.positions.push_back({0.1, 0.2, 1.3});
  mesh.positions.push_back({0.1, 0.2, 9.3});
  mesh.faces.push_back({2, 0, 1});  // an earlier face's vertices in another order
  mesh.faces.push_back({0, 6, 7});  // in a line
  const MeshFlaws flaws = mesh_flaws(mesh);
  EXPECT_EQ(flaws.degenerate_faces, 1);
  EXPECT_EQ(flaws.flat_faces, 1);
  EXPECT_EQ(flaws.duplicate_faces, 2);
  EXPECT_EQ(flaws.unreferenced_vertices, 2);
  EXPECT_EQ(flaws.duplicate_vertices, 1);
}

TEST(MeshFile, ReadsObjPeculiarities) {
  const TemporaryFolder folder;
  const Mesh mesh = read_mesh(folder.write("a.obj",
                                           "# a comment ends in a backslash \\\n"
                                           "v 0 0 0 0.5 0.5 0.5\r\n"
                                           "  v\t1 0 0 1.0\n"
                                           "mtllib C:\\folder\\\n"
                                           "v 0 \\ \n  1 \\\t\r\n 0\n"
                                           "vp 1 2\nl 1 2\np 1\n"
                                           "f -3 -2 -1 # counted back\n"
                                           "v 0 0 1\n"
                                           "f -1/-1 \\\n 1/5 2/\n"
                                           "f 1 2 5\n"
                                           "v 7 7 7\n"));
  EXPECT_EQ(mesh.positions, (std::vector<WorldPoint>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {7, 7, 7}}));
  EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {3, 0, 1}, {0, 1, 4}}));
}

TEST(MeshFile, SkipsTheMarkBeforeUtf8) {
  const TemporaryFolder folder;
  const std::string mark = "\xEF\xBB\xBF";
  for (const std::string& text :
       {std::string("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\n"), ascii_ply(), binary_ply(false)}) {
    const Mesh plain = read_mesh(folder.write("plain", text)), marked = read_mesh(folder.write("m", mark + text));
    EXPECT_EQ(marked.positions, plain.positions);
    EXPECT_EQ(marked.faces, plain.faces);
  }
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.write("m", mark)); }), "is empty"));
}

// Squares of differences of coordinates have to fit in floats.
TEST(MeshFile, LeavesFacesWithoutAPlaceThatUseCoordinatesBeyondSinglePrecision) {
  const TemporaryFolder folder;
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", faces = "f 1 2 3\nf 1 3 5\nf 5 5 5\nf 1 3 4\n";
  for (const std::string value : {"1.1e18", "-1e60", "1e308", "nan", "-inf"}) {
    const Mesh mesh = read_mesh(folder.write("a", square + "v 1 " + value + " 0\n" + faces));
    EXPECT_EQ(mesh.positions.size(), 5u);
    EXPECT_EQ(mesh.positions[4], mesh.positions[0]) << "the extent stays";
    EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 0}, {4, 4, 4}, {0, 2, 3}}));
    ASSERT_EQ(mesh.warnings.size(), 1u);
    EXPECT_TRUE(contains(mesh.warnings[0], "1 vertices have no place, the first vertex 4, "));
    EXPECT_TRUE(contains(mesh.warnings[0], ": the 2 faces that use them are kept without an area"));
    const bool finite = value.back() != 'n' && value.back() != 'f';
    EXPECT_EQ(contains(mesh.warnings[0], "is above 1e+18"), finite) << mesh.warnings[0];
  }
  EXPECT_EQ(read_mesh(folder.write("a", "v 0 0 1e18\nv 1 0 0\nv -1e18 0 0\nf 1 2 3\n")).positions[0].z, 1e18);
}

TEST(MeshFile, LeavesOutVerticesWithoutAPlaceThatNoFaceUses) {
  const TemporaryFolder folder;
  const Mesh mesh = read_mesh(folder.write("a", "v 0 0 0\nv 0 nan 0\nv 1 0 0\nv 1 1 0\nv inf 0 0\nf 1 3 4\n"));
  EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 2, 3}}));
  EXPECT_EQ(mesh.positions.size(), 5u);
  EXPECT_EQ(mesh.warnings,
            (std::vector<std::string>{"2 vertices that no face uses have no place, the first vertex 1, as a "
                                      "coordinate is not finite: they are left out of consideration"}));
}

TEST(MeshFile, SaysWhichVertexHasNoPlaceWhereNoFaceIsLeft) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    return input_error([&] { read_mesh(folder.write("a", text)); });
  };
  EXPECT_TRUE(
      contains(refusal("v 0 0 0\nv 1 0 0\n\nv 1 nan 0\nf 1 2 3\n"),
               "a: has no face with a place: 1 vertices have no place, the first vertex 2, as a coordinate is not "
               "finite"));
  EXPECT_TRUE(
      contains(refusal("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1e19 0\n3 0 1 2\n"), "whose coordinate 1e+19 is above 1e+18"));
  EXPECT_TRUE(contains(refusal("solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex nan 0 0\nvertex 1 1 0\n"
                               "endloop\nendfacet\nendsolid s\n"),
                       "the first vertex 1, "));
  EXPECT_TRUE(contains(refusal(replaced(ascii_ply(), "255 " + exact(0.1), "255 nan")), "the first vertex 0, "));
  const Mesh ascii = read_mesh(folder.write("a", replaced(ascii_ply(), "255 -0 ", "255 1e999 ")));
  EXPECT_TRUE(contains(ascii.warnings.at(0), "the first vertex 3, as a coordinate is not finite"));
  std::string bytes = binary_ply(true);
  bytes.replace(bytes.find(bytes_of(-0.0, true)), 8, bytes_of(1e300, true));
  EXPECT_TRUE(
      contains(read_mesh(folder.write("a", bytes)).warnings.at(0), "the first vertex 3, whose coordinate 1e+300"));
}

TEST(MeshFile, CallsAPointCloudOne) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    return input_error([&] { read_mesh(folder.write("a", text)); });
  };
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 "
      "0\n";
  EXPECT_TRUE(
      contains(refusal(ply), "a: is a point cloud, 1 points without faces; make a mesh of it first, by Poisson"));
  EXPECT_TRUE(contains(refusal("v 0 0 0\nv 1 0 0\n"), "is a point cloud, 2 points"));
  EXPECT_TRUE(contains(refusal("OFF\n1 0 0\n0 0 0\n"), "is a point cloud, 1 points"));
  EXPECT_TRUE(contains(refusal(std::string("LASF\0\0", 6)), "is a point cloud"));
  EXPECT_TRUE(contains(refusal("# .PCD v0.7 - Point Cloud Data\nVERSION 0.7\n"), "is a point cloud"));
  EXPECT_TRUE(contains(refusal(replaced(replaced(ply, "vertex 1", "vertex 0"), "0 0 0\n", "")),
                       "is empty: it has no vertices and no faces"));
  EXPECT_TRUE(contains(refusal("v 0 0 0\nv 1 0 0\nf 1 2\n"), "has no faces of three or more vertices"));
}

// Cut anywhere, a file is refused; only where nothing but a closing blank is lost may it be read.
void expect_every_cut_refused(const std::string& bytes, std::size_t harmless) {
  const TemporaryFolder folder;
  for (std::size_t size = 0; size + harmless < bytes.size(); ++size)
    EXPECT_THROW(read_mesh(folder.write("cut", bytes.substr(0, size))), InputError) << size << " bytes";
}

TEST(MeshFile, RefusesPlyCutAtEveryByte) {
  expect_every_cut_refused(binary_ply(false), 0);
  expect_every_cut_refused(binary_ply(true), 0);
  expect_every_cut_refused(ascii_ply(), 2);  // "-7\n" may lose its line end, and then "-7" reads as "-"
  expect_every_cut_refused(ascii_ply("\r\n"), 3);
}

// OBJ announces no counts: a cut is a smaller mesh or an error, never anything else.
TEST(MeshFile, ReadsOrRefusesObjCutAtEveryByte) {
  const TemporaryFolder folder;
  const std::string bytes = obj_text();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    try {
      const Mesh mesh = read_mesh(folder.write("cut", bytes.substr(0, size)));
      ASSERT_FALSE(mesh.faces.empty());
      for (const Triangle& face : mesh.faces)
        for (const std::uint32_t v : face) ASSERT_LT(v, mesh.positions.size());
    } catch (const InputError&) {
    }
  }
}

// One byte changed anywhere: a mesh whose faces are in range, or an InputError.
TEST(MeshFile, SurvivesEveryByteChanged) {
  const TemporaryFolder folder;
  std::mt19937 random(7);
  for (const std::string& good : {ascii_ply(), binary_ply(false), binary_ply(true), obj_text()})
    for (std::size_t at = 0; at < good.size(); ++at) {
      std::string bytes = good;
      bytes[at] = static_cast<char>(random());
      try {
        const Mesh mesh = read_mesh(folder.write("changed", bytes));
        for (const Triangle& face : mesh.faces)
          for (const std::uint32_t v : face) ASSERT_LT(v, mesh.positions.size());
        for (const WorldPoint& p : mesh.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
      } catch (const InputError&) {
      }
    }
}

TEST(MeshFile, RefusesHostileCountsWithoutAllocatingThem) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& bytes) {
    return input_error([&] { read_mesh(folder.write("a.ply", bytes)); });
  };
  for (const std::string count : {"1000000000000000000", "18446744073709551615", "4294967295"})
    for (const std::string& good : {ascii_ply(), binary_ply(false)})
      for (const std::string element : {"element vertex 5", "element face 4"})
        EXPECT_TRUE(contains(error(replaced(good, element, element.substr(0, element.size() - 1) + count)), count));
  EXPECT_TRUE(contains(error(replaced(ascii_ply(), "vertex 5", "vertex 99999999999999999999")), "line 5"));
  EXPECT_TRUE(contains(error(replaced(ascii_ply(), "vertex 5", "vertex -1")), "line 5"));
  // A list that claims four billion items.
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "element face 1\nproperty list uint int vertex_indices\nend_header\n";
  EXPECT_TRUE(contains(error(header + std::string(36, '\0') + bytes_of(0xFFFFFFFFu) + std::string(40, '\0')), "ends"));
  // Skipped elements of no size must not be counted up to.
  EXPECT_TRUE(contains(error("ply\nformat ascii 1.0\nelement nothing 1000000000000000000\nend_header\n"), "no faces"));
}

TEST(MeshFile, RefusesWhatIsNoMeshAndSaysWhere) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& bytes) {
    return input_error([&] { read_mesh(folder.write("m.ply", bytes)); });
  };
  const std::string ply = ascii_ply();
  EXPECT_TRUE(contains(error(""), "m.ply: is empty"));
  EXPECT_TRUE(contains(error("ply"), "line 1: the file ends inside the header"));
  EXPECT_TRUE(contains(error(replaced(ply, "ascii", "utf8")), "line 2: expected format"));
  EXPECT_TRUE(contains(error(replaced(ply, "uchar red", "colour red")), "line 6: expected a property type"));
  EXPECT_TRUE(contains(error(replaced(ply, "list uchar int", "list float int")), "integer type"));
  EXPECT_TRUE(contains(error(replaced(ply, "double y", "double why")), "no scalar property 'y'"));
  EXPECT_TRUE(contains(error(replaced(ply, "vertex_indices", "corners")), "'vertex_indices'"));
  EXPECT_TRUE(contains(error(replaced(ply, "255 -0 ", "255 o ")), "line 18: expected a number, found 'o'"));
  EXPECT_TRUE(contains(error(replaced(ply, "3 0 2 3", "3 0 2 5")), "face 1: refers to vertex 5"));
  EXPECT_TRUE(contains(error(replaced(ply, "3 0 2 3", "3 0 2 -1")), "face 1: refers to vertex -1"));
  EXPECT_TRUE(contains(error(replaced(ply, "3 0 2 3", "-1 0 2")), "face 1: has -1 vertices"));
  EXPECT_TRUE(contains(error(replaced(ply, "3 0 2 3", "3 0 2 1.5")), "line 21: expected an integer, found '1.5'"));
  EXPECT_TRUE(contains(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                             "property float z\nend_header\n0 0 0\n"),
                       "is a point cloud"));
  EXPECT_TRUE(contains(error(replaced(replaced(ply, "element face 4", "element tristrips 4"), "vertex_indices", "v")),
                       "element 'tristrips' has no list of integers"));
  EXPECT_TRUE(contains(error("# nothing\n"), "is no mesh that can be read"));
  EXPECT_TRUE(contains(error(std::string(500, '\0')), "is no mesh that can be read"));
  EXPECT_TRUE(contains(error("v 0 0\n"), "line 1: a vertex needs three coordinates"));
  EXPECT_TRUE(contains(error("v 0 0 0\nv 1 0 0\nf 1 2\n"), "has no faces"));
  EXPECT_TRUE(contains(error("v 0 0 0\nf 1 1 2\nf 1 1 1\n"), "line 2: vertex 2"));
  EXPECT_TRUE(contains(error("v 0 0 0\nf 1 1 0\n"), "line 2: vertex 0"));
  EXPECT_TRUE(contains(error("v 0 0 0\nf 1 1 -2\n"), "line 2: vertex -2"));
  EXPECT_TRUE(contains(error("v 0 0 0\nf 1 1 9999999999\n"), "line 2: vertex 9999999999"));
  EXPECT_TRUE(contains(error("v 0 0 0\nf 1 1 x/1\n"), "line 2: 'x/1'"));
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.path() / "absent.ply"); }), "No such file"));
}

// A triangle, a quad and a triangle behind two triangles: polygons 0, 1, then 2, 3, 3, 4; in either order.
TEST(AppendMesh, CountsVerticesFacesAndPolygonsOn) {
  const Mesh plain{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}}, {}};
  const Mesh cut{
      {{5, 0, 0}, {6, 0, 0}, {6, 1, 0}, {5, 1, 0}}, {{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {3, 2, 1}}, {0, 1, 1, 2}};
  Mesh all;
  append_mesh(all, plain);
  EXPECT_TRUE(all.source_face.empty());
  append_mesh(all, cut);
  EXPECT_EQ(all.positions.size(), 8u);
  EXPECT_EQ(all.positions[4], cut.positions[0]);
  EXPECT_EQ(all.faces[4], (Triangle{4, 6, 7}));
  EXPECT_EQ(all.source_face, (std::vector<std::uint32_t>{0, 1, 2, 3, 3, 4}));
  Mesh turned = cut;
  append_mesh(turned, plain);
  EXPECT_EQ(turned.faces[5], (Triangle{5, 7, 6}));
  EXPECT_EQ(turned.source_face, (std::vector<std::uint32_t>{0, 1, 1, 2, 3, 4}));
  append_mesh(turned, cut);
  EXPECT_EQ(turned.source_face, (std::vector<std::uint32_t>{0, 1, 1, 2, 3, 4, 5, 6, 6, 7}));
}

}  // namespace
}  // namespace gpvc::io
