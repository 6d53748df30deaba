// STL, OFF and glTF as meshes: what they say of geometry, and what is refused.
#include <cctype>
#include <cmath>

#include "io/mesh.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "tests/atlas/strip_model.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::bytes_of;
using test::contains;
using test::input_error;
using test::replaced;
using test::TemporaryFolder;

// A quad of two triangles, which share the corners 0 and 2.
const std::vector<WorldPoint> kQuad{{0, 0, 0.5}, {2, 0, 0}, {2, 3, 0}, {0, 3, 1}};
const std::vector<Triangle> kHalves{{0, 1, 2}, {0, 2, 3}};

std::string binary_stl(const std::string& header = "made by hand") {
  std::string bytes = header + std::string(80 - header.size(), ' ') + bytes_of<std::uint32_t>(2);
  for (const Triangle& t : kHalves) {
    bytes += bytes_of(0.f) + bytes_of(0.f) + bytes_of(1.f);
    for (const std::uint32_t v : t)
      for (const double x : {kQuad[v].x, kQuad[v].y, kQuad[v].z}) bytes += bytes_of(static_cast<float>(x));
    bytes += bytes_of<std::uint16_t>(7);
  }
  return bytes;
}

constexpr const char* kAsciiStl =
    "solid a name\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0.5\n      vertex 2 0 0\n      vertex 2 3 "
    "0\n    endloop\n  endfacet\r\n  FACET normal 0 0 1\n OUTER LOOP\n VERTEX 0 0 5e-1\n VERTEX 2 3 -0\n VERTEX 0 3 "
    "1\n "
    "ENDLOOP\n ENDFACET\nendsolid\n";

TEST(Stl, CornersAtOnePlaceAreOneVertex) {
  const TemporaryFolder folder;
  // Some programs begin binary files with the word of the ASCII ones.
  std::string capitals = " \n" + std::string(kAsciiStl);
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const std::string& bytes :
       {binary_stl(), binary_stl("solid facet"), binary_stl() + "\r\n", std::string(kAsciiStl), capitals}) {
    const Mesh mesh = read_mesh(folder.write("a.stl", bytes));
    EXPECT_EQ(mesh.positions, kQuad);
    EXPECT_EQ(mesh.faces, kHalves);
  }
}

TEST(Stl, RefusesWhatIsCutOff) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& bytes) {
    return input_error([&] { read_mesh(folder.write("a.stl", bytes)); });
  };
  const std::string ascii = kAsciiStl;
  EXPECT_TRUE(contains(error(binary_stl().substr(0, 150)), "is no mesh that can be read"));
  EXPECT_TRUE(contains(error(ascii.substr(0, ascii.find("VERTEX 0 3"))), "line 13: ends within a triangle"));
  EXPECT_TRUE(contains(error(replaced(ascii, "2 0 0", "2 zero 0")), "line 5: expected three coordinates"));
  EXPECT_TRUE(contains(error(replaced(ascii, "vertex 2 0 0\n", "\n")), "line 7: expected three vertices"));
  EXPECT_TRUE(contains(error("solid\nfacet\nendsolid\n"), "is empty: it has no vertices and no faces"));
}

TEST(Off, ReadsPolygonsColoursAndComments) {
  const TemporaryFolder folder;
  const Mesh plain =
      read_mesh(folder.write("a.off",
                             "# a comment, or two\n\n#\nOFF\n# made by hand\n4 1 0\n0 0 0.5\n2 0 0 # the second\n\n2 3 "
                             "0\n0 3 1\n4 0 1 2 3 255 0 0\n"));
  EXPECT_EQ(plain.positions, kQuad);
  EXPECT_EQ(plain.faces, kHalves);
  EXPECT_EQ(plain.source_face, (std::vector<std::uint32_t>{0, 0}));
  const Mesh coloured =
      read_mesh(folder.write("b.off",
                             "COFF 4 2 5\r\n0 0 0.5 255 0 0 255\r\n2 0 0 0 0 0 0\r\n2 3 0 1 1 1 1\r\n0 3 1 9 9 9 9\r\n"
                             "3 0 1 2\r\n3 0 2 3\r\n"));
  EXPECT_EQ(coloured.positions, kQuad);
  EXPECT_EQ(coloured.faces, kHalves);
  EXPECT_TRUE(coloured.source_face.empty());
}

TEST(Off, NamesTheLineOfWhatIsWrong) {
  const TemporaryFolder folder;
  const std::string good = "OFF\n4 2 0\n0 0 0.5\n2 0 0\n2 3 0\n0 3 1\n3 0 1 2\n3 0 2 3\n";
  const auto error = [&](const std::string& bytes) {
    return input_error([&] { read_mesh(folder.write("a.off", bytes)); });
  };
  EXPECT_TRUE(contains(error(replaced(good, "OFF", "4OFF")), "line 1: is in 4OFF"));
  EXPECT_TRUE(contains(error(replaced(good, "OFF", "OFF BINARY")), "line 1: is binary"));
  EXPECT_TRUE(contains(error(replaced(good, "4 2 0", "4 x 0")), "line 2: expected the numbers of vertices"));
  EXPECT_TRUE(contains(error(replaced(good, "2 3 0", "2 3")), "line 5: expected the coordinates"));
  EXPECT_TRUE(contains(error(replaced(good, "3 0 2 3", "3 0 2 4")), "line 8: expected 3 numbers of vertices below 4"));
  EXPECT_TRUE(contains(error(replaced(good, "3 0 2 3", "4 0 2 3")), "line 8: expected 4 numbers"));
  EXPECT_TRUE(contains(error(replaced(good, "3 0 2 3\n", "")), "line 7: ends before its last face"));
}

// Two triangles in a list of indices, behind two nodes: the outer moves by (10, 20, 30), the inner turns by a quarter
// about x, which takes y to z, doubles, and holds the mesh.
std::string gltf_text(const std::string& mode, const std::string& more = "") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[1]}],
"nodes":[{"mesh":0,"rotation":[0.70710678118654757,0,0,0.70710678118654757],"scale":[2,2,2]},
{"children":[0],"translation":[10,20,30]},{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1)" +
         mode + R"(}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[2,3,1]},
{"bufferView":1,"componentType":5123,"count":4,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":8}],
"buffers":[{"uri":"a.bin","byteLength":56}])" +
         more + "}";
}

std::string gltf_buffer() {
  std::string bytes;
  for (const WorldPoint& p : kQuad)
    for (const double x : {p.x, p.y, p.z}) bytes += bytes_of(static_cast<float>(x));
  for (const int v : {1, 2, 0, 3}) bytes += bytes_of(static_cast<std::uint16_t>(v));
  return bytes;
}

TEST(GltfMesh, NodesPlaceTheMeshAndStripsTurnEverySecondTriangle) {
  const TemporaryFolder folder;
  folder.write("a.bin", gltf_buffer());
  const Mesh strip = read_mesh(folder.write("a.gltf", gltf_text(",\"mode\":5")));
  ASSERT_EQ(strip.positions.size(), 4);
  for (std::size_t v = 0; v < 4; ++v) {
    EXPECT_NEAR(strip.positions[v].x, 10 + 2 * kQuad[v].x, 1e-12);
    EXPECT_NEAR(strip.positions[v].y, 20 - 2 * kQuad[v].z, 1e-12);
    EXPECT_NEAR(strip.positions[v].z, 30 + 2 * kQuad[v].y, 1e-12);
  }
  EXPECT_EQ(strip.faces, (std::vector<Triangle>{{1, 2, 0}, {0, 2, 3}}));
  const Mesh fan = read_mesh(folder.write("b.gltf", gltf_text(",\"mode\":6")));
  EXPECT_EQ(fan.faces, (std::vector<Triangle>{{1, 2, 0}, {1, 0, 3}}));
  // A node that mirrors.
  const Mesh mirrored =
      read_mesh(folder.write("c.gltf", replaced(gltf_text(""), "\"scale\":[2,2,2]", "\"scale\":[-1,1,1]")));
  EXPECT_EQ(mirrored.faces, (std::vector<Triangle>{{1, 0, 2}}));
}

TEST(GltfMesh, RefusesCyclesPackedGeometryAndBadIndices) {
  const TemporaryFolder folder;
  folder.write("a.bin", gltf_buffer());
  const auto error = [&](const std::string& text) {
    return input_error([&] { read_mesh(folder.write("a.gltf", text)); });
  };
  EXPECT_TRUE(
      contains(error(replaced(gltf_text(""), "\"children\":[0]", "\"children\":[1]")), "node 1: has two parents"));
  EXPECT_TRUE(contains(error(gltf_text("", R"(,"extensionsRequired":["KHR_draco_mesh_compression"])")),
                       "packs its geometry by KHR_draco_mesh_compression"));
  // As programs write it: without buffers for what is packed.
  EXPECT_TRUE(contains(error(replaced(gltf_text("", R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"),
                                      "\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"",
                                      "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"")),
                       "packs its geometry by KHR_draco_mesh_compression"));
  EXPECT_TRUE(contains(error(gltf_text("", R"(,"extensionsRequired":["CESIUM_RTC"])")),
                       "requires the extension 'CESIUM_RTC', which is not supported"));
  EXPECT_EQ(
      read_mesh(folder.write("b.gltf", gltf_text("", R"(,"extensionsRequired":["KHR_materials_unlit"])"))).faces.size(),
      1);
  EXPECT_TRUE(contains(error(replaced(gltf_text(""), "\"type\":\"VEC3\"",
                                      R"("sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},)"
                                      R"("values":{"bufferView":0}},"type":"VEC3")")),
                       "accessor 0: is sparse"));
  EXPECT_TRUE(contains(error(replaced(gltf_text(""), "\"count\":4,\"type\":\"VEC3\"", "\"count\":2,\"type\":\"VEC3\"")),
                       "triangle 0: vertex index out of range"));
  EXPECT_TRUE(contains(error(gltf_text(",\"mode\":1")), "has no faces"));
}

TEST(GltfMesh, TexturedModelsOfOtherProgramsLieWhereTheirNodesSay) {
  const TemporaryFolder folder;
  folder.write("a.bin", gltf_buffer());
  const std::string moved = gltf_text("");
  for (const std::string& text : {moved, replaced(moved, "\"scale\":[2,2,2]", "\"scale\":[-1,1,1]"),
                                  replaced(moved, "[{\"nodes\":[1]}]", "[{\"nodes\":[2,1]}]")}) {
    const auto file = folder.write("a.gltf", text);
    const Mesh mesh = read_mesh(file);
    const LoadedModel model = read_textured_model(file);
    EXPECT_EQ(model.offset, WorldPoint{});
    ASSERT_EQ(model.mesh.faces.size(), mesh.faces.size());
    EXPECT_EQ(model.model.face_texcoords, model.mesh.faces);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_EQ(model.mesh.positions[model.mesh.faces[f][c]], mesh.positions[mesh.faces[f][c]]);
  }
}

// Our own models keep the axes and the offset of the mesh that was textured, and their seams close again.
TEST(GltfMesh, OwnModelsLieWhereTheirMeshLay) {
  const test::StripModel strip;
  const auto file = strip.folder.path() / "m.glb";
  const WorldPoint offset{500000, 5400000, 0};
  test::write_glb(file, strip.model, strip.pages, {offset, UpAxis::pos_z});
  const Mesh mesh = read_mesh(file);
  const std::vector<WorldPoint>& before = strip.model.mesh->positions;
  std::size_t textured = 0;
  for (const std::uint32_t page : strip.model.face_page) textured += page != kNoPage;
  EXPECT_EQ(mesh.faces.size(), textured);
  EXPECT_LE(mesh.positions.size(), before.size());
  for (const WorldPoint& p : mesh.positions) {
    double nearest = 1e9;
    for (const WorldPoint& q : before) nearest = std::min(nearest, std::hypot(p.x - q.x, p.y - q.y, p.z - q.z));
    EXPECT_LT(nearest, 1e-3);
  }
  const LoadedModel model = read_textured_model(file);
  EXPECT_EQ(model.offset, offset);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t c = 0; c < 3; ++c) {
      const WorldPoint& local = model.mesh.positions[model.mesh.faces[f][c]];
      EXPECT_EQ(local.x, static_cast<double>(static_cast<float>(local.x))) << "as the file holds it";
      EXPECT_EQ(local + offset, mesh.positions[mesh.faces[f][c]]);
    }
}

}  // namespace
}  // namespace gpvc::io
