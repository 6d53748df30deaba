// Meshes in several files, and the metadata.xml beside them.
#include <gtest/gtest.h>

#include "io/mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;

const char* kTile = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\n";
const char* kSquare = "v 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nf 1 2 3 4\n";

TEST(MeshFolder, TilesAreReadAsOneMeshByTheirPaths) {
  const test::TemporaryFolder folder;
  folder.write("Data/Tile_1/Tile_1.OBJ", kSquare);
  folder.write("Data/Tile_0/Tile_0.obj", kTile);
  folder.write("Data/Tile_0/Tile_0.mtl", "newmtl a\n");
  folder.write("Data/out/run.json", "{}");
  folder.write("Data/out/model.obj", kTile);
  folder.write("Data/Tile_0/._Tile_0.obj", "Mac OS X        ATTR");
  const std::vector<std::filesystem::path> files = mesh_files(folder.path());
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].filename(), "Tile_0.obj");
  EXPECT_EQ(files[1].filename(), "Tile_1.OBJ");
  const Mesh mesh = read_mesh(folder.path());
  ASSERT_EQ(mesh.positions.size(), 8u);
  EXPECT_EQ(mesh.positions[4].x, 5);
  EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{0, 1, 2}, {4, 5, 6}, {4, 6, 7}}));
  EXPECT_EQ(mesh.source_face, (std::vector<std::uint32_t>{0, 1, 1}));
  EXPECT_EQ(mesh_files(files[0]), std::vector{files[0]});
}

TEST(MeshFolder, WithoutAMeshIsRefused) {
  const test::TemporaryFolder folder;
  folder.write("a.stl", "solid");
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.path()); }), "holds no mesh, expected files .ply or .obj"));
}

TEST(MeshFolder, WithVersionsOfOneMeshIsRefused) {
  const test::TemporaryFolder folder;
  const auto roof = folder.write("meshing/odm_25dmesh.obj", "v 0 0 0\nv 9.5 0 0\nv 0 10 1\nf 1 2 3\n"),
             whole = folder.write("meshing/odm_mesh.obj", "v 0 0 0\nv 10 0 0\nv 0 10 1.2\nv 99 99 99\nf 1 2 3\n");
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.path()); }),
                       "odm_mesh.obj: fills the same place as " + roof.string() +
                           ", as another version of the same mesh does; name the one that is meant"));
  const std::vector<std::vector<std::filesystem::path>> each{{roof}, {whole}};
  EXPECT_EQ(read_meshes(each).size(), 2u) << "given one by one";
  // Of the height they have less than 80 % in common, as storeys; flat ones lie in other planes.
  folder.write("meshing/odm_mesh.obj", "v 0 0 0\nv 10 0 0\nv 0 10 1.3\nf 1 2 3\n");
  EXPECT_EQ(read_mesh(folder.path()).faces.size(), 2u);
  folder.write("meshing/odm_25dmesh.obj", "v 0 0 5\nv 9 0 5\nv 0 9 5\nf 1 2 3\n");
  folder.write("meshing/odm_mesh.obj", "v 0 0 6\nv 9 0 6\nv 0 9 6\nf 1 2 3\n");
  EXPECT_EQ(read_mesh(folder.path()).faces.size(), 2u);
  folder.write("meshing/odm_mesh.obj", "v 0 0 5\nv 9 0 5\nv 0 9 5\nf 1 2 3\n");
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.path()); }), "fills the same place"));
}

TEST(MeshFolder, TheFirstFileThatIsNoMeshIsNamed) {
  const test::TemporaryFolder folder;
  for (int tile = 10; tile < 60; ++tile)
    folder.write("t" + std::to_string(tile) + ".obj", tile == 20 || tile == 55 ? "v 0 0 0\nf 1 2 3\n" : kTile);
  EXPECT_TRUE(contains(input_error([&] { read_mesh(folder.path()); }), "t20.obj: "));
}

TEST(MeshOrigins, AreThoseOfMetadataXmlBesideOrAboveTheMesh) {
  const test::TemporaryFolder folder;
  const auto tile = folder.write("Data/Tile_0/Tile_0.obj", kTile);
  EXPECT_FALSE(read_mesh_origin(tile));
  const auto file =
      folder.write("metadata.xml",
                   "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<ModelMetadata version=\"1\">\n<SRS>EPSG:32631</SRS>\n"
                   "<SRSOrigin>448000.5,5411000, -2</SRSOrigin>\n</ModelMetadata>\n");
  for (const auto& mesh : {tile, folder.path(), folder.path() / "Data"}) {
    const auto origin = read_mesh_origin(mesh);
    ASSERT_TRUE(origin) << mesh;
    EXPECT_EQ(origin->srs, "EPSG:32631");
    EXPECT_EQ(origin->origin, (WorldPoint{448000.5, 5411000, -2}));
    EXPECT_EQ(origin->file.filename(), "metadata.xml");
  }
  // Both as links, as programs that lay out their inputs make them.
  const test::TemporaryFolder staged;
  std::filesystem::create_symlink(tile, staged.path() / "mesh.obj");
  ASSERT_TRUE(read_mesh_origin(staged.path() / "mesh.obj"));
  const auto own =
      staged.write("elsewhere/metadata.xml", "<ModelMetadata><SRSOrigin>7,8,9</SRSOrigin></ModelMetadata>");
  std::filesystem::create_symlink(own, staged.path() / "metadata.xml");
  EXPECT_EQ(read_mesh_origin(staged.path() / "mesh.obj")->origin, (WorldPoint{7, 8, 9})) << "the one beside the link";
  folder.write("metadata.xml", "<other><SRSOrigin>1,2,3</SRSOrigin></other>");
  EXPECT_FALSE(read_mesh_origin(tile)) << "of another program";
  folder.write("metadata.xml", "<ModelMetadata><SRSOrigin>1,2</SRSOrigin></ModelMetadata>");
  EXPECT_TRUE(contains(input_error([&] { read_mesh_origin(tile); }),
                       "metadata.xml: line 1: expected SRSOrigin to be three numbers"));
}

}  // namespace
}  // namespace gpvc::io
