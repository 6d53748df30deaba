#include "app/texrecon/texrecon.h"

#include <gtest/gtest.h>

#include "labeling/labeling.h"

namespace gpvc::texrecon {
namespace {

Arguments read(const std::vector<std::string>& words) {
  Arguments arguments;
  EXPECT_EQ(read_arguments(words, arguments), Request::run);
  return arguments;
}

std::string complaint(const std::vector<std::string>& words) {
  Arguments arguments;
  try {
    read_arguments(words, arguments);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "none";
}

TEST(TexreconArguments, AreReadAsOpenDroneMapGivesThem) {
  // opendm's stages/mvstex.py, with empty words where an option is left out.
  const Arguments a = read({"rec.nvm", "mesh.ply", "out/odm_textured_model_geo", "-d", "gmi", "-o", "gauss_clamping",
                            "-t", "none", "--no_intermediate_results", "", "", "--nadir_mode", "-L", "a b.vec",
                            "--num_threads=2", "--max_texture_size=24576"});
  EXPECT_EQ(a.scene, "rec.nvm");
  EXPECT_EQ(a.mesh, "mesh.ply");
  EXPECT_EQ(a.prefix, "out/odm_textured_model_geo");
  EXPECT_EQ(a.data_term, DataTerm::gmi);
  EXPECT_EQ(a.outliers, labeling::Outliers::clamp);
  EXPECT_EQ(a.tone_mapping, ToneMapping::none);
  EXPECT_FALSE(a.intermediate_results);
  EXPECT_TRUE(a.nadir);
  EXPECT_FALSE(a.keep_unseen);
  EXPECT_EQ(a.labels, "a b.vec");
  EXPECT_EQ(a.threads, 2);
  EXPECT_EQ(a.max_texture_size, 24576);
}

TEST(TexreconArguments, HaveEveryFormThatTheirParserHad) {
  const Arguments a = read({"-dgmi", "--outlier_removal=gauss_damping", "-v", "s", "--keep_unseen", "--", "-m", "-p"});
  EXPECT_EQ(a.data_term, DataTerm::gmi);
  EXPECT_EQ(a.outliers, labeling::Outliers::damp);
  EXPECT_TRUE(a.view_selection_model);
  EXPECT_TRUE(a.keep_unseen);
  EXPECT_EQ(a.mesh, "-m");
  EXPECT_EQ(a.prefix, "-p");
  EXPECT_EQ(read({"s", "m", "p", "-vd", "area"}).data_term, DataTerm::area);
  EXPECT_TRUE(read({"s", "m", "p", "--skip_h"}).global_leveling);
  EXPECT_FALSE(read({"s", "m", "p", "--skip_global"}).global_leveling);
}

TEST(TexreconArguments, RefusesOtherWordsInOneSentence) {
  EXPECT_EQ(complaint({"s", "m"}), "expected IN_SCENE IN_MESH OUT_PREFIX, got 2 arguments");
  EXPECT_EQ(complaint({"s", "m", "p", "--bogus"}), "there is no option --bogus");
  EXPECT_EQ(complaint({"s", "m", "p", "-x"}), "there is no option -x in -x");
  EXPECT_EQ(complaint({"s", "m", "p", "-d"}), "-d takes a value: -d area|gmi");
  EXPECT_EQ(complaint({"s", "m", "p", "-d", "sharp"}), "--data_term takes one of area, gmi; got 'sharp'");
  EXPECT_EQ(complaint({"s", "m", "p", "--nadir_mode=1"}), "--nadir_mode takes no value, got '1'");
  EXPECT_EQ(complaint({"s", "m", "p", "--num_threads"}), "--num_threads takes a value: --num_threads=N");
  EXPECT_EQ(complaint({"s", "m", "p", "--num_threads=two"}), "--num_threads takes a number from -1 to 4096, got 'two'");
  EXPECT_NE(complaint({"s", "m", "p", "--skip"}).find("may be"), std::string::npos);
  EXPECT_NE(complaint({"s", "m", "out/"}).find("names a folder"), std::string::npos);
}

TEST(Texrecon, LeavesOutTheFirstOfTwoFacesWithTheSameVertices) {
  Mesh mesh;
  mesh.positions.resize(5);
  mesh.faces = {{0, 1, 2}, {1, 2, 3}, {2, 1, 0}, {1, 3, 2}, {2, 3, 4}};
  EXPECT_EQ(remove_redundant_faces(mesh), 2u);
  EXPECT_EQ(mesh.faces, (std::vector<Triangle>{{2, 1, 0}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(remove_redundant_faces(mesh), 0u);
}

TEST(Texrecon, WritesHolesInsideTheMeshAndNothingUnseenAtItsBorder) {
  // A grid of 4 x 4 squares, two faces each.
  Mesh mesh;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) mesh.positions.push_back({double(x), double(y), 0});
  for (std::uint32_t y = 0; y < 4; ++y)
    for (std::uint32_t x = 0; x < 4; ++x) {
      const std::uint32_t a = 5 * y + x;
      mesh.faces.push_back({a, a + 1, a + 6});
      mesh.faces.push_back({a, a + 6, a + 5});
    }
  const labeling::FaceGraph graph = labeling::face_graph(mesh);
  std::vector<labeling::FaceTag> tags(mesh.faces.size(), labeling::FaceTag::seen);
  const std::size_t inside = 2 * (4 * 1 + 1) + 1, corner = 2 * (4 * 3 + 3) + 1;  // a vertex of neither is another's
  tags[inside] = labeling::FaceTag::unseen;
  tags[corner] = labeling::FaceTag::background;
  const auto written = [&](bool keep, bool fill) { return written_faces(mesh, graph, tags, keep, fill); };
  EXPECT_EQ(written(false, true)[inside], 1);
  EXPECT_EQ(written(false, true)[corner], 0);
  EXPECT_EQ(written(false, false)[inside], 0);
  EXPECT_EQ(written(true, false)[corner], 1);
  EXPECT_EQ(written(false, false)[0], 1);
}

}  // namespace
}  // namespace gpvc::texrecon
