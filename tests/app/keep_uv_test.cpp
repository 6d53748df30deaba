// gpvc texture --keep-uv, from a scene to files.
#include <algorithm>
#include <fstream>

#include "io/images.h"
#include "io/textured_model.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

using namespace test;

std::vector<std::string> lines_of(const fs::path& file, const std::string& word) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(word + " ")) lines.push_back(line);
  return lines;
}

class KeepUv : public App {
 protected:
  std::vector<std::string> onto(const fs::path& model, const fs::path& out,
                                const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = texture(out, {"--keep-uv", "--texture", "png"});
    words[2] = model.string();
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  // The scene textured once, whose model the tests begin with.
  fs::path first() const {
    const fs::path out = folder_.path() / "first";
    EXPECT_EQ(run(texture(out, {"--texture", "png"})).exit_code, 0);
    return out;
  }
  nlohmann::json figures() const { return run_json(out_)["counts"]["layout"]; }
};

TEST_F(KeepUv, BakesAResultAgainOntoItself) {
  const fs::path before = first();
  const Outcome outcome = run(onto(before / "model.obj", out_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(lines_of(out_ / "model.obj", "vt"), lines_of(before / "model.obj", "vt")) << "digit by digit";
  EXPECT_EQ(lines_of(out_ / "model.obj", "f"), lines_of(before / "model.obj", "f"));
  EXPECT_EQ(npy<std::int32_t>(out_ / "labels.npy"), npy<std::int32_t>(before / "labels.npy"));
  const io::LoadedModel a = io::read_textured_model(before / "model.obj"),
                        b = io::read_textured_model(out_ / "model.obj");
  ASSERT_EQ(a.pages.size(), b.pages.size());
  ASSERT_EQ(a.pages[0].width, b.pages[0].width) << "as large as its image";
  ASSERT_EQ(a.pages[0].height, b.pages[0].height);
  // In the middles of faces that are seen whole: others are filled from what is beside them on the page.
  const auto tags = npy<std::uint8_t>(out_ / "tags.npy");
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < a.model.face_page.size(); ++f) {
    if (tags[f] != 0) continue;
    double u = 0, v = 0;
    for (const std::uint32_t t : a.model.face_texcoords[f]) {
      u += double{a.model.texcoords[t].u} / 3;
      v += double{a.model.texcoords[t].v} / 3;
    }
    const Image &p = a.pages[a.model.face_page[f]], &q = b.pages[b.model.face_page[f]];
    const int x = static_cast<int>(u * p.width), y = static_cast<int>(v * p.height);
    for (std::size_t c = 0; c < 3; ++c, ++count) sum += std::pow(p.at(x, y)[c] - q.at(x, y)[c], 2);
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(count)), 2.0) << "42 dB";
}

TEST_F(KeepUv, MakesPagesAsLargeAsAskedFor) {
  const fs::path before = first();
  const Outcome outcome = run(onto(before / "model.glb", out_, {"--page-size", "300"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const io::LoadedModel model = io::read_textured_model(out_ / "model.obj");
  EXPECT_EQ(std::max(model.pages[0].width, model.pages[0].height), 300);
  const auto tags = npy<std::uint8_t>(out_ / "tags.npy");
  EXPECT_EQ(tags.size(), model.mesh.faces.size()) << "the GLB's vertices were joined, and its faces are all there";
}

TEST_F(KeepUv, MakesUdimTilesPages) {
  const fs::path model = first() / "model.obj", moved = folder_.path() / "udim.obj";
  // Every second face lies in the second tile.
  std::ifstream in(model);
  std::ofstream out(moved);
  const auto vt = lines_of(model, "vt");
  std::size_t faces = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("f ") && ++faces == 1)
      for (const std::string& at : vt) {
        std::istringstream words(at.substr(3));
        double u = 0, v = 0;
        words >> u >> v;
        out << "vt " << u + 1 << " " << v << "\n";
      }
    if (line.starts_with("f ") && faces % 2 == 0) {
      std::istringstream words(line.substr(2));
      out << "f";
      for (std::string corner; words >> corner;) {
        const std::size_t slash = corner.find('/');
        out << " " << corner.substr(0, slash) << "/" << std::stoul(corner.substr(slash + 1)) + vt.size();
      }
      out << "\n";
      continue;
    }
    if (!line.starts_with("mtllib")) out << line << "\n";
  }
  out.close();
  const Outcome outcome = run(onto(moved, out_, {"--page-size", "512"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(out_ / "model.1001.png"));
  EXPECT_TRUE(fs::exists(out_ / "model.1002.png"));
  EXPECT_EQ(lines_of(out_ / "model.mtl", "newmtl"),
            (std::vector<std::string>{"newmtl page_0.1001", "newmtl page_0.1002"}));
  EXPECT_EQ(lines_of(out_ / "model.obj", "vt"), lines_of(moved, "vt"));
  const io::LoadedModel glb = io::read_textured_model(out_ / "model.glb");
  EXPECT_EQ(glb.pages.size(), 2u);
  for (const io::TexCoord& t : glb.model.texcoords) EXPECT_LE(t.u, 1.0f) << "of its page";
}

TEST_F(KeepUv, SaysWhatItDoesNotServe) {
  const fs::path model = first() / "model.obj", spoilt = model.parent_path() / "spoilt.obj";
  std::string text = read_file(model);
  // The first face has no texture coordinates, the second one none with an area, and the fourth one those of the third.
  const std::vector<std::string> faces = lines_of(model, "f");
  const auto replace = [&](const std::string& what, const std::string& by) {
    text.replace(text.find(what + "\n"), what.size(), by);
  };
  const auto words = [](const std::string& line) {
    std::istringstream in(line.substr(2));
    std::vector<std::array<std::string, 2>> corners;
    for (std::string corner; in >> corner;)
      corners.push_back({corner.substr(0, corner.find('/')), corner.substr(corner.find('/') + 1)});
    return corners;
  };
  const auto face = [&](std::size_t of, const std::array<std::string, 3>& texcoords) {
    const auto corners = words(faces[of]);
    std::string line = "f";
    for (std::size_t i = 0; i < 3; ++i) line += " " + corners[i][0] + (texcoords[i].empty() ? "" : "/" + texcoords[i]);
    return line;
  };
  const auto third = words(faces[2]), second = words(faces[1]);
  replace(faces[3], face(3, {third[0][1], third[1][1], third[2][1]}));
  replace(faces[1], face(1, {second[0][1], second[0][1], second[0][1]}));
  replace(faces[0], face(0, {"", "", ""}));
  std::ofstream(spoilt, std::ios::binary) << text;
  const Outcome outcome = run(onto(spoilt, out_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "1 faces have no texture coordinates"));
  EXPECT_TRUE(contains(outcome.err, "1 faces have texture coordinates in a line or a point"));
  EXPECT_TRUE(contains(outcome.err, "2 faces whose texture coordinates overlap"));
  EXPECT_EQ(figures()["faces_without"], 1);
  EXPECT_EQ(figures()["flat_faces"], 1);
  EXPECT_EQ(figures()["overlapping_faces"], 2);
  EXPECT_EQ(lines_of(out_ / "model.obj", "f").size(), faces.size()) << "every face is in the OBJ";

  const Outcome refused = run(onto(spoilt, folder_.path() / "none", {"--overlap", "refuse"}));
  expect_one_sentence(refused, "spoilt.obj", "lie under several of 2 faces, expected one face a texel");
  EXPECT_FALSE(fs::exists(folder_.path() / "none"));
}

TEST_F(KeepUv, MakesModelsForTheWebOfSmallerPages) {
  const fs::path before = first();
  const Outcome outcome =
      run(onto(before / "model.obj", out_, {"--target", "web", "--max-bytes", "200000", "--page-size", "512"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LE(fs::file_size(out_ / "model.glb"), 200'000u);
  const io::LoadedModel obj = io::read_textured_model(out_ / "model.obj"),
                        glb = io::read_textured_model(out_ / "model.glb");
  EXPECT_EQ(std::max(obj.pages[0].width, obj.pages[0].height), 512) << "the OBJ's pages are as asked for";
  EXPECT_EQ(obj.pages[0].width * glb.pages[0].height, obj.pages[0].height * glb.pages[0].width) << "the same places";
  EXPECT_EQ(lines_of(out_ / "model.obj", "vt"), lines_of(before / "model.obj", "vt"));
}

TEST_F(KeepUv, ChangesAnEditableResultInPlace) {
  const fs::path before = first(), editable = folder_.path() / "editable", rules = folder_.path() / "rules.csv";
  ASSERT_EQ(run(onto(before / "model.obj", editable, {"--editable"})).exit_code, 0);
  const Outcome same = run(onto(before / "model.obj", folder_.path() / "same", {"--from", editable.string()}));
  ASSERT_EQ(same.exit_code, 0) << same.err;
  for (const char* file : {"model_0.png", "model.obj", "labels.npy"})
    EXPECT_EQ(read_file(folder_.path() / "same" / file), read_file(editable / file)) << file;

  const auto views = nlohmann::json::parse(read_file(editable / "views.json"));
  const std::string name = views["views"][0]["name"];
  std::ofstream(rules) << "photo," << name << " 0 0 200 200\n";
  const std::vector<std::string> change{"--from", editable.string(), "--allow", rules.string()};
  const Outcome changed = run(onto(before / "model.obj", out_, change));
  ASSERT_EQ(changed.exit_code, 0) << changed.err;
  EXPECT_EQ(run_json(out_)["counts"]["edit"]["pages_kept"], 0);
  EXPECT_EQ(lines_of(out_ / "model.obj", "vt"), lines_of(before / "model.obj", "vt"));
  EXPECT_EQ(lines_of(out_ / "model.obj", "f"), lines_of(before / "model.obj", "f"));
  EXPECT_NE(read_file(out_ / "model_0.png"), read_file(editable / "model_0.png"));
  // The same rules from the start: the labels differ at most where the other solver stops elsewhere.
  const fs::path whole = folder_.path() / "whole";
  ASSERT_EQ(run(onto(before / "model.obj", whole, {"--allow", rules.string()})).exit_code, 0);
  const auto a = npy<std::int32_t>(out_ / "labels.npy"), b = npy<std::int32_t>(whole / "labels.npy");
  std::size_t differ = 0;
  for (std::size_t f = 0; f < a.size(); ++f) differ += a[f] != b[f];
  EXPECT_LT(differ, a.size() / 50);
  // Onto other places, or without the mesh's own, the result cannot be changed.
  expect_one_sentence(
      run(onto(before / "model.obj", whole, {"--from", editable.string(), "--page-size", "300", "--force"})),
      "editable", "page-size");
  expect_one_sentence(run(texture(whole, {"--from", editable.string(), "--texture", "png", "--force"})), "editable",
                      "other texture coordinates");
  // Questions about the mesh need no layout.
  const Outcome photos = run({"photos", (scene_ / "colmap").string(), (before / "model.obj").string(), "--face", "10",
                              "--from", editable.string()});
  EXPECT_EQ(photos.exit_code, 0) << photos.err;
}

TEST_F(KeepUv, IsRefusedWithWhatItExcludes) {
  const fs::path model = scene_ / "mesh.ply";
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--max-pages", "1"}, {"--max-texels", "100000"}, {"--texel-size", "0.1"}}) {
    const Outcome outcome = run(onto(model, out_, more));
    EXPECT_EQ(outcome.exit_code, 2) << more[0];
    EXPECT_TRUE(contains(outcome.err, "--keep-uv does not go with " + more[0])) << outcome.err;
  }
  EXPECT_EQ(run(texture(out_, {"--overlap", "refuse"})).exit_code, 2);
  expect_one_sentence(run(onto(model, out_)), "mesh.ply", "has no texture coordinates");
  // A model without any.
  const fs::path bare = folder_.path() / "bare.obj";
  std::ofstream(bare) << "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nf 1 2 3\nf 1 3 4\n";
  expect_one_sentence(run(onto(bare, out_)), "bare.obj", "has no texture coordinates");
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
}  // namespace gpvc
