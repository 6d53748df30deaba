#include "io/uv_layout.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "io/images.h"
#include "io/mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;

/// One triangle after another, each with corners of its own.
struct Stated : StatedUv {
  Stated& add(std::array<double, 2> a, std::array<double, 2> b, std::array<double, 2> c,
              std::uint32_t material = StatedUv::kNone) {
    const auto first = static_cast<std::uint32_t>(texcoords.size());
    texcoords.insert(texcoords.end(), {a, b, c});
    face_texcoords.push_back({first, first + 1, first + 2});
    face_material.push_back(material);
    return *this;
  }
};

std::string refusal(const StatedUv& uv) {
  try {
    lay_out(uv, {1024, true}, "model.obj");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(LayOut, PutsAModelWithoutMaterialsOnOnePage) {
  const UvLayout layout = lay_out(Stated().add({0, 0}, {1, 0}, {0.25, 0.75}), {1024, true});
  ASSERT_EQ(layout.pages.size(), 1u);
  EXPECT_EQ(layout.pages[0].suffix, "_0");
  EXPECT_EQ(layout.pages[0].width, 1024);
  EXPECT_EQ(layout.pages[0].height, 1024);
  EXPECT_EQ(layout.face_page[0], 0u);
  const TexCoord& corner = layout.texcoords[layout.face_texcoords[0][2]];
  EXPECT_EQ(corner.u, 0.25f);
  EXPECT_EQ(corner.v, 0.25f) << "from the top";
  EXPECT_FALSE(layout.has_udim_tiles);
  EXPECT_EQ(layout.repeated_faces, 0u);
}

TEST(LayOut, GivesUdimTilesPagesOfTheirOwn) {
  Stated uv;
  uv.materials = {{"rock", 512, 256}};
  uv.add({0, 0}, {1, 0}, {0, 1}, 0).add({1, 0}, {2, 0}, {1, 1}, 0).add({2.5, 3.25}, {3, 3.5}, {2.75, 4}, 0);
  const UvLayout layout = lay_out(uv, {8192, true});
  EXPECT_TRUE(layout.has_udim_tiles);
  ASSERT_EQ(layout.pages.size(), 3u);
  EXPECT_EQ(layout.pages[0].suffix, ".1001");
  EXPECT_EQ(layout.pages[1].suffix, ".1002");
  EXPECT_EQ(layout.pages[2].suffix, ".1033");
  EXPECT_EQ(layout.pages[2].material, "rock.1033");
  EXPECT_EQ(layout.pages[2].width, 512);
  EXPECT_EQ(layout.pages[2].height, 256);
  EXPECT_EQ(layout.face_page, (std::vector<std::uint32_t>{0, 1, 2}));
  const TexCoord& corner = layout.texcoords[layout.face_texcoords[2][0]];
  EXPECT_EQ(corner.u, 0.5f);
  EXPECT_EQ(corner.v, 0.75f);
  EXPECT_EQ(layout.obj_texcoords[layout.face_texcoords[2][0]], (std::array{2.5, 3.25})) << "as they were stated";
}

TEST(LayOut, HasACornerOnTheRimOfTwoTilesInBoth) {
  Stated uv;
  uv.texcoords = {{0.5, 0}, {1, 0}, {1, 1}, {1.5, 0.5}};
  uv.face_texcoords = {{0, 1, 2}, {1, 3, 2}};
  const UvLayout layout = lay_out(uv, {});
  EXPECT_EQ(layout.face_page, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(layout.texcoords[layout.face_texcoords[0][1]].u, 1.0f);
  EXPECT_EQ(layout.texcoords[layout.face_texcoords[1][0]].u, 0.0f);
  EXPECT_EQ(layout.obj_texcoords.size(), layout.texcoords.size());
  EXPECT_EQ(layout.obj_texcoords[layout.face_texcoords[1][0]], (std::array{1.0, 0.0}));
}

TEST(LayOut, NamesThePagesOfMaterials) {
  Stated uv;
  uv.materials = {{"Roof tiles", 0, 0}, {"roof/tiles", 100, 300}, {"", 0, 0}};
  uv.add({0, 0}, {1, 0}, {0, 1}, 0).add({0, 0}, {1, 0}, {0, 1}, 1).add({0, 0}, {1, 0}, {0, 1}, 2);
  const UvLayout layout = lay_out(uv, {600, false});
  ASSERT_EQ(layout.pages.size(), 3u);
  EXPECT_EQ(layout.pages[0].suffix, "_Roof_tiles");
  EXPECT_EQ(layout.pages[1].suffix, "_roof_tiles_2") << "a name where upper and lower case are the same";
  EXPECT_EQ(layout.pages[1].material, "roof/tiles");
  EXPECT_EQ(layout.pages[2].suffix, "_page_2");
  EXPECT_EQ(layout.pages[1].width, 200) << "as its image is shaped";
  EXPECT_EQ(layout.pages[1].height, 600);
}

TEST(LayOut, TakesNegativeCoordinatesForATextureThatRepeats) {
  const UvLayout layout = lay_out(Stated().add({-1, 0}, {-0.5, 0}, {-1, 1}).add({1.25, 0}, {2, 0}, {1.25, 1}), {});
  EXPECT_FALSE(layout.has_udim_tiles);
  EXPECT_EQ(layout.repeated_faces, 2u);
  ASSERT_EQ(layout.pages.size(), 1u);
  EXPECT_EQ(layout.texcoords[layout.face_texcoords[0][1]].u, 0.5f);
  EXPECT_EQ(layout.texcoords[layout.face_texcoords[1][0]].u, 0.25f);
  EXPECT_EQ(layout.obj_texcoords[layout.face_texcoords[1][0]][0], 1.25);
}

TEST(LayOut, LeavesFacesWithoutCoordinatesOut) {
  Stated uv;
  uv.add({0, 0}, {1, 0}, {0, 1});
  uv.face_texcoords.push_back({0, 1, StatedUv::kNone});
  uv.texcoords.push_back({std::numeric_limits<double>::quiet_NaN(), 0});
  uv.face_texcoords.push_back({0, 1, 3});
  uv.face_material.resize(3, StatedUv::kNone);
  const UvLayout layout = lay_out(uv, {});
  EXPECT_EQ(layout.face_page, (std::vector<std::uint32_t>{0, kNoPage, kNoPage}));
}

TEST(LayOut, TakesWhatRoundingLeftBeyondTheRim) {
  const UvLayout layout = lay_out(Stated().add({-1e-7, 0}, {1.0000001, 0}, {0, 1.00001}), {});
  EXPECT_FALSE(layout.has_udim_tiles);
  EXPECT_EQ(layout.texcoords[0].u, 0.0f);
  EXPECT_EQ(layout.texcoords[1].u, 1.0f);
  EXPECT_EQ(layout.texcoords[2].v, 0.0f);
}

TEST(LayOut, MakesNoPageLargerThanPagesCanBe) {
  Stated uv;
  uv.materials = {{"long", 65536, 100}};
  const UvLayout layout = lay_out(uv.add({0, 0}, {1, 0}, {0, 1}, 0), {});
  EXPECT_EQ(layout.pages[0].width, 32768);
  EXPECT_EQ(layout.pages[0].height, 50);
}

TEST(LayOut, RefusesFacesAcrossTheRim) {
  const std::string why = refusal(Stated().add({0, 0}, {1, 0}, {0, 1}).add({0.5, 0}, {1.5, 0}, {0.5, 1}));
  EXPECT_TRUE(contains(why, "model.obj: face 1"));
  EXPECT_TRUE(contains(why, "u = 0.5 to 1.5"));
}

/// A model of two triangles and its image.
class ReadUv : public testing::Test {
 protected:
  void SetUp() override {
    Image image{48, 32, 3, {}};
    image.pixels.assign(48 * 32 * 3, 90);
    write_image(folder_.path() / "wall.png", image, ImageFormat::png, 90);
    std::ofstream(folder_.path() / "in.mtl") << "newmtl wall\nmap_Kd wall.png\nnewmtl bare\nKd 1 1 1\n";
    std::ofstream(in_) << "mtllib in.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                          "vt 0.1234567891 0.000000123456789\nvt 0.9 0.1\nvt 0.7 0.33333333\n"
                          "usemtl wall\nf 1/1 2/2 3/3 4/1\nusemtl bare\nf 1/1 3/2 4/3\nf 1 2 4\n";
  }
  test::TemporaryFolder folder_;
  std::filesystem::path in_ = folder_.path() / "in.obj";
};

TEST_F(ReadUv, HasTheFacesOfTheMesh) {
  const StatedUv uv = read_uv(in_);
  const Mesh mesh = read_mesh(in_);
  ASSERT_EQ(uv.face_texcoords.size(), mesh.faces.size());
  ASSERT_EQ(uv.materials.size(), 2u);
  EXPECT_EQ(uv.materials[0].name, "wall");
  EXPECT_EQ(uv.materials[0].width, 48);
  EXPECT_EQ(uv.materials[0].height, 32);
  EXPECT_EQ(uv.materials[1].name, "bare");
  EXPECT_EQ(uv.materials[1].width, 0);
  EXPECT_EQ(uv.face_material, (std::vector<std::uint32_t>{0, 0, 1, 1}));
  EXPECT_EQ(uv.texcoords[0], (std::array{0.1234567891, 0.000000123456789}));
  EXPECT_EQ(uv.face_texcoords[3], (Triangle{StatedUv::kNone, StatedUv::kNone, StatedUv::kNone}));
}

/// The lines of a file that begin with a word.
std::vector<std::string> lines_of(const std::filesystem::path& file, const std::string& word) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(word + " ")) lines.push_back(line);
  return lines;
}

TEST_F(ReadUv, ComesBackFromAnObjAndAGlbAsItWas) {
  const Mesh mesh = read_mesh(in_);
  const UvLayout layout = lay_out(read_uv(in_), {64, true}, in_);
  TexturedModel model{&mesh, layout.texcoords, layout.face_texcoords, layout.face_page, layout.obj_texcoords};
  std::vector<PageFile> pages;
  for (const UvPage& page : layout.pages)
    pages.push_back({folder_.path() / "wall.png", ImageFormat::png, {}, {}, page.material});
  const auto obj = folder_.path() / "out.obj";
  write_obj(obj, model, pages, {});
  const std::vector<std::string> vt = lines_of(obj, "vt");
  ASSERT_EQ(vt.size(), 3u);
  EXPECT_EQ(vt[2], "vt 0.7 0.33333333");
  EXPECT_EQ(read_uv(obj).texcoords, read_uv(in_).texcoords) << "no digit lost";
  EXPECT_EQ(lines_of(obj, "usemtl"), (std::vector<std::string>{"usemtl wall", "usemtl bare", "usemtl untextured"}));
  EXPECT_EQ(lines_of(folder_.path() / "out.mtl", "newmtl"),
            (std::vector<std::string>{"newmtl wall", "newmtl bare", "newmtl untextured"}));

  const GltfFiles files = write_gltf(folder_.path() / "out", GltfContainer::glb, model, pages, {});
  const StatedUv glb = read_uv(files.file);
  ASSERT_EQ(glb.face_texcoords.size(), 3u) << "without the face that has none";
  EXPECT_EQ(glb.materials[0].name, "wall");
  EXPECT_EQ(glb.materials[0].width, 48);
  const UvLayout again = lay_out(glb, {64, true});
  for (std::size_t t = 0; t < files.faces.size(); ++t) {
    const std::size_t face = index(files.faces[t]);
    for (std::size_t i = 0; i < 3; ++i) {
      const TexCoord &was = layout.texcoords[layout.face_texcoords[face][i]],
                     &is = again.texcoords[again.face_texcoords[t][i]];
      EXPECT_EQ(is.u, was.u);
      EXPECT_EQ(is.v, was.v);
    }
  }
}

TEST_F(ReadUv, TakesThoseOfCornersOrOfVerticesFromAPly) {
  const auto ply = folder_.path() / "mesh.ply";
  const std::string vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  std::ofstream(ply) << "ply\nformat ascii 1.0\ncomment TextureFile wall.png\ncomment TextureFile other.png\n"
                     << vertices
                     << "element face 3\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
                        "property uchar texnumber\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
                        "3 0 1 2 6 0 0 0.5 0 0.5 0.5 1\n3 0 2 3 6 0 0 0.5 0.5 0 0.25 0\n3 1 2 3 0 0\n";
  const StatedUv corners = read_uv(ply);
  EXPECT_EQ(corners.texcoords.size(), 4u) << "the corners that two faces share are one";
  EXPECT_EQ(corners.face_texcoords[0], (Triangle{0, 1, 2}));
  EXPECT_EQ(corners.face_texcoords[1], (Triangle{0, 2, 3}));
  EXPECT_EQ(corners.face_texcoords[2], (Triangle{StatedUv::kNone, StatedUv::kNone, StatedUv::kNone}));
  EXPECT_EQ(corners.texcoords[3], (std::array{0.0, 0.25})) << "v upwards, as an OBJ has it";
  EXPECT_EQ(corners.face_material, (std::vector<std::uint32_t>{1, 0, 0}));
  ASSERT_EQ(corners.materials.size(), 2u);
  EXPECT_EQ(corners.materials[0].name, "wall");
  EXPECT_EQ(corners.materials[0].width, 48);
  EXPECT_EQ(corners.materials[1].width, 0) << "there is no such image";

  std::ofstream(ply) << "ply\nformat ascii 1.0\n"
                     << vertices
                     << "property float t\nproperty float s\nelement face 2\nproperty list uchar int vertex_indices\n"
                        "end_header\n0 0 0 0 0\n1 0 0 0 0.5\n1 1 0 0.75 0.5\n0 1 0 0.75 0\n3 0 1 2\n3 0 2 3\n";
  const StatedUv by_vertex = read_uv(ply);
  EXPECT_EQ(by_vertex.texcoords.size(), 4u);
  EXPECT_EQ(by_vertex.texcoords[by_vertex.face_texcoords[0][2]], (std::array{0.5, 0.75})) << "s is u";
  EXPECT_EQ(by_vertex.face_texcoords[1], (Triangle{0, 2, 3}));
}

TEST_F(ReadUv, RefusesFormatsWithoutTextureCoordinates) {
  const auto ply = folder_.path() / "mesh.stl";
  std::filesystem::copy_file(in_, ply);
  try {
    read_uv(ply);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_TRUE(contains(error.what(), "expected a model with texture coordinates, .obj, .ply, .glb or .gltf"));
  }
}

}  // namespace
}  // namespace gpvc::io
