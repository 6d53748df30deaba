// What glTF and OBJ hold besides textured triangles: normals, files beside, faces without a page.
#include <tiny_gltf.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <cmath>

#include "io/mesh.h"
#include "io/meshes/normals.h"
#include "tests/atlas/strip_model.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::StripModel;
using test::write_glb;

tinygltf::Model load(const std::filesystem::path& file) {
  tinygltf::Model gltf;
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  EXPECT_TRUE(file.extension() == ".glb" ? loader.LoadBinaryFromFile(&gltf, &error, &warning, file.string())
                                         : loader.LoadASCIIFromFile(&gltf, &error, &warning, file.string()))
      << error;
  EXPECT_EQ(error + warning, "");
  return gltf;
}

std::vector<float> floats(const tinygltf::Model& gltf, int accessor_number) {
  const tinygltf::Accessor& accessor = gltf.accessors.at(static_cast<std::size_t>(accessor_number));
  const tinygltf::BufferView& view = gltf.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  const auto& buffer = gltf.buffers.at(static_cast<std::size_t>(view.buffer)).data;
  std::vector<float> values(view.byteLength / sizeof(float));
  std::memcpy(values.data(), buffer.data() + view.byteOffset, view.byteLength);
  return values;
}

// Two slopes of a roof, the left one cut into one triangle at the ridge's near end, the right one into two.
//   2---3
//  /|\  |\      ridge 0-2 (near, far) at z = 1, eaves 1 and 3, 4 at z = 0
Mesh roof() {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {-1, 0, 0}, {0, 2, 1}, {1, 0, 0}, {1, 2, 0}};
  mesh.faces = {{0, 2, 1}, {0, 3, 4}, {0, 4, 2}};
  return mesh;
}

TEST(VertexNormals, WeighFacesByTheirAngles) {
  const auto normals = vertex_normals(roof());
  const double h = std::sqrt(0.5);
  // At the ridge's near end: a right angle of the left slope, and of the right one in two parts.
  EXPECT_NEAR(normals[0][0], 0, 1e-6);
  EXPECT_NEAR(normals[0][2], 1, 1e-6);
  for (const std::size_t right : {3u, 4u}) {
    EXPECT_NEAR(normals[right][0], h, 1e-6);
    EXPECT_NEAR(normals[right][1], 0, 1e-6);
    EXPECT_NEAR(normals[right][2], h, 1e-6);
  }
  EXPECT_NEAR(normals[1][0], -h, 1e-6);
}

TEST(VertexNormals, AreUnitVectorsWhateverTheMesh) {
  Mesh mesh = roof();
  mesh.positions.push_back({5, 5, 5});  // in no face
  mesh.positions.push_back({9, 9, 9});  // in a face without area
  mesh.faces.push_back({6, 6, 0});
  mesh.faces.insert(mesh.faces.end(), {{1, 2, 0}});  // the left slope's back: nothing is left of the sum at 1
  mesh.faces.insert(mesh.faces.end(), {{0, 2, 3}, {0, 2, 4}});  // more faces on the ridge
  for (WorldPoint& p : mesh.positions) p = {p.x + 500000, p.y + 5400000, p.z};
  for (const auto& n : vertex_normals(mesh)) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);
}

TEST(WriteGltf, GivesEveryVertexItsNormal) {
  const StripModel test;
  const auto normals = vertex_normals(test.mesh);
  ModelOptions options;
  options.normals = true;
  const auto faces = write_glb(test.folder.path() / "m.glb", test.model, test.pages, options);
  const tinygltf::Model gltf = load(test.folder.path() / "m.glb");
  std::size_t triangle = 0;
  for (const tinygltf::Primitive& primitive : gltf.meshes[0].primitives) {
    const auto stored = floats(gltf, primitive.attributes.at("NORMAL"));
    const auto indices_view = gltf.accessors[static_cast<std::size_t>(primitive.indices)];
    const auto& view = gltf.bufferViews[static_cast<std::size_t>(indices_view.bufferView)];
    std::vector<std::uint32_t> indices(indices_view.count);
    std::memcpy(indices.data(), gltf.buffers[0].data.data() + view.byteOffset, view.byteLength);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const std::uint32_t position = test.mesh.faces[index(faces[triangle + i / 3])][i % 3];
      for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(stored[3 * indices[i] + axis], normals[position][axis]);
    }
    triangle += indices.size() / 3;
  }
  EXPECT_EQ(triangle, 4u);
}

// The bytes of a buffer view.
std::string bytes_of(const tinygltf::Model& gltf, const tinygltf::Value& view_number) {
  const tinygltf::BufferView& view = gltf.bufferViews.at(static_cast<std::size_t>(view_number.GetNumberAsInt()));
  const auto& buffer = gltf.buffers.at(static_cast<std::size_t>(view.buffer)).data;
  return {reinterpret_cast<const char*>(buffer.data()) + view.byteOffset, view.byteLength};
}

// Faces 2 and 3 share vertices on page 1, but not their photo.
TEST(WriteGltf, FacesTellTheirPhoto) {
  const StripModel test;
  const PhotoTable photos{{0, 1, 2, 0}, {"", "DJI_0026.JPG", "\xC3\x9C.jpg"}, {0, 0.25f, 0.5f}};
  for (const GltfContainer container : {GltfContainer::glb, GltfContainer::files}) {
    const auto [file, buffers, faces, size] =
        write_gltf(test.folder.path() / "m", container, test.model, test.pages, {{500000, 5400000, 0}}, &photos);
    const tinygltf::Model gltf = load(file);
    std::size_t triangle = 0;
    for (const tinygltf::Primitive& primitive : gltf.meshes[0].primitives) {
      const tinygltf::Value& features = primitive.extensions.at("EXT_mesh_features").Get("featureIds").Get(0);
      EXPECT_EQ(features.Get("featureCount").GetNumberAsInt(), 3);
      EXPECT_EQ(features.Get("propertyTable").GetNumberAsInt(), 0);
      const auto rows = floats(gltf, primitive.attributes.at("_FEATURE_ID_0"));
      const auto& accessor = gltf.accessors[static_cast<std::size_t>(primitive.indices)];
      const auto& view = gltf.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
      std::vector<std::uint32_t> indices(accessor.count);
      std::memcpy(indices.data(), gltf.buffers[0].data.data() + view.byteOffset, view.byteLength);
      for (std::size_t i = 0; i < indices.size(); ++i)
        EXPECT_EQ(rows.at(indices[i]), static_cast<float>(photos.of_face[index(faces[triangle + i / 3])]));
      triangle += indices.size() / 3;
    }
    EXPECT_EQ(triangle, 4u);
    const tinygltf::Value& metadata = gltf.extensions.at("EXT_structural_metadata");
    const tinygltf::Value& table = metadata.Get("propertyTables").Get(0);
    EXPECT_EQ(table.Get("count").GetNumberAsInt(), 3);
    EXPECT_TRUE(metadata.Get("schema").Get("classes").Has(table.Get("class").Get<std::string>()));
    const tinygltf::Value &names = table.Get("properties").Get("photo"), &gsd = table.Get("properties").Get("gsd");
    EXPECT_EQ(bytes_of(gltf, names.Get("values")), "DJI_0026.JPG\xC3\x9C.jpg");
    const std::uint32_t offsets[] = {0, 0, 12, 18};
    EXPECT_EQ(bytes_of(gltf, names.Get("stringOffsets")),
              std::string(reinterpret_cast<const char*>(offsets), sizeof offsets));
    EXPECT_EQ(bytes_of(gltf, gsd.Get("values")),
              std::string(reinterpret_cast<const char*>(photos.gsd.data()), 3 * sizeof(float)));
  }
}

TEST(WriteGltf, NamesWhoseItIs) {
  const StripModel test;
  ModelOptions options{{500000, 5400000, 0}};
  options.copyright = "City of Ulm";
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, options);
  EXPECT_EQ(load(test.folder.path() / "m.glb").asset.copyright, "City of Ulm");
}

TEST(WriteGltf, FilesHoldWhatTheGlbHolds) {
  const StripModel test;
  ModelOptions options{{500000, 5400000, 0}, UpAxis::pos_z};
  options.normals = true;
  const auto faces = write_glb(test.folder.path() / "m.glb", test.model, test.pages, options);
  const GltfFiles files = write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, options);
  EXPECT_EQ(files.file, test.folder.path() / "m.gltf");
  EXPECT_EQ(files.buffers, std::vector{test.folder.path() / "m.bin"});
  EXPECT_EQ(files.faces, faces);
  const tinygltf::Model one = load(test.folder.path() / "m.glb"), many = load(files.file);
  ASSERT_EQ(one.meshes[0].primitives.size(), many.meshes[0].primitives.size());
  for (std::size_t p = 0; p < one.meshes[0].primitives.size(); ++p) {
    const auto& a = one.meshes[0].primitives[p];
    const auto& b = many.meshes[0].primitives[p];
    for (const char* name : {"POSITION", "TEXCOORD_0", "NORMAL"})
      EXPECT_EQ(floats(one, a.attributes.at(name)), floats(many, b.attributes.at(name))) << name;
    EXPECT_EQ(floats(one, a.indices), floats(many, b.indices));  // bytes
  }
  ASSERT_EQ(many.images.size(), 2u);
  EXPECT_EQ(many.images[0].uri, "model_0.png");
  EXPECT_EQ(many.images[1].uri, "model_1.jpg");
  EXPECT_EQ(one.images[1].image, many.images[1].image);
  EXPECT_EQ(one.nodes[0].rotation, many.nodes[0].rotation);
}

TEST(WriteGltf, CutsBuffersBetweenPrimitives) {
  const StripModel test;
  ModelOptions options;
  options.buffer_limit_bytes = 100;
  const GltfFiles files = write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, options);
  EXPECT_EQ(files.buffers, (std::vector{test.folder.path() / "m.bin", test.folder.path() / "m_1.bin"}));
  const GltfFiles whole = write_gltf(test.folder.path() / "w", GltfContainer::files, test.model, test.pages, {});
  EXPECT_EQ(test::read_file(files.buffers[0]) + test::read_file(files.buffers[1]), test::read_file(whole.buffers[0]));
  const tinygltf::Model gltf = load(files.file), one = load(whole.file);
  EXPECT_EQ(gltf.buffers.size(), 2u);
  for (std::size_t p = 0; p < 2; ++p)
    EXPECT_EQ(floats(gltf, gltf.meshes[0].primitives[p].attributes.at("POSITION")),
              floats(one, one.meshes[0].primitives[p].attributes.at("POSITION")));
}

// A sparse page stands in for the photos of a country.
TEST(WriteGltf, TurnsToFilesAboveFourGibibytes) {
  const StripModel test;
  std::filesystem::resize_file(test.pages[0].file, std::uintmax_t{1} << 32);
  const GltfFiles files = write_gltf(test.folder.path() / "m", GltfContainer::glb, test.model, test.pages, {});
  EXPECT_EQ(files.file, test.folder.path() / "m.gltf");
  EXPECT_GT(files.glb_bytes, std::size_t{1} << 32);
  EXPECT_FALSE(std::filesystem::exists(test.folder.path() / "m.glb"));
  EXPECT_TRUE(contains(test::read_file(files.file), "\"model_0.png\""));
  EXPECT_EQ(test.folder.count(), 4u);
}

TEST(WriteGltf, EscapesNamesAsUris) {
  StripModel test;
  std::filesystem::rename(test.pages[0].file, test.folder.path() / "a b#\xC3\xA4.png");
  test.pages[0].file = test.folder.path() / "a b#\xC3\xA4.png";
  const GltfFiles files = write_gltf(test.folder.path() / "m 1", GltfContainer::files, test.model, test.pages, {});
  const std::string json = test::read_file(files.file);
  EXPECT_TRUE(contains(json, "\"a%20b%23%C3%A4.png\""));
  EXPECT_TRUE(contains(json, "\"m%201.bin\""));
}

// glTF has readers ignore profiles, and its validator warns of a PNG's.
TEST(WriteGltf, EmbedsPngPagesWithoutTheirProfile) {
  const StripModel test;
  const Image page = read_image(test.pages[0].file);
  write_glb(test.folder.path() / "plain.glb", test.model, test.pages, {});
  write_image(test.pages[0].file, page, ImageFormat::png, 0, ColorProfile(700, 'x'));
  EXPECT_TRUE(contains(test::read_file(test.pages[0].file), "iCCP"));
  write_glb(test.folder.path() / "profile.glb", test.model, test.pages, {});
  EXPECT_FALSE(contains(test::read_file(test.folder.path() / "profile.glb"), "iCCP"));
  EXPECT_EQ(load(test.folder.path() / "profile.glb").images[0].image,
            load(test.folder.path() / "plain.glb").images[0].image);
}

TEST(WriteGltf, LeavesOutFacesWithoutAPage) {
  StripModel test;
  test.model.face_page = {1, kNoPage, kNoPage, 1};
  test.model.face_texcoords[1] = {99, 99, 99};  // means nothing
  const auto faces = write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  EXPECT_EQ(faces, (std::vector<FaceId>{FaceId{0}, FaceId{3}}));
  EXPECT_EQ(load(test.folder.path() / "m.glb").meshes[0].primitives.size(), 1u);
  test.model.face_page.assign(4, kNoPage);
  EXPECT_THROW(write_glb(test.folder.path() / "n.glb", test.model, test.pages, {}), OutputError);
}

TEST(WriteObj, ListsFacesWithoutAPageInTheirPlace) {
  StripModel test;
  test.model.face_page = {1, kNoPage, kNoPage, 0};
  const auto file = test.folder.path() / "model.obj";
  for (const bool normals : {false, true}) {
    ModelOptions options;
    options.normals = normals;
    write_obj(file, test.model, test.pages, options);
    EXPECT_EQ(read_mesh(file).faces, test.mesh.faces);
    const LoadedModel back = read_textured_model(file);
    EXPECT_EQ(back.model.face_page[1], kNoPage);
    EXPECT_EQ(back.model.face_page[2], kNoPage);
    EXPECT_NE(back.model.face_page[3], kNoPage);
    EXPECT_TRUE(contains(test::read_file(file), normals ? "usemtl untextured\nf 3//3 4//4 2//2\nf 3//3 5//5 4//4\n"
                                                        : "usemtl untextured\nf 3 4 2\nf 3 5 4\n"));
  }
  EXPECT_TRUE(contains(test::read_file(test.folder.path() / "model.mtl"), "newmtl untextured\n"));
}

TEST(WriteObj, LeavesOutFacesWithoutAPageWhenAsked) {
  StripModel test;
  test.model.face_page = {kNoPage, 0, kNoPage, 0};
  const auto file = test.folder.path() / "model.obj";
  ModelOptions options;
  options.pageless_faces = false;
  write_obj(file, test.model, test.pages, options);
  EXPECT_EQ(read_mesh(file).faces, (std::vector<Triangle>{test.mesh.faces[1], test.mesh.faces[3]}));
  EXPECT_TRUE(contains(test::read_file(file), "usemtl page_0\nf 3/4 4/5 2/6\nf 5/4"));
  EXPECT_FALSE(contains(test::read_file(test.folder.path() / "model.mtl"), "untextured"));
}

TEST(WriteObj, WritesANormalAPosition) {
  const StripModel test;
  ModelOptions options;
  options.normals = true;
  const auto file = test.folder.path() / "model.obj";
  write_obj(file, test.model, test.pages, options);
  const std::string text = test::read_file(file);
  EXPECT_TRUE(contains(text, "f 1/1/1 3/2/3 2/3/2\n"));
  std::size_t lines = 0;
  for (std::size_t at = 0; (at = text.find("\nvn ", at)) != std::string::npos; ++at) ++lines;
  EXPECT_EQ(lines, test.mesh.positions.size());
  EXPECT_EQ(read_mesh(file).positions, test.mesh.positions);
}

// OpenMesh holds no face that names a vertex twice; all others come back with the same counts.
TEST(WriteObj, OpenMeshReadsTheSameCounts) {
  StripModel test;
  test.mesh.faces[3] = {4, 5, 3};
  const auto file = test.folder.path() / "model.obj";
  for (const bool normals : {false, true}) {
    ModelOptions options;
    options.normals = normals;
    write_obj(file, test.model, test.pages, options);
    OpenMesh::PolyMesh_ArrayKernelT<> mesh;
    ASSERT_TRUE(OpenMesh::IO::read_mesh(mesh, file.string()));
    EXPECT_EQ(mesh.n_vertices(), test.mesh.positions.size());
    EXPECT_EQ(mesh.n_faces(), test.mesh.faces.size());
  }
}

// A scene file in Latin-1 names its system in Latin-1.
TEST(Gltf, DefinitionsThatAreNoUtf8AreMended) {
  const StripModel strip;
  ModelOptions options;
  options.srs = "Syst\xE8me Lambert";
  const auto file = strip.folder.path() / "latin.glb";
  write_glb(file, strip.model, strip.pages, options);
  EXPECT_EQ(load(file).nodes.at(0).extras.Get("srs").Get<std::string>(), "Syst\uFFFDme Lambert");
}

}  // namespace
}  // namespace gpvc::io
