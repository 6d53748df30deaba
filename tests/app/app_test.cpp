// The program as its users start it: arguments in; exit code, words and files out.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/synth/city.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "io/vector.h"
#include "labeling/labeling.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST(AppUsage, HelpAndVersionEndWell) {
  EXPECT_TRUE(contains(run({"--version"}).out, "gpvc 0."));
  EXPECT_EQ(run({"--version"}).exit_code, 0);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--help"},
                                                {"texture", "--help"},
                                                {"visibility", "-h"},
                                                {"synth", "--help"},
                                                {"synth", "city", "--help"}}) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(contains(outcome.out, "Usage: gpvc"));
    EXPECT_TRUE(contains(outcome.out, "Exit status") || words[0] == "synth");
    EXPECT_EQ(outcome.err, "");
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 112u) << line;
  }
}

TEST(AppUsage, WrongWordsGiveTwoAndAHint) {
  const std::vector<std::vector<std::string>> wrong{{},
                                                    {"paint"},
                                                    {"texture"},
                                                    {"texture", "a", "b"},
                                                    {"texture", "a", "b", "-o", "c", "--colour"},
                                                    {"texture", "a", "b", "-o", "c", "--downscale", "0"},
                                                    {"texture", "a", "b", "-o", "c", "--downscale", "two"},
                                                    {"texture", "a", "b", "-o", "c", "--seams", "some"},
                                                    {"texture", "a", "b", "-o", "c", "--threads", "-1"},
                                                    {"texture", "a", "b", "-o", "c", "-q", "-v"},
                                                    {"texture", "a", "b", "-o", "c", "--smoothness", "nan"},
                                                    {"texture", "a", "b", "-o", ""},
                                                    {"synth"},
                                                    {"synth", "city", "-o", "c", "--photo-size", "12"}};
  for (const auto& words : wrong) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 2) << (words.empty() ? "" : words.back());
    EXPECT_TRUE(outcome.err.starts_with("gpvc: error: ")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "\nTry 'gpvc"));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(App, ListsDevicesWithoutAScene) {
  const Outcome outcome = run({"texture", "--device", "list"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(outcome.out.starts_with("0  ")) << outcome.out;
}

TEST_F(App, UnknownViewGivesTwoAndNamesNearOnes) {
  const Outcome outcome = run(texture(out_, {"--views", "east_01.jpg"}));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(contains(outcome.err, "east_001.jpg"));
  EXPECT_FALSE(fs::exists(out_));
}

// --- results

TEST_F(App, TextureKeepsEveryPromise) {
  const Outcome outcome = run(texture(out_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto record = run_json(out_);
  std::set<std::string> promised;
  for (const auto& name : record["outputs"]) promised.insert(name.get<std::string>());
  for (const char* name : {"model.obj", "model.mtl", "model_0.jpg", "model.glb", "preview.png", "misfit.png",
                           "views.json", "labels.npy", "tags.npy", "faces.npy", "run.json"})
    EXPECT_TRUE(promised.count(name)) << name;
  std::set<std::string> there;
  for (const auto& [name, bytes] : files_of(out_)) {
    there.insert(name);
    EXPECT_FALSE(bytes.empty()) << name;
  }
  EXPECT_EQ(there, promised);

  const auto decodes = record["counts"]["decodes"];
  EXPECT_EQ(decodes["see"], 5);
  const double all = 5 + decodes["seams"].get<double>() + decodes["paint"].get<double>();
  EXPECT_DOUBLE_EQ(decodes["per_photo"], all / 5);

  const auto exposure = record["counts"]["exposure"];
  EXPECT_EQ(exposure.size(), 5u);
  for (const auto& view : exposure)
    for (const auto& gain : view["gain"]) EXPECT_GT(gain.get<double>(), 0);

  const std::size_t faces = record["counts"]["faces"];
  std::size_t obj_faces = 0;
  std::istringstream obj(read_file(out_ / "model.obj"));
  for (std::string line; std::getline(obj, line);) obj_faces += line.starts_with("f ") ? 1 : 0;
  EXPECT_EQ(obj_faces, faces);

  const auto labels = npy<std::int32_t>(out_ / "labels.npy");
  const auto tags = npy<std::uint8_t>(out_ / "tags.npy");
  ASSERT_EQ(labels.size(), faces);
  ASSERT_EQ(tags.size(), faces);
  std::set<std::int32_t> used;
  for (std::size_t f = 0; f < faces; ++f) {
    EXPECT_EQ(labels[f] == -1, tags[f] == 2) << f;
    EXPECT_GE(labels[f], -1);
    EXPECT_LT(labels[f], 5);
    used.insert(labels[f]);
  }
  EXPECT_GE(used.size(), 5u);
  auto order = npy<std::uint32_t>(out_ / "faces.npy");
  std::sort(order.begin(), order.end());
  ASSERT_EQ(order.size(), faces);
  for (std::size_t f = 0; f < faces; ++f) ASSERT_EQ(order[f], f);
}

TEST_F(App, InspectLooksAtTheViewsAskedFor) {
  fs::remove(scene_ / "images" / "east_001.jpg");
  std::vector<std::string> inspect{"inspect", (scene_ / "colmap").string(), "--views", "nobody"};
  EXPECT_EQ(run(inspect).exit_code, 2);
  inspect[3] = "nadir*";
  EXPECT_TRUE(contains(run(inspect).out, "all photos found"));
  inspect[3] = "*";
  EXPECT_TRUE(contains(run(inspect).out, "1 photos missing: east_001.jpg"));
}

TEST_F(App, ViewsJsonSaysWhatTheSceneIs) {
  ASSERT_EQ(run(texture(out_, {"--exclude-views", "nadir*"})).exit_code, 0);
  const auto views = nlohmann::json::parse(read_file(out_ / "views.json"))["views"];
  ASSERT_EQ(views.size(), 5u);
  const std::vector<std::string> names{"east_001.jpg", "nadir_001.jpg", "north_001.jpg", "south_001.jpg",
                                       "west_001.jpg"};
  for (std::size_t v = 0; v < 5; ++v) {
    EXPECT_EQ(views[v]["name"], names[v]);
    EXPECT_EQ(views[v]["index"], v);
    EXPECT_EQ(views[v]["used"], v != 1);
    EXPECT_EQ(views[v]["width"], 240);
    EXPECT_EQ(views[v]["height"], 160);
    EXPECT_LT(views[v]["rotation"][2][2].get<double>(), -0.6);  // looks down
    EXPECT_GT(views[v]["centre"][2].get<double>(), 20);
  }
  for (const std::int32_t label : npy<std::int32_t>(out_ / "labels.npy")) EXPECT_NE(label, 1);
}

TEST_F(App, ThreadsDoNotChangeAByte) {
  const fs::path one = folder_.path() / "one", many = folder_.path() / "many";
  ASSERT_EQ(run(texture(one, {"--threads", "1"})).exit_code, 0);
  ASSERT_EQ(run(texture(many, {"--threads", "5"})).exit_code, 0);
  auto a = files_of(one), b = files_of(many);
  a.erase("run.json");
  b.erase("run.json");
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) EXPECT_TRUE(bytes == b[name]) << name;
}

TEST_F(App, VisibilityLeavesOneArrayAView) {
  // A name with a sub-folder and a blank.
  fs::create_directories(scene_ / "images" / "flight 1");
  fs::rename(scene_ / "images" / "east_001.jpg", scene_ / "images" / "flight 1" / "east_001.jpg");
  replace_in(scene_ / "colmap" / "images.txt", "east_001.jpg", "flight 1/east_001.jpg");
  auto words = texture(out_, {"--ivm", "--views", "flight 1/east_001.jpg,nadir_001.jpg"});
  words[0] = "visibility";
  const Outcome outcome = run(words);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "flight 1/east_001.jpg"));
  const auto record = run_json(out_);
  std::map<int, std::size_t> counts;
  for (const char* name : {"flight 1/east_001.jpg", "nadir_001.jpg"}) {
    const auto classes = npy<std::uint8_t>(out_ / "visibility" / (std::string(name) + ".npy"));
    ASSERT_EQ(classes.size(), record["counts"]["faces"]);
    for (const std::uint8_t c : classes) ++counts[c];
    const auto ivm = npy<std::uint32_t>(out_ / "ivm" / (std::string(name) + ".npy"));
    ASSERT_EQ(ivm.size(), 240u * 160u);
    // What the IVM shows is not hidden, corrections of snapped edges aside.
    std::size_t shown = 0, hidden = 0;
    for (const std::uint32_t face : ivm) {
      if (face == 0xFFFFFFFFu) continue;
      ASSERT_LT(face, classes.size());
      ++shown;
      hidden += classes[face] == 0 ? 1 : 0;
    }
    EXPECT_GT(shown, 240u * 160u / 2);
    EXPECT_LT(hidden, shown / 100);
  }
  EXPECT_EQ(counts[2], record["counts"]["full"]);
  EXPECT_EQ(counts[1], record["counts"]["partial"]);
  EXPECT_EQ(counts[0], record["counts"]["hidden"]);
}

TEST_F(App, CameraInsideABuildingIsNoError) {
  // Looks up from inside the house in the middle: every face around crosses or lies behind its plane.
  move_first_camera("1 0 0 0 0 6.5 -2");
  const Outcome outcome = run(texture(out_));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(App, PhotoThatSeesNothingIsNamed) {
  // From ten metres under the ground, looking down.
  move_first_camera("0 1 0 0 0 0 -10");
  const Outcome outcome = run(texture(out_));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "east_001.jpg: sees no face of the mesh: its camera may lie inside"))
      << outcome.err;
  // With no other view there is nothing to texture with.
  expect_one_sentence(run(texture(folder_.path() / "alone", {"--views", "east_001.jpg"})), "mesh.ply",
                      "no photo sees any face");
}

TEST_F(App, SceneInUtmCoordinatesGivesTheSameTexture) {
  ASSERT_EQ(run(texture(folder_.path() / "near")).exit_code, 0);
  // The same scene, 500 km east and 5000 km north. COLMAP stores translations, so camera centres come back with a
  // rounding of 5e6 * 2^-52 = 1e-9 m, about 1e-8 px: hardly a class may change.
  const WorldPoint shift{500000, 5000000, 128};
  Scene scene = io::read_scene(scene_ / "colmap", {});
  for (View& view : scene.views) {
    WorldPoint& c = view.pose.centre;
    c = {c.x + shift.x, c.y + shift.y, c.z + shift.z};
  }
  synth::CityOptions options;
  options.flight.size_m = 40;
  options.faces = 1000;
  const synth::SynthScene city = synth::make_city(options);
  synth::write_synth_cameras(scene_ / "colmap", city, scene.views, scene.views, synth::SynthRenderer(city), {});
  const Mesh mesh = io::read_mesh(scene_ / "mesh.ply");
  std::ostringstream obj;
  obj.precision(17);
  for (const WorldPoint& p : mesh.positions)
    obj << "v " << p.x + shift.x << ' ' << p.y + shift.y << ' ' << p.z + shift.z << '\n';
  for (const Triangle& t : mesh.faces) obj << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  folder_.write("scene/mesh.ply", obj.str());  // an OBJ by content

  const Outcome outcome = run(texture(out_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_file(out_ / "offset.txt"), "500000 5000000 130\n");
  const auto near = npy<std::int32_t>(folder_.path() / "near" / "labels.npy"),
             far = npy<std::int32_t>(out_ / "labels.npy");
  ASSERT_EQ(near.size(), far.size());
  std::size_t different = 0;
  for (std::size_t f = 0; f < near.size(); ++f) different += near[f] != far[f] ? 1 : 0;
  EXPECT_LE(different, near.size() / 200);
  // Local coordinates in the OBJ: small, and exact when the offset is added again.
  std::istringstream lines(read_file(out_ / "model.obj"));
  std::size_t vertex = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("v ")) continue;
    double x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z), 3);
    const WorldPoint& p = mesh.positions[vertex++];
    EXPECT_EQ((WorldPoint{x + 500000, y + 5000000, z + 130}),
              (WorldPoint{p.x + shift.x, p.y + shift.y, p.z + shift.z}));
  }
  EXPECT_EQ(vertex, mesh.positions.size());
}

TEST_F(App, LabelSolvesStoredCosts) {
  // A strip of four faces; the outer ones have one candidate each, the inner ones both at a small difference: with
  // smoothness 1 one cut is needed, cheapest between the second and the third face.
  const fs::path mesh = folder_.write("strip.obj",
                                      "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 2 0 0\nv 2 1 0\n"
                                      "f 1 3 2\nf 2 3 4\nf 3 5 4\nf 4 5 6\n");
  const labeling::CostTable table{{0, 1, 3, 5, 6}, {7, 7, 9, 7, 9, 9}, {0.5f, 0.1f, 0.2f, 0.3f, 0.1f, 0.5f}};
  labeling::write_costs(folder_.path() / "costs", table);
  const Outcome outcome = run({"label", (folder_.path() / "costs").string(), mesh.string(), "-o", out_.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(npy<std::int32_t>(out_ / "labels.npy"), (std::vector<std::int32_t>{7, 7, 9, 9}));
  EXPECT_TRUE(contains(outcome.out, "energy 2.200, 1 differing pairs, 2 patches"));
  // Costs of another mesh.
  const fs::path other = out_.parent_path() / "other";
  expect_one_sentence(
      run({"label", (folder_.path() / "costs").string(), (scene_ / "mesh.ply").string(), "-o", other.string()}),
      "costs", "4 faces");
  EXPECT_FALSE(fs::exists(other));
}

TEST_F(App, InspectSaysWhichPhotoShowsAPlace) {
  ASSERT_EQ(run(texture(out_)).exit_code, 0);
  const auto labels = npy<std::int32_t>(out_ / "labels.npy");
  const Mesh mesh = io::read_mesh(scene_ / "mesh.ply");
  const auto face = static_cast<std::size_t>(std::ranges::max_element(labels) - labels.begin());
  ASSERT_GE(labels[face], 0);
  WorldPoint p{};
  for (const std::uint32_t v : mesh.faces[face]) p = p + (1.0 / 3) * mesh.positions[v];
  const std::string place = fmt::format("{},{},{}", p.x, p.y, p.z);
  const Outcome shown = run({"inspect", out_.string(), "--at", place});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_TRUE(contains(shown.out, fmt::format("from face {}\n", face))) << shown.out;
  const auto views = nlohmann::json::parse(read_file(out_ / "views.json"))["views"];
  const auto name = views[static_cast<std::size_t>(labels[face])]["name"].get<std::string>();
  EXPECT_TRUE(contains(shown.out, "photo    " + name)) << shown.out;
  expect_one_sentence(run({"inspect", scene_.string(), "--at", place}), scene_.string(), "holds no textured model");
  EXPECT_EQ(run({"inspect", out_.string(), "--at", "1,2"}).exit_code, 2);
  fs::remove(out_ / "labels.npy");
  expect_one_sentence(run({"inspect", out_.string(), "--at", place}), "labels.npy", "");
}

TEST_F(App, InspectSaysWhatItUnderstood) {
  std::vector<std::string> inspect{"inspect", (scene_ / "colmap").string(), (scene_ / "mesh.ply").string()};
  const Outcome outcome = run(inspect);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(contains(outcome.out, "agrees"));
  for (const char* words :
       {"views    5", "240 x 160 px", "fx 200.00", "k1 -0.06", "up       +z", "x -25.000 .. 25.000", "overlap  "})
    EXPECT_TRUE(contains(outcome.out, words));
  inspect.push_back("--check");
  const Outcome checked = run(inspect);
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_TRUE(contains(checked.out, "agrees   east_001.jpg: ")) << checked.out;
  EXPECT_FALSE(contains(checked.out, "CHANCE"));
  EXPECT_TRUE(contains(checked.out, "quality  east_001.jpg: blur ")) << checked.out;
  inspect.erase(inspect.begin() + 2);
  const Outcome no_mesh = run(inspect);
  EXPECT_EQ(no_mesh.exit_code, 2);
  EXPECT_TRUE(contains(no_mesh.err, "--check compares what the photos show of a mesh")) << no_mesh.err;
}

}  // namespace
}  // namespace gpvc
