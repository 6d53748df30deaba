// gpvc-texrecon beside the rules of those who call texrecon and read its files.
#include <array>
#include <set>

#include "app/texrecon/view_numbers.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

Outcome run_texrecon(const std::vector<std::string>& words) { return Program(words, {}, GPVC_TEXRECON).wait(); }

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

struct ObjFile {
  std::vector<std::string> vertices;  ///< lines
  std::size_t faces = 0;
  std::vector<std::string> materials;        ///< in the order of usemtl
  std::map<std::string, std::string> pages;  ///< map_Kd by material
  std::set<std::string> without_faces;       ///< materials
};

/// Reads PREFIX.obj and its MTL, and holds them against the rules of odm_orthophoto (OdmOrthoPhoto::loadObjFile, isModelOk), of
/// opendm's objpacker and gltf.py, all of github.com/OpenDroneMap, and of Obj2Tiles (MeshUtils.LoadMesh).
ObjFile read_by_the_rules(const fs::path& prefix) {
  ObjFile obj;
  std::string material;
  std::istringstream mtl(read_file(prefix.string() + ".mtl"));
  bool complete = true;  // objpacker copies a material up to its map_Kd
  for (std::string line; std::getline(mtl, line);) {
    const auto words = words_of(line);
    if (words.empty()) continue;
    if (words[0] == "newmtl") {
      EXPECT_EQ(words.size(), 2u) << "a name is one word";
      material = words[1];
      complete = false;
    } else {
      EXPECT_FALSE(complete) << "map_Kd comes last: " << line;
    }
    if (words[0] != "map_Kd") continue;
    EXPECT_EQ(words.size(), 2u) << "objpacker takes the blanks out of a file's name";
    EXPECT_TRUE(fs::exists(prefix.parent_path() / words[1])) << words[1];
    obj.pages[material] = words[1];
    complete = true;
  }
  for (const auto& [name, page] : obj.pages) obj.without_faces.insert(name);
  std::size_t texcoords = 0, slashes = 0;
  std::map<std::size_t, std::string> material_of_texcoord;
  std::istringstream in(read_file(prefix.string() + ".obj"));
  for (std::string line; std::getline(in, line);) {
    const auto words = words_of(line);
    if (words.empty()) continue;
    if (words[0] == "v") {
      EXPECT_TRUE(obj.materials.empty());
      obj.vertices.push_back(line);
      for (std::size_t i = 1; i < words.size(); ++i) EXPECT_EQ(words[i].size() - words[i].find('.'), 7u) << line;
    } else if (words[0] == "vt") {
      EXPECT_TRUE(obj.materials.empty()) << "odm_orthophoto looks for all of them before the first material";
      ++texcoords;
      for (std::size_t i = 1; i < words.size(); ++i) {
        EXPECT_GE(std::stod(words[i]), 0) << "Obj2Tiles wraps what lies outside of 0 to 1";
        EXPECT_LE(std::stod(words[i]), 1);
      }
    } else if (words[0] == "usemtl") {
      EXPECT_TRUE(obj.pages.contains(words[1]));
      EXPECT_EQ(std::ranges::count(obj.materials, words[1]), 0) << "odm_orthophoto decodes a page for each usemtl";
      obj.materials.push_back(words[1]);
    } else if (words[0] == "f") {
      EXPECT_EQ(words.size(), 4u);
      EXPECT_FALSE(obj.materials.empty()) << "gltf.py has no material for such faces";
      ++obj.faces;
      obj.without_faces.erase(obj.materials.back());
      for (std::size_t i = 1; i < 4; ++i) {
        const std::size_t count = static_cast<std::size_t>(std::ranges::count(words[i], '/'));
        if (slashes == 0) slashes = count;
        EXPECT_EQ(count, slashes) << "all faces have one form";
        EXPECT_LE(std::stoul(words[i]), obj.vertices.size());
        const std::size_t t = std::stoul(words[i].substr(words[i].find('/') + 1));
        EXPECT_LE(t, texcoords);
        const auto [known, added] = material_of_texcoord.emplace(t, obj.materials.back());
        EXPECT_TRUE(added || known->second == obj.materials.back())
            << "objpacker moves each of them once for a material";
      }
    }
  }
  EXPECT_NE(texcoords, obj.vertices.size()) << "odm_orthophoto would take them for those of the vertices";
  EXPECT_TRUE(obj.without_faces.empty()) << "objpacker asks for the faces of every material";
  return obj;
}

class Texrecon : public App {
 protected:
  void SetUp() override {
    App::SetUp();
    if (IsSkipped()) return;
    ASSERT_EQ(
        run({"convert", (scene_ / "colmap").string(), "--undistort", "--format", "nvm", "-o", nvm_.string()}).exit_code,
        0);
    fs::create_directory(odm_);
  }
  std::vector<std::string> words(const fs::path& prefix, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{(nvm_ / "scene.nvm").string(), (scene_ / "mesh.ply").string(), prefix.string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(odm_)) found.insert(entry.path().filename().string());
    return found;
  }
  fs::path nvm_ = folder_.path() / "nvm", odm_ = folder_.path() / "odm texturing", prefix_ = odm_ / "model_geo";
};

TEST_F(Texrecon, LeavesTheFilesOfTexreconByTheRulesOfTheirReaders) {
  const Outcome outcome =
      run_texrecon(words(prefix_, {"-d", "gmi", "-o", "gauss_clamping", "-t", "none", "--num_threads=2",
                                   "--max_texture_size=512", "--write_timings", "-v"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const ObjFile obj = read_by_the_rules(prefix_);
  EXPECT_GT(obj.pages.size(), 1u);
  const Mesh mesh = io::read_mesh(scene_ / "mesh.ply");
  EXPECT_EQ(obj.vertices.size(), mesh.positions.size());
  EXPECT_GT(obj.faces, mesh.faces.size() / 2);
  EXPECT_EQ(fs::file_size(prefix_.string() + "_labeling.vec"), 8 * mesh.faces.size());
  EXPECT_TRUE(contains(read_file(prefix_.string() + ".conf"), "Outlier removal method: \tgauss_clamping\n"));
  EXPECT_TRUE(contains(read_file(prefix_.string() + "_timings.csv"), "bake, "));
  read_by_the_rules(prefix_.string() + "_view_selection");
  for (const auto& [material, page] : obj.pages) {
    EXPECT_TRUE(material.starts_with("material000") && page == "model_geo_" + material + "_map_Kd.png");
    EXPECT_EQ(io::read_image(odm_ / page).channels, 3);
  }
  // A smaller result replaces all of it, and leaves nothing of the larger.
  const Outcome again = run_texrecon(words(prefix_));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_FALSE(fs::exists(prefix_.string() + "_material0001_map_Kd.png"));
  for (const std::string& name : names()) EXPECT_FALSE(name.starts_with(".")) << name;
}

TEST_F(Texrecon, AnotherBandTakesTheLabelsOfTheFirst) {
  ASSERT_EQ(run_texrecon(words(prefix_, {"--keep_unseen_faces"})).exit_code, 0);
  const std::string labels = prefix_.string() + "_labeling.vec";
  // The same photos, grey, under names whose order is another.
  std::string nvm = read_file(nvm_ / "scene.nvm");
  const Scene scene = io::read_scene(nvm_ / "scene.nvm", {});
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    Image photo = io::read_image(scene.views[v].photo), grey{photo.width, photo.height, 1, {}};
    for (std::size_t i = 0; i < photo.pixels.size(); i += 3) grey.pixels.push_back(photo.pixels[i]);
    const std::string name = std::string(1, static_cast<char>('z' - v)) + "_nir.png";
    io::write_image(nvm_ / name, grey, io::ImageFormat::png, 0);
    const std::string before = scene.views[v].photo.lexically_relative(nvm_).string();
    for (std::size_t at = nvm.find(before); at != std::string::npos; at = nvm.find(before))
      nvm.replace(at, before.size(), name);
  }
  folder_.write("nvm/nir.nvm", nvm);
  auto band = words(odm_ / "nir", {"-L", labels, "--keep_unseen_faces", "--no_intermediate_results"});
  band[0] = (nvm_ / "nir.nvm").string();
  const Outcome outcome = run_texrecon(band);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const ObjFile first = read_by_the_rules(prefix_), second = read_by_the_rules(odm_ / "nir");
  EXPECT_TRUE(first.vertices == second.vertices);
  EXPECT_EQ(first.faces, second.faces);
  EXPECT_FALSE(fs::exists(odm_ / "nir_labeling.vec"));
  const std::string page = read_file(odm_ / second.pages.begin()->second);
  ASSERT_GT(page.size(), 26u);
  EXPECT_EQ(page[25], 0) << "PNG's colour type of grey";
  // Faces show the views that they were given: chosen again with them, they are the same.
  ASSERT_EQ(run_texrecon(words(odm_ / "again", {"-L", labels, "-v", "--keep_unseen_faces"})).exit_code, 0);
  ASSERT_EQ(run_texrecon(words(odm_ / "first", {"-v", "--keep_unseen_faces"})).exit_code, 0);
  const auto faces = [&](const char* name) {
    const std::string obj = read_file(odm_ / name);
    return obj.substr(obj.find("usemtl"));
  };
  EXPECT_TRUE(faces("again_view_selection.obj") == faces("first_view_selection.obj"));
}

TEST_F(Texrecon, NadirModeWritesEveryFace) {
  const Outcome outcome = run_texrecon(words(prefix_, {"--nadir_mode"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_by_the_rules(prefix_).faces, io::read_mesh(scene_ / "mesh.ply").faces.size());
}

TEST_F(Texrecon, RefusesInOneSentenceAndLeavesNothing) {
  const auto expect = [&](const Outcome& outcome, const std::string& what) {
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "gpvc-texrecon: error: ")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, what)) << outcome.err;
    EXPECT_EQ(names(), std::set<std::string>());
  };
  expect(run_texrecon({}), "expected IN_SCENE IN_MESH OUT_PREFIX");
  expect(run_texrecon(words(prefix_, {"--bogus"})), "there is no option --bogus");
  expect(run_texrecon(words(folder_.path() / "nowhere" / "model")), "nowhere");
  auto no_mesh = words(prefix_);
  no_mesh[1] = "nowhere.ply";
  expect(run_texrecon(no_mesh), "nowhere.ply");
  auto no_scene = words(prefix_);
  no_scene[0] = "nowhere.nvm";
  expect(run_texrecon(no_scene), "nowhere.nvm");
  const std::string labels = folder_.write("short.vec", "12345678").string();
  expect(run_texrecon(words(prefix_, {"-L", labels})), "is 8 bytes long: expected 8 for each of the mesh's");
}

}  // namespace
}  // namespace gpvc
