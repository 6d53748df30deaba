#include <tiny_gltf.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/mesh.h"
#include "io/model_pages.h"
#include "io/textured_model.h"
#include "tests/atlas/strip_model.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::StripModel;
using test::write_glb;

tinygltf::Model read_glb(const std::filesystem::path& file) {
  tinygltf::Model gltf;
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  EXPECT_TRUE(loader.LoadBinaryFromFile(&gltf, &error, &warning, file.string())) << error;
  EXPECT_EQ(error + warning, "");
  return gltf;
}

template <typename T>
std::vector<T> values_of(const tinygltf::Model& gltf, int accessor_number, std::size_t components) {
  const tinygltf::Accessor& accessor = gltf.accessors.at(static_cast<std::size_t>(accessor_number));
  const tinygltf::BufferView& view = gltf.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  std::vector<T> values(accessor.count * components);
  EXPECT_EQ(view.byteLength, values.size() * sizeof(T));
  std::memcpy(values.data(), gltf.buffers.at(0).data.data() + view.byteOffset + accessor.byteOffset,
              values.size() * sizeof(T));
  return values;
}

// Every triangle of the GLB has the corners, the winding, the texture coordinates and the page of its input face.
TEST(WriteGlb, HoldsEveryFaceWithItsTexture) {
  const StripModel test;
  const ModelOptions options{{500000, 5400000, 0}, UpAxis::pos_z};
  const auto file = test.folder.path() / "m.glb";
  const std::vector<FaceId> faces = write_glb(file, test.model, test.pages, options);
  EXPECT_EQ(faces, (std::vector<FaceId>{FaceId{1}, FaceId{0}, FaceId{2}, FaceId{3}}));

  const tinygltf::Model gltf = read_glb(file);
  ASSERT_EQ(gltf.meshes.size(), 1);
  ASSERT_EQ(gltf.meshes[0].primitives.size(), 2);
  std::size_t triangle = 0;
  for (std::size_t page = 0; page < 2; ++page) {
    const tinygltf::Primitive& primitive = gltf.meshes[0].primitives[page];
    EXPECT_EQ(gltf.accessors[static_cast<std::size_t>(primitive.indices)].componentType,
              TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
    const auto indices = values_of<std::uint32_t>(gltf, primitive.indices, 1);
    const auto positions = values_of<float>(gltf, primitive.attributes.at("POSITION"), 3);
    const auto texcoords = values_of<float>(gltf, primitive.attributes.at("TEXCOORD_0"), 2);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const std::size_t face = index(faces[triangle + i / 3]);
      ASSERT_EQ(test.model.face_page[face], page);
      const WorldPoint& world = test.mesh.positions[test.mesh.faces[face][i % 3]];
      const TexCoord& texcoord = test.model.texcoords[test.model.face_texcoords[face][i % 3]];
      const std::size_t v = indices[i];
      EXPECT_EQ(positions[3 * v], static_cast<float>(world.x - 500000));
      EXPECT_EQ(positions[3 * v + 1], static_cast<float>(world.y - 5400000));
      EXPECT_EQ(positions[3 * v + 2], static_cast<float>(world.z));
      EXPECT_EQ(texcoords[2 * v], texcoord.u);
      EXPECT_EQ(texcoords[2 * v + 1], texcoord.v);
    }
    triangle += indices.size() / 3;
  }
  EXPECT_EQ(triangle, 4);
  // Page 1: (0,t0) (2,t1) (1,t2) (2,t6) (4,t3) (3,t4) (5,t6); the second use of (4,t3) is shared.
  EXPECT_EQ(values_of<float>(gltf, gltf.meshes[0].primitives[1].attributes.at("POSITION"), 3).size(), 3 * 7);
}

TEST(WriteGlb, BoundsAreThoseOfTheStoredFloats) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {{500000, 5400000, 0}, UpAxis::pos_y});
  const tinygltf::Model gltf = read_glb(test.folder.path() / "m.glb");
  for (const tinygltf::Primitive& primitive : gltf.meshes[0].primitives) {
    const int number = primitive.attributes.at("POSITION");
    const auto positions = values_of<float>(gltf, number, 3);
    const tinygltf::Accessor& accessor = gltf.accessors[static_cast<std::size_t>(number)];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float low = positions[axis], high = positions[axis];
      for (std::size_t i = axis; i < positions.size(); i += 3) {
        low = std::min(low, positions[i]);
        high = std::max(high, positions[i]);
      }
      EXPECT_EQ(accessor.minValues[axis], static_cast<double>(low));
      EXPECT_EQ(accessor.maxValues[axis], static_cast<double>(high));
    }
  }
}

TEST(WriteGlb, LitMaterialsNeedNoExtension) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {{}, UpAxis::pos_y, "", {}, true, true});
  const tinygltf::Model gltf = read_glb(test.folder.path() / "m.glb");
  EXPECT_TRUE(gltf.extensionsUsed.empty());
  for (const tinygltf::Material& material : gltf.materials) {
    EXPECT_TRUE(material.extensions.empty());
    EXPECT_EQ(material.pbrMetallicRoughness.metallicFactor, 0);
  }
}

TEST(WriteGlb, EmbedsPagesByteForByte) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  const tinygltf::Model gltf = read_glb(test.folder.path() / "m.glb");
  ASSERT_EQ(gltf.images.size(), 2);
  for (std::size_t page = 0; page < 2; ++page) {
    const int material = gltf.meshes[0].primitives[page].material;
    const tinygltf::Material& unlit = gltf.materials[static_cast<std::size_t>(material)];
    EXPECT_TRUE(unlit.extensions.contains("KHR_materials_unlit"));
    const tinygltf::Texture& texture =
        gltf.textures[static_cast<std::size_t>(unlit.pbrMetallicRoughness.baseColorTexture.index)];
    const tinygltf::Image& image = gltf.images[static_cast<std::size_t>(texture.source)];
    EXPECT_EQ(image.mimeType, page == 0 ? "image/png" : "image/jpeg");
    EXPECT_EQ(image.width, 5);
    EXPECT_EQ(image.height, 3);
    const tinygltf::BufferView& view = gltf.bufferViews[static_cast<std::size_t>(image.bufferView)];
    const auto* bytes = reinterpret_cast<const char*>(gltf.buffers[0].data.data() + view.byteOffset);
    EXPECT_EQ(std::string(bytes, view.byteLength), test::read_file(test.pages[page].file));
    const tinygltf::Sampler& sampler = gltf.samplers[static_cast<std::size_t>(texture.sampler)];
    EXPECT_EQ(sampler.minFilter, TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR);
    EXPECT_EQ(sampler.wrapS, TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE);
  }
  EXPECT_EQ(gltf.extensionsUsed, std::vector<std::string>{"KHR_materials_unlit"});
  EXPECT_TRUE(contains(gltf.asset.generator, "gpvc "));
}

TEST(WriteGlb, KeepsTheOffsetInTheRootsExtras) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {{500000.123456789, -5400000, 1e-7}, UpAxis::pos_y});
  const tinygltf::Model gltf = read_glb(test.folder.path() / "m.glb");
  ASSERT_EQ(gltf.scenes[0].nodes, std::vector<int>{0});
  const tinygltf::Value& offset = gltf.nodes[0].extras.Get("offset");
  EXPECT_EQ(offset.Get(0).GetNumberAsDouble(), 500000.123456789);
  EXPECT_EQ(offset.Get(1).GetNumberAsDouble(), -5400000);
  EXPECT_EQ(offset.Get(2).GetNumberAsDouble(), 1e-7);
}

/// v turned by the unit quaternion (x, y, z, w): v + 2 q x (q x v + w v).
std::array<double, 3> turned(const std::vector<double>& q, const std::array<double, 3>& v) {
  const auto cross = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return std::array<double, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const std::array<double, 3> axis{q[0], q[1], q[2]};
  std::array<double, 3> inner = cross(axis, v);
  for (std::size_t i = 0; i < 3; ++i) inner[i] += q[3] * v[i];
  std::array<double, 3> out = cross(axis, inner);
  for (std::size_t i = 0; i < 3; ++i) out[i] = v[i] + 2 * out[i];
  return out;
}

TEST(WriteGlb, TurnsTheUpAxisToPlusY) {
  const StripModel test;
  const std::array<std::array<double, 3>, 6> axes{
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  for (int up = 0; up < 6; ++up) {
    write_glb(test.folder.path() / "m.glb", test.model, test.pages, {{}, static_cast<UpAxis>(up)});
    const tinygltf::Model gltf = read_glb(test.folder.path() / "m.glb");
    std::vector<double> rotation = gltf.nodes[0].rotation;
    if (rotation.empty()) rotation = {0, 0, 0, 1};
    ASSERT_EQ(rotation.size(), 4);
    const std::array<double, 3> y = turned(rotation, axes[static_cast<std::size_t>(up)]);
    EXPECT_NEAR(y[0], 0, 1e-15) << up;
    EXPECT_NEAR(y[1], 1, 1e-15) << up;
    EXPECT_NEAR(y[2], 0, 1e-15) << up;
  }
}

TEST(WriteGlb, RefusesWhatFloatsCannotHold) {
  StripModel test;
  test.mesh.positions[0].x = 1e300;
  EXPECT_THROW(write_glb(test.folder.path() / "m.glb", test.model, test.pages, {}), OutputError);
  EXPECT_FALSE(std::filesystem::exists(test.folder.path() / "m.glb"));
}

TEST(WriteGlb, WritesTheSameBytesTwice) {
  const StripModel test;
  write_glb(test.folder.path() / "a.glb", test.model, test.pages, {});
  write_glb(test.folder.path() / "b.glb", test.model, test.pages, {});
  EXPECT_EQ(test::read_file(test.folder.path() / "a.glb"), test::read_file(test.folder.path() / "b.glb"));
}

TEST(WriteObj, ReadsBackTheSamePositionsAndFaces) {
  StripModel test;
  for (const double hard : {0.1, 1.0 / 3, 1e-310, -0.0, 9.876543210987654e17, 123456789.123456789})
    test.mesh.positions.push_back({hard, -hard, std::nextafter(hard, 0)});
  const auto file = test.folder.path() / "model.obj";
  write_obj(file, test.model, test.pages, {});
  const Mesh back = read_mesh(file);
  EXPECT_EQ(back.positions, test.mesh.positions);
  EXPECT_EQ(back.faces, test.mesh.faces);

  const WorldPoint offset{500000, 5400000, 0.25};
  write_obj(file, test.model, test.pages, {offset, UpAxis::pos_y});
  const Mesh local = read_mesh(file);
  for (std::size_t i = 0; i < local.positions.size(); ++i) {
    const WorldPoint& p = test.mesh.positions[i];
    EXPECT_EQ(local.positions[i], (WorldPoint{p.x - offset.x, p.y - offset.y, p.z - offset.z}));
  }
}

TEST(WriteObj, WritesTheDocumentedText) {
  StripModel test;
  test.mesh.positions.resize(5);
  for (std::size_t i = 0; i < 5; ++i) test.mesh.positions[i] = {static_cast<double>(i), 0.5, -2e-7};
  test.mesh.faces = {{0, 2, 1}, {2, 3, 1}, {2, 4, 3}};
  test.model.face_texcoords.resize(3);
  test.model.face_page.resize(3);
  const auto file = test.folder.path() / "model.obj";
  write_obj(file, test.model, test.pages, {});
  EXPECT_EQ(test::read_file(file),
            "mtllib model.mtl\nv 0 0.5 -2e-07\nv 1 0.5 -2e-07\nv 2 0.5 -2e-07\nv 3 0.5 -2e-07\nv 4 0.5 -2e-07\n"
            "vt 0 1\nvt 0.25 1\nvt 0 0.875\nvt 0.5 0.5\nvt 0.75 0.5\nvt 0.1 0.100000024\nvt 1 0\n"
            "usemtl page_1\nf 1/1 3/2 2/3\nusemtl page_0\nf 3/4 4/5 2/6\nusemtl page_1\nf 3/7 5/4 4/5\n");
  const std::string mtl = test::read_file(test.folder.path() / "model.mtl");
  EXPECT_TRUE(contains(mtl, "newmtl page_0\n"));
  EXPECT_TRUE(contains(mtl, "\nmap_Kd model_0.png\n"));
  EXPECT_TRUE(contains(mtl, "\nmap_Kd model_1.jpg\n"));
}

TEST(WriteModel, RefusesIndicesThatDoNotExist) {
  const auto refused = [](const auto& change) {
    StripModel test;
    change(test.model);
    EXPECT_THROW(write_obj(test.folder.path() / "m.obj", test.model, test.pages, {}), std::invalid_argument);
    EXPECT_THROW(write_glb(test.folder.path() / "m.glb", test.model, test.pages, {}), std::invalid_argument);
  };
  refused([](TexturedModel& model) { model.face_page[2] = 2; });
  refused([](TexturedModel& model) { model.face_texcoords[2][1] = 7; });
  refused([](TexturedModel& model) { model.face_page.pop_back(); });
  refused([](TexturedModel& model) { model.face_page.assign(4, kNoPage - 1); });
}

// --- and back

/// `text` with `to` in place of `from`, which it holds once.
std::string exchanged(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  EXPECT_EQ(text.find(from, at + 1), std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal(const StripModel& test, const std::string& glb) {
  const auto file = test.folder.write("changed.glb", glb);
  return test::input_error([&] { read_textured_model(file); });
}

TEST(ReadTexturedModel, ReadsBothOwnContainersBack) {
  const StripModel test;
  const auto faces = write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, {});
  for (const char* name : {"m.glb", "m.gltf"}) {
    const LoadedModel back = read_textured_model(test.folder.path() / name);
    ASSERT_EQ(back.pages.size(), 2u);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const std::uint32_t page = test.model.face_page[index(faces[i])];
      EXPECT_EQ(back.pages[back.model.face_page[i]].pixels, read_image(test.pages[page].file).pixels) << name;
    }
  }
}

// A square and two triangles, as OpenMVS and MeshLab write them: v runs upwards. The last two faces have no texture: no
// coordinates, and a page below 0.
TEST(ReadModelPages, GivesTheFilesOfAnObjWithoutReadingThem) {
  const StripModel test;
  const auto obj = test.folder.path() / "m.obj", glb = test.folder.path() / "m.glb";
  write_obj(obj, test.model, test.pages, {});
  write_glb(glb, test.model, test.pages, {});
  std::vector<std::filesystem::path> files;
  std::size_t taken = 0;
  const auto take = [&taken](std::size_t, const Image&) { ++taken; };
  const LoadedModel whole = read_textured_model(obj);
  EXPECT_EQ(read_model_pages(glb, take, files).pages.size(), 0u);
  EXPECT_EQ(taken, 2u) << "pages inside a file are handed on";
  EXPECT_TRUE(files.empty());
  for (const PageFile& page : test.pages) std::ofstream(page.file) << "no image";
  const LoadedModel loaded = read_model_pages(obj, take, files);
  EXPECT_EQ(taken, 2u);
  EXPECT_EQ(loaded.model.face_page, whole.model.face_page);
  ASSERT_EQ(files.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) EXPECT_TRUE(std::filesystem::equivalent(files[n], test.pages[n].file));
}

TEST(ReadTexturedModel, ReadsPlyWithTextureFiles) {
  const StripModel test;
  const std::string header =
      "ply\nformat ascii 1.0\ncomment TextureFile model_0.png\ncomment TextureFile model_1.jpg\nelement vertex 4\n"
      "property float x\nproperty float y\nproperty float z\nelement face 3\nproperty list uchar int vertex_indices\n"
      "property list uchar float texcoord\nproperty char texnumber\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const auto file = test.folder.write("m.ply", header +
                                                   "4 0 1 2 3 8 0.125 0.25 0.5 0.25 0.5 0.75 0.125 0.75 1\n"
                                                   "3 0 1 2 0 0\n3 0 1 2 6 0 0 1 0 1 1 -1\n");
  const LoadedModel model = read_textured_model(file);
  EXPECT_EQ(model.mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 2}}));
  EXPECT_EQ(model.model.face_page, (std::vector<std::uint32_t>{1, 1, kNoPage, kNoPage}));
  ASSERT_EQ(model.pages.size(), 2u);
  EXPECT_EQ(model.pages[1].pixels, read_image(test.pages[1].file).pixels);
  const TexCoord last = model.model.texcoords[model.model.face_texcoords[1][2]];
  EXPECT_EQ(last.u, 0.125f);
  EXPECT_EQ(last.v, 0.25f);
  const auto refusal = [&](const std::string& face) {
    test.folder.write("m.ply", header + "4 0 1 2 3 8 0 0 1 0 1 1 0 1 0\n" + face + "\n3 0 1 2 6 0 0 1 0 1 1 0\n");
    return test::input_error([&] { read_textured_model(file); });
  };
  EXPECT_TRUE(
      contains(refusal("3 0 1 2 4 0 0 1 0 0"), "m.ply: face 1: has 4 texture coordinates, expected 6, two a corner"));
  EXPECT_TRUE(contains(refusal("3 0 1 2 8 0 0 1 0 1 1 0 1 0"), "face 1: has 8 texture coordinates, expected 6"));
  EXPECT_TRUE(contains(refusal("3 0 1 2 6 0 0 nan 0 1 1 0"), "face 1: has a texture coordinate that is not finite"));
  EXPECT_TRUE(contains(refusal("3 0 1 2 6 0 0 1 0 1 1 7"), "face 1: shows texture 7, the header names 2"));
  test.folder.write("m.ply", header);
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(file); }), "m.ply: line"));
  test.folder.write("m.ply", "v 0 0 0\n");
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(file); }), "m.ply: line 1: expected 'ply'"));
}

TEST(ReadTexturedModel, ReadsNamesWithBlanksBehindByteOrderMarks) {
  const StripModel test;
  write_obj(test.folder.path() / "m.obj", test.model, test.pages, {});
  const LoadedModel expected = read_textured_model(test.folder.path() / "m.obj");
  std::string obj = test::read_file(test.folder.path() / "m.obj"), mtl = test::read_file(test.folder.path() / "m.mtl");
  const auto rename = [](std::string& text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  };
  for (std::string* text : {&obj, &mtl})
    for (const char* number : {"0", "1"})
      for (const char* keyword : {"usemtl ", "newmtl "})
        rename(*text, keyword + std::string("page_") + number, keyword + std::string("page no. ") + number);
  rename(obj, "mtllib m.mtl", "mtllib sub folder\\my materials.mtl");
  rename(mtl, "map_Kd ", "map_Kd ../");
  rename(mtl, "newmtl page no. 0", "newmtl page no. 0  # the first");
  rename(obj, "usemtl page no. 1", "usemtl page no. 1 # the second");
  std::ranges::replace(mtl, '\n', '\r');
  test.folder.write("sub folder/my materials.mtl", "\xEF\xBB\xBF" + mtl.substr(mtl.find("newmtl")));
  const LoadedModel found =
      read_textured_model(test.folder.write("n.obj", "\xEF\xBB\xBF" + obj.substr(obj.find("mtllib"))));
  EXPECT_EQ(found.model.face_page, expected.model.face_page);
  EXPECT_EQ(found.mesh.faces, expected.mesh.faces);
  EXPECT_EQ(found.pages.size(), expected.pages.size());
}

// As an OBJ that was cut out of a larger one has it beside itself.
TEST(ReadTexturedModel, ImagesOfMaterialsThatNoFaceUsesNeedNotBeThere) {
  const StripModel test;
  write_obj(test.folder.path() / "m.obj", test.model, test.pages, {});
  const LoadedModel expected = read_textured_model(test.folder.path() / "m.obj");
  test.folder.write("m.mtl", "newmtl tree\nmap_Kd tree.png\n" + test::read_file(test.folder.path() / "m.mtl"));
  const LoadedModel found = read_textured_model(test.folder.path() / "m.obj");
  EXPECT_EQ(found.model.face_page, expected.model.face_page);
  EXPECT_EQ(found.pages.size(), expected.pages.size());
  std::string obj = test::read_file(test.folder.path() / "m.obj");
  obj.insert(obj.find("usemtl"), "usemtl tree\n");
  EXPECT_EQ(read_textured_model(test.folder.write("n.obj", obj)).model.face_page, expected.model.face_page)
      << "named, but for no face";
}

// A quad whose fan would turn a triangle over, coordinates behind the faces and counted from the end, options before an image,
// and faces without texture: no coordinates, some of number 0, no material and one without an image.
TEST(ReadTexturedModel, ReadsObjsOfOtherWriters) {
  const StripModel test;
  test.folder.write(
      "a.mtl",
      "newmtl plain\nKd 1 0 0\nnewmtl red\nmap_Kd -s 1 1 -clamp on -o 0 -blendu off -bm 2 -mm 0 1 model_0.png\n");
  test.folder.write("b.mtl", "newmtl blue\r\n\tmap_Kd model_1.jpg\r\n");
  const std::string vertices =
      "mtllib a.mtl none.mtl b.mtl\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 0.5 0.5 0\nvt 0 0\nvt 1 0 0\nvt 0 1\n";
  const auto file =
      test.folder.write("m.obj", vertices +
                                     "f 1/1 2/2 3/3\nusemtl blue\nf 3/3/1 4/4/1 2/2/1 1/1/1\n"
                                     "usemtl red # wall\nf -4/-3 -3/-2 -2/-1\nf 1//1 2//1 3//1\nf 1/0 2/1 3/1\n"
                                     "usemtl plain\nf 1/1 2/2 3/3\nvt 0.25 0.25\n");
  const LoadedModel model = read_textured_model(file);
  EXPECT_EQ(model.mesh.faces,
            (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {3, 1, 0}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}}));
  EXPECT_EQ(model.model.face_page, (std::vector<std::uint32_t>{kNoPage, 1, 1, 0, kNoPage, kNoPage, kNoPage}));
  for (const std::size_t f : {1u, 2u, 3u})
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(model.model.face_texcoords[f][k], model.mesh.faces[f][k]);
  EXPECT_EQ(model.model.texcoords[3].v, 0.75f);
  const auto error_of = [&](const std::string& line) {
    test.folder.write("m.obj", vertices + line);
    return test::input_error([&] { read_textured_model(file); });
  };
  EXPECT_TRUE(contains(error_of("vt \n"), "m.obj: line 9: a texture coordinate needs a number"));
  EXPECT_TRUE(contains(error_of("f 1/1 2/x 3/3\n"), "m.obj: line 9: '2/x' has no number of a texture coordinate"));
  EXPECT_TRUE(contains(error_of("f 1/1 2/2 3/3\nf 1/1 2/9 3/3\n"),
                       "m.obj: face 1: refers to texture coordinate 9, the file has 3"));
  EXPECT_TRUE(contains(error_of("f 1/1 2/2 3/-4\n"), "m.obj: line 9: texture coordinate -4 of a face does not exist"));
}

// Our models clamp at the rim; without a sampler pages repeat.
TEST(ReadTexturedModel, RefusesCoordinatesBeyondPagesThatDoNotRepeat) {
  StripModel test;
  test.model.texcoords[test.model.face_texcoords[0][0]].u = 1.0001f;
  write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, {});
  const auto largest = [&](const std::filesystem::path& file) {
    float most = 0;
    for (const TexCoord& t : read_textured_model(file).model.texcoords) most = std::max(most, t.u);
    return most;
  };
  EXPECT_EQ(largest(test.folder.path() / "m.gltf"), 1.0f);
  test.model.texcoords[test.model.face_texcoords[0][0]].u = 1.5f;
  write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, {});
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(test.folder.path() / "m.gltf"); }),
                       "has the texture coordinate 1.5 of a texture that does not repeat"));
  auto json = nlohmann::json::parse(test::read_file(test.folder.path() / "m.gltf"));
  for (auto& texture : json["textures"]) texture.erase("sampler");
  EXPECT_EQ(largest(test.folder.write("n.gltf", json.dump())), 1.5f);
}

// Both materials show one image: faces of the one that repeats keep the coordinates that they share with the others.
TEST(ReadTexturedModel, HonoursOptionsOfObjsTextures) {
  const StripModel test;
  const auto read = [&](const std::string& options, const std::string& u) {
    test.folder.write("c.mtl", "newmtl once\nmap_Kd " + options + " model_0.png\nnewmtl often\nmap_Kd model_0.png\n");
    return read_textured_model(
        test.folder.write("c.obj", "mtllib c.mtl\nv 0 0 0\nv 2 0 0\nv 0 2 0\nvt 0 0\nvt " + u +
                                       " 0\nvt 0 1\nusemtl often\nf 1/1 2/2 3/3\nusemtl once\nf 1/1 2/2 3/3\n"));
  };
  const auto us = [](const LoadedModel& model) {
    std::vector<float> found;
    for (const Triangle& corners : model.model.face_texcoords) found.push_back(model.model.texcoords[corners[1]].u);
    return found;
  };
  EXPECT_EQ(us(read("-clamp off", "1.5")), (std::vector{1.5f, 1.5f}));
  EXPECT_EQ(us(read("-clamp on", "0.5")), (std::vector{0.5f, 0.5f}));
  EXPECT_EQ(us(read("-bm 1 -clamp on -s 1 1 1", "1.0005")), (std::vector{1.0005f, 1.0f}));
  const auto error_of = [&](const std::string& options) { return test::input_error([&] { read(options, "1.5"); }); };
  EXPECT_TRUE(contains(error_of("-clamp on"),
                       "c.obj: face 1: has the texture coordinate 1.5 of a texture that does not repeat (-clamp on)"));
  EXPECT_TRUE(contains(error_of("-blendu on -s 2 2 1"), "c.mtl: material once: the option -s 2 2 1 of its texture"));
  EXPECT_TRUE(contains(error_of("-o 0 0.5"), "c.mtl: material once: the option -o 0 0.5 of its texture"));
  EXPECT_TRUE(contains(error_of("-mm 0.2 1"), "the option -mm 0.2 1 of its texture"));
  EXPECT_TRUE(contains(error_of("-t 1 0 0"), "the option -t 1 0 0 of its texture"));
}

TEST(ReadTexturedModel, SaysWhichFacesReachBeyondTheirPage) {
  TexturedModel model;
  model.texcoords = {{0, 0}, {1, 0}, {1, 1}, {-0.5f, 0.5f}, {0.5f, 3}};
  model.face_texcoords = {{0, 1, 2}, {0, 1, 3}, {4, 1, 2}};
  EXPECT_FALSE(reaches_beyond_page(model, 0));
  EXPECT_TRUE(reaches_beyond_page(model, 1));
  EXPECT_TRUE(reaches_beyond_page(model, 2));
}

TEST(ReadTexturedModel, TakesTheTextureCoordinatesThatTheMaterialNames) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, {});
  const std::string good = test::read_file(test.folder.path() / "m.gltf");
  auto json = nlohmann::json::parse(good);
  for (auto& primitive : json["meshes"][0]["primitives"]) {
    primitive["attributes"]["TEXCOORD_1"] = primitive["attributes"]["TEXCOORD_0"];
    primitive["attributes"]["TEXCOORD_0"] = primitive["attributes"]["POSITION"];  // of another kind: not to be read
  }
  for (auto& material : json["materials"]) material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  const LoadedModel found = read_textured_model(test.folder.write("n.gltf", json.dump()));
  const LoadedModel expected = read_textured_model(test.folder.path() / "m.gltf");
  ASSERT_EQ(found.model.texcoords.size(), expected.model.texcoords.size());
  for (std::size_t i = 0; i < found.model.texcoords.size(); ++i)
    EXPECT_EQ(found.model.texcoords[i].u, expected.model.texcoords[i].u);
  json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"]["offset"] = {
      0.5, 0};
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(test.folder.write("t.gltf", json.dump())); }),
                       "is moved by KHR_texture_transform"));
}

TEST(ReadTexturedModel, LeavesFacesWithoutAPlaceBeyondSinglePrecision) {
  StripModel test;
  test.mesh.positions[4].y = 1e30;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  write_obj(test.folder.path() / "m.obj", test.model, test.pages, {});
  for (const char* name : {"m.glb", "m.obj"}) {
    const LoadedModel model = read_textured_model(test.folder.path() / name);
    EXPECT_EQ(model.mesh.faces.size(), test.mesh.faces.size());
    ASSERT_EQ(model.mesh.warnings.size(), 1u) << name;
    EXPECT_TRUE(contains(model.mesh.warnings[0], "whose coordinate 1")) << model.mesh.warnings[0];
    for (const WorldPoint& p : model.mesh.positions) EXPECT_LT(p.y, 1e18);
  }
  test.mesh.positions[4].y = 0;
  write_obj(test.folder.path() / "m.obj", test.model, test.pages, {});
  test.folder.write("offset.txt", "0 1e60 0\n");
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(test.folder.path() / "m.obj"); }), "offset"));
}

TEST(ReadTexturedModel, RefusesAGlbCutAnywhere) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  const std::string good = test::read_file(test.folder.path() / "m.glb");
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_TRUE(contains(refusal(test, good.substr(0, size)), "changed.glb: ")) << size;
}

// Widths and heights stand behind the name IHDR, big endian, and behind a JPEG's SOF0 marker; a chunk's length before
// its name.
TEST(ReadTexturedModel, HoldsImagesClaimsAgainstTheirBytes) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  const std::string good = test::read_file(test.folder.path() / "m.glb");
  const auto with = [&](std::string_view name, std::ptrdiff_t from, std::string_view bytes) {
    std::string changed = good;
    const auto at = static_cast<std::ptrdiff_t>(good.find(name)) + from;
    return changed.replace(static_cast<std::size_t>(at), bytes.size(), bytes);
  };
  using namespace std::string_view_literals;
  EXPECT_TRUE(contains(refusal(test, with("IHDR", 4, "\0\0\x75\x30\0\0\x75\x30"sv)),
                       "changed.glb: image 0: claims 30000 x 30000 pixels, more than its "));
  EXPECT_TRUE(contains(refusal(test, with("IHDR", 4, "\x7F\xFF\xFF\xFF\x7F\xFF\xFF\xFF"sv)),
                       "claims 2147483647 x 2147483647 pixels, expected at most 2^30"));
  EXPECT_TRUE(contains(refusal(test, with("IDAT", -4, "\x7F\0\0\0"sv)), "the PNG ends too early"));
  EXPECT_TRUE(contains(refusal(test, with("\xFF\xC0"sv, 5, "\x40\0\x40\0"sv)),
                       "image 1: claims 16384 x 16384 pixels, more than its "));
  EXPECT_TRUE(contains(refusal(test, with("\x89PNG", 0, "GIF8")), "image 0: expected a PNG, JPEG or WebP"));
}

TEST(ReadTexturedModel, RefusesImagesBeyondTheirBuffer) {
  const StripModel test;
  write_glb(test.folder.path() / "m.glb", test.model, test.pages, {});
  const tinygltf::Model gltf = read_glb(test.folder.path() / "m.glb");
  const auto& view = gltf.bufferViews[static_cast<std::size_t>(gltf.images[1].bufferView)];
  const std::string length = "\"byteLength\":" + std::to_string(view.byteLength);
  std::string longer = length;
  longer[longer.find(':') + 1] = '9';
  EXPECT_TRUE(contains(refusal(test, exchanged(test::read_file(test.folder.path() / "m.glb"), length, longer)),
                       "image 1: reaches beyond its buffer"));
}

TEST(ReadTexturedModel, RefusesJsonThatNestsWithoutEnd) {
  const StripModel test;
  std::string json = R"({"asset":{"version":"2.0"},"extras":)";
  json.append(1000000, '[').append(1000000, ']') += '}';
  const auto file = test.folder.write("deep.gltf", json);
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(file); }), "nests less deeply"));
}

TEST(ReadTexturedModel, NamesPagesThatAreMissing) {
  const StripModel test;
  const GltfFiles files = write_gltf(test.folder.path() / "m", GltfContainer::files, test.model, test.pages, {});
  std::filesystem::remove(test.pages[1].file);
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(files.file); }),
                       "m.gltf: image 1 (model_1.jpg): cannot be read, expected a file model_1.jpg"));
  std::filesystem::create_directory(test.pages[1].file);
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(files.file); }), "expected a file"));
  std::filesystem::remove(files.buffers[0]);
  EXPECT_TRUE(contains(test::input_error([&] { read_textured_model(files.file); }), "m.bin"));
}

// Another machine's path is looked for beside the model by its last name.
TEST(ReadTexturedModel, FindsAnObjsPagesOrNamesThem) {
  const StripModel test;
  write_obj(test.folder.path() / "m.obj", test.model, test.pages, {});
  const std::string mtl = test::read_file(test.folder.path() / "m.mtl");
  test.folder.write("m.mtl", exchanged(mtl, "map_Kd model_1.jpg", "map_Kd C:\\out\\model_1.jpg"));
  EXPECT_EQ(read_textured_model(test.folder.path() / "m.obj").pages.size(), 2u);
  test.folder.write("m.mtl", exchanged(mtl, "map_Kd model_1.jpg", "map_Kd /no such/\x01 place.jpg"));
  const std::string error = test::input_error([&] { read_textured_model(test.folder.path() / "m.obj"); });
  EXPECT_TRUE(contains(error, "m.obj: texture: "));
  EXPECT_TRUE(contains(error, " place.jpg: does not exist"));
}

}  // namespace
}  // namespace gpvc::io
