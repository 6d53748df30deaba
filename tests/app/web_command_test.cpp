// gpvc texture and tileset for the web, from a scene to files.
#include <algorithm>

#include "io/images.h"
#include "io/textured_model.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

using namespace test;
using Json = nlohmann::json;

Json json_of(const fs::path& glb) {
  const std::string bytes = read_file(glb);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  return Json::parse(bytes.substr(20, length));
}

class WebCommand : public App {
 protected:
  void textured(const std::vector<std::string>& more, const fs::path& out) const {
    std::vector<std::string> words = texture(out, {"--target", "web"});
    words.insert(words.end(), more.begin(), more.end());
    const test::Outcome outcome = run(words);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  void textured(const std::vector<std::string>& more) const { textured(more, out_); }
  std::uintmax_t bytes() const { return fs::file_size(out_ / "model.glb"); }
  Json figures() const { return run_json(out_)["counts"]["web"]; }
};

TEST_F(WebCommand, HasTheFacesAndThePlacesOfTheFullModel) {
  const fs::path full = folder_.path() / "full";
  ASSERT_EQ(run(texture(full, {"--max-pages", "1"})).exit_code, 0);
  textured({});
  EXPECT_LT(2 * bytes(), fs::file_size(full / "model.glb"));
  const io::LoadedModel a = io::read_textured_model(full / "model.glb"),
                        b = io::read_textured_model(out_ / "model.glb");
  const auto faces_a = npy<std::uint32_t>(full / "faces.npy"), faces_b = npy<std::uint32_t>(out_ / "faces.npy");
  ASSERT_EQ(faces_a.size(), faces_b.size());
  std::vector<std::size_t> at(a.mesh.faces.size() + faces_a.size());
  for (std::size_t t = 0; t < faces_a.size(); ++t) at[faces_a[t]] = t;
  const auto middle = [](const io::LoadedModel& model, std::size_t t) {
    WorldPoint sum;
    for (const std::uint32_t v : model.mesh.faces[t])
      for (auto axis : {&WorldPoint::x, &WorldPoint::y, &WorldPoint::z}) sum.*axis += model.mesh.positions[v].*axis / 3;
    return sum;
  };
  for (std::size_t t = 0; t < faces_b.size(); ++t) {
    const WorldPoint p = middle(a, at[faces_b[t]]), q = middle(b, t);
    EXPECT_NEAR(p.x, q.x, 2e-3);
    EXPECT_NEAR(p.y, q.y, 2e-3);
    EXPECT_NEAR(p.z, q.z, 2e-3);
  }
  // The same page, less what WebP loses.
  ASSERT_EQ(b.pages.size(), 1u);
  ASSERT_EQ(b.pages[0].pixels.size(), a.pages[0].pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.pages[0].pixels.size(); ++i)
    sum += std::abs(a.pages[0].pixels[i] - b.pages[0].pixels[i]);
  EXPECT_LT(sum / static_cast<double>(a.pages[0].pixels.size()), 4);
  EXPECT_EQ(run_json(out_)["options"]["max_pages"], 1);
  EXPECT_EQ(run_json(out_)["options"]["max_bytes"], 150000000);
  EXPECT_EQ(figures()["bytes"], bytes());
  EXPECT_EQ(read_file(out_ / "model.obj"), read_file(full / "model.obj")) << "whoever works on with it has all";
}

TEST_F(WebCommand, StaysBelowItsBytes) {
  textured({});
  const std::uintmax_t free = bytes();
  const std::size_t texels = figures()["page_bytes"];
  for (const double share : {0.9, 0.6}) {
    const auto most = static_cast<std::size_t>(share * static_cast<double>(free));
    textured({"--max-bytes", std::to_string(most), "--force"});
    EXPECT_LE(bytes(), most) << share;
    EXPECT_GT(bytes(), most / 4) << share;
    EXPECT_LT(figures()["page_bytes"], texels);
    EXPECT_GT(run_json(out_)["options"]["max_texels"], 0) << "the atlas has been told";
  }
  // What has no room beside the geometry leaves the earlier result as it was.
  const std::string before = read_file(out_ / "model.glb");
  const test::Outcome refused = run(texture(out_, {"--target", "web", "--max-bytes", "20K", "--force"}));
  expect_one_sentence(refused, "model.glb: would have ", "are allowed; allow more by --max-bytes SIZE");
  EXPECT_TRUE(read_file(out_ / "model.glb") == before);
}

TEST_F(WebCommand, HasTheQualityThatIsAskedFor) {
  textured({"--webp-quality", "95"});
  const std::uintmax_t fine = bytes();
  EXPECT_EQ(figures()["quality"], 95);
  textured({"--webp-quality", "60", "--force"});
  EXPECT_EQ(figures()["quality"], 60);
  EXPECT_LT(bytes(), fine);
}

TEST_F(WebCommand, RefusesWhatCannotBe) {
  const test::Outcome tiny = run(texture(out_, {"--target", "web", "--max-bytes", "900"}));
  expect_one_sentence(tiny, "faces take", "allow more by --max-bytes SIZE, or take a mesh of fewer faces");
  EXPECT_FALSE(fs::exists(out_)) << "nothing is half-written";
  const auto usage = [&](const std::vector<std::string>& more, const std::string& why) {
    const test::Outcome outcome = run(texture(out_, more));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, why)) << outcome.err;
    EXPECT_FALSE(fs::exists(out_));
  };
  usage({"--max-bytes", "20M"}, "--max-bytes belongs to --target web");
  usage({"--target", "web", "--page-size", "16384"},
        "a WebP has at most 16383 texels an edge, and --page-size 16384 is more");
  usage({"--target", "phone"}, "phone");
  usage({"--target", "web", "--max-bytes", "much"}, "'much' is no amount");
  usage({"--target", "web", "--webp-quality", "0"}, "--webp-quality");
}

TEST_F(WebCommand, IsTheSameForOneThread) {
  const fs::path other = folder_.path() / "other";
  textured({"--threads", "1", "--lit"});
  textured({"--threads", "2", "--lit"}, other);
  EXPECT_TRUE(read_file(out_ / "model.glb") == read_file(other / "model.glb"));
}

TEST_F(WebCommand, LitHasNormalsAndNoLightOfItsOwn) {
  textured({"--lit"});
  const Json json = json_of(out_ / "model.glb");
  EXPECT_TRUE(json["meshes"][0]["primitives"][0]["attributes"].contains("NORMAL"));
  EXPECT_FALSE(json["materials"][0].contains("extensions"));
  EXPECT_FALSE(contains(read_file(out_ / "model.obj"), "\nvn "));
}

TEST_F(WebCommand, FilesHaveTheirPagesBeside) {
  textured({"--gltf", "files"});
  for (const char* name : {"model.gltf", "model.bin", "model_0.webp", "model_0.jpg"})
    EXPECT_TRUE(fs::exists(out_ / name)) << name;
  EXPECT_FALSE(fs::exists(out_ / "model_0_small.jpg")) << "the page itself is there";
  const Json json = Json::parse(read_file(out_ / "model.gltf"));
  EXPECT_EQ(json["images"][0]["uri"], "model_0.webp");
  EXPECT_EQ(json["images"][1]["uri"], "model_0.jpg");
  EXPECT_EQ(io::read_textured_model(out_ / "model.gltf").pages.size(), 1u);
}

TEST_F(WebCommand, WithoutFallbackReadersNeedWebp) {
  textured({"--no-jpeg-fallback"});
  const Json json = json_of(out_ / "model.glb");
  EXPECT_EQ(json["images"].size(), 1u);
  EXPECT_EQ(std::ranges::count(json["extensionsRequired"], Json("EXT_texture_webp")), 1);
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(out_)) files.push_back(entry.path().filename());
  for (const std::string& name : files)
    EXPECT_FALSE(contains(name, "webp") || contains(name, "small")) << name << " is in the GLB and nowhere else";
}

TEST_F(WebCommand, ChangedResultIsForTheWebAgain) {
  textured({"--editable"});
  std::ofstream(folder_.path() / "rules.csv") << "box,-1000 -1000 -1000 0 0 1000,forbid,east_001.jpg\n";
  const fs::path changed = folder_.path() / "changed";
  textured({"--from", out_.string(), "--allow", (folder_.path() / "rules.csv").string()}, changed);
  const Json json = json_of(changed / "model.glb");
  EXPECT_EQ(std::ranges::count(json["extensionsUsed"], Json("EXT_texture_webp")), 1);
  EXPECT_EQ(io::read_textured_model(changed / "model.glb").mesh.faces.size(),
            io::read_textured_model(out_ / "model.glb").mesh.faces.size());
}

TEST_F(WebCommand, TilesAreSmallerAndMeet) {
  const fs::path full = folder_.path() / "full";
  const auto tileset = [&](const fs::path& out, const std::vector<std::string>& more) {
    std::vector<std::string> words = texture(out, {"--tile-faces", "400"});
    words[0] = "tileset";
    words.insert(words.end(), more.begin(), more.end());
    const test::Outcome outcome = run(words);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  };
  tileset(full, {});
  tileset(out_, {"--target", "web"});
  std::uintmax_t before = 0, after = 0;
  for (const fs::directory_entry& tile : fs::directory_iterator(full / "tiles")) {
    const fs::path web = out_ / "tiles" / tile.path().filename();
    before += fs::file_size(tile.path());
    after += fs::file_size(web);
    const Json json = json_of(web);
    EXPECT_EQ(std::ranges::count(json["extensionsUsed"], Json("KHR_mesh_quantization")), 1);
    EXPECT_EQ(std::ranges::count(json["extensionsUsed"], Json("EXT_structural_metadata")), 1);
    EXPECT_EQ(io::read_textured_model(web).mesh.faces.size(), io::read_textured_model(tile.path()).mesh.faces.size());
  }
  EXPECT_LT(after, before * 2 / 3);
}

TEST_F(WebCommand, UnitsOfJobsMakeTilesForTheWeb) {
  std::vector<std::string> words = texture(out_, {"--tile-faces", "1500", "--target", "web"});
  words[0] = "tiles";
  ASSERT_EQ(run(words).exit_code, 0);
  const test::Outcome outcome = run({"unit", out_.string(), "--all"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::size_t tiles = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(out_)) {
    EXPECT_NE(entry.path().extension(), ".webp") << entry.path() << " is in its GLB";
    if (entry.path().extension() != ".glb") continue;
    ++tiles;
    const Json json = json_of(entry.path());
    EXPECT_EQ(std::ranges::count(json["extensionsUsed"], Json("EXT_texture_webp")), 1);
    EXPECT_EQ(std::ranges::count(json["extensionsRequired"], Json("KHR_mesh_quantization")), 1);
  }
  EXPECT_GT(tiles, 2u);
}

}  // namespace
}  // namespace gpvc
