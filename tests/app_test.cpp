// The program as its users start it: arguments in; exit code, words and files out.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "app/city.h"
#include "labeling/labeling.h"
#include "temporary_folder.h"
#include "visibility/visibility.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::read_file;
using test::TemporaryFolder;

struct Outcome {
  int exit_code = -1;  ///< 128 + signal when killed by one
  std::string out, err;
};

class Program {
 public:
  // Starts gpvc. `in_child` runs before it, in its process.
  explicit Program(const std::vector<std::string>& arguments, const std::function<void()>& in_child = {}) {
    const fs::path out = folder_.path() / "stdout", err = folder_.path() / "stderr";
    process_ = fork();
    if (process_ != 0) return;
    const int out_file = open(out.c_str(), O_CREAT | O_WRONLY, 0600),
              err_file = open(err.c_str(), O_CREAT | O_WRONLY, 0600);
    dup2(out_file, STDOUT_FILENO);
    dup2(err_file, STDERR_FILENO);
    if (in_child) in_child();
    std::vector<std::string> words{GPVC_BINARY};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(GPVC_BINARY, argv.data());
    _exit(127);
  }

  void send(int signal) const { kill(process_, signal); }
  bool running() {
    int status = 0;
    if (!ended_ && waitpid(process_, &status, WNOHANG) == process_) note_end(status);
    return !ended_;
  }
  Outcome wait() {
    int status = 0;
    if (!ended_ && waitpid(process_, &status, 0) == process_) note_end(status);
    return {exit_code_, read_file(folder_.path() / "stdout"), read_file(folder_.path() / "stderr")};
  }

 private:
  void note_end(int status) {
    ended_ = true;
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  TemporaryFolder folder_;
  pid_t process_ = 0;
  bool ended_ = false;
  int exit_code_ = -1;
};

Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& in_child = {}) {
  return Program(arguments, in_child).wait();
}

/// A copy of the small scene that may be spoilt.
class App : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    ASSERT_TRUE(fs::exists(fs::path(GPVC_APP_SCENE) / "run.json"))
        << "ctest makes the scene: app_scene.synth";
    fs::copy(GPVC_APP_SCENE, scene_, fs::copy_options::recursive);
  }
  std::vector<std::string> texture(const fs::path& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"texture", (scene_ / "colmap").string(), (scene_ / "mesh.ply").string(),
                                   "-o", out.string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  // Bad input ends in one sentence that names `where` and `why`, exit code 1 and nothing left behind.
  void expect_refused(const std::string& where, const std::string& why) const {
    for (const char* command : {"texture", "visibility"}) {
      auto words = texture(out_);
      words[0] = command;
      const Outcome outcome = run(words);
      expect_one_sentence(outcome, where, why);
      EXPECT_FALSE(fs::exists(out_));
    }
  }
  static void expect_one_sentence(const Outcome& outcome, const std::string& where, const std::string& why) {
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    std::vector<std::string> errors;
    std::istringstream lines(outcome.err);
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with("gpvc: error: ")) errors.push_back(line);
    ASSERT_EQ(errors.size(), 1u) << outcome.err;
    EXPECT_TRUE(contains(errors[0], where));
    EXPECT_TRUE(contains(errors[0], why));
    EXPECT_FALSE(contains(errors[0], "unfinished")) << "a name the user has never seen";
  }
  void replace_in(const fs::path& file, const std::string& what, const std::string& by) const {
    std::string text = read_file(file);
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, what.size(), by);
    std::ofstream(file, std::ios::binary) << text;
  }

  // The first view's line in images.txt: quaternion and translation, as COLMAP writes them.
  void move_first_camera(const std::string& pose) const {
    const fs::path file = scene_ / "colmap" / "images.txt";
    std::string text = read_file(file);
    const std::size_t line = text.find("\n1 ") + 1;
    text.replace(line, text.find('\n', line) - line, "1 " + pose + " 1 east_001.jpg");
    std::ofstream(file) << text;
  }

  TemporaryFolder folder_;
  fs::path scene_ = folder_.path() / "scene", out_ = folder_.path() / "some" / "out";
};

nlohmann::json run_json(const fs::path& out) { return nlohmann::json::parse(read_file(out / "run.json")); }

// The values of a little-endian .npy of one dimension.
template <class T>
std::vector<T> npy(const fs::path& file) {
  const std::string bytes = read_file(file);
  if (bytes.size() < 10) return {};
  const std::size_t start =
      10u + static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  std::vector<T> values((bytes.size() - start) / sizeof(T));
  std::memcpy(values.data(), bytes.data() + start, values.size() * sizeof(T));
  return values;
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
  return files;
}

// --- usage ---

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

TEST(AppUsage, MistypedWordsAreGuessed) {
  EXPECT_TRUE(contains(run({"textre", "a"}).err, "no command 'textre'; did you mean 'texture'?"));
  EXPECT_TRUE(contains(run({"texture", "a", "b", "-o", "c", "--view=x"}).err,
                       "no option '--view=x'; did you mean '--views'?"));
  EXPECT_TRUE(contains(run({"texture", "a", "b", "x", "-o", "c"}).err, "'x' is one argument too many"));
  EXPECT_TRUE(contains(run({"synth"}).err, "a command is missing"));
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

// --- results ---

TEST_F(App, TextureKeepsEveryPromise) {
  const Outcome outcome = run(texture(out_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto record = run_json(out_);
  std::set<std::string> promised;
  for (const auto& name : record["outputs"]) promised.insert(name.get<std::string>());
  for (const char* name : {"model.obj", "model.mtl", "model_0.jpg", "model.glb", "preview.png", "views.json",
                           "labels.npy", "tags.npy", "faces.npy", "run.json"})
    EXPECT_TRUE(promised.count(name)) << name;
  std::set<std::string> there;
  for (const auto& [name, bytes] : files_of(out_)) {
    there.insert(name);
    EXPECT_FALSE(bytes.empty()) << name;
  }
  EXPECT_EQ(there, promised);

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
  EXPECT_TRUE(contains(outcome.err, "east_001.jpg: sees no face")) << outcome.err;
  // With no other view there is nothing to texture with.
  expect_one_sentence(run(texture(folder_.path() / "alone", {"--views", "east_001.jpg"})), "mesh.ply",
                      "no photo sees any face");
}

TEST_F(App, SceneInUtmCoordinatesGivesTheSameTexture) {
  ASSERT_EQ(run(texture(folder_.path() / "near")).exit_code, 0);
  // The same scene, 500 km east and 5000 km north. COLMAP stores translations, so camera centres come back
  // with a rounding of 5e6 * 2^-52 = 1e-9 m, about 1e-8 px: hardly a class may change.
  const WorldPoint shift{500000, 5000000, 128};
  Scene scene = read_scene(scene_ / "colmap", {});
  for (View& view : scene.views) {
    WorldPoint& c = view.pose.centre;
    c = {c.x + shift.x, c.y + shift.y, c.z + shift.z};
  }
  CityOptions options;
  options.flight.size_m = 40;
  options.faces = 1000;
  const SynthScene city = make_city(options);
  write_synth_cameras(scene_ / "colmap", city, scene.views, SynthRenderer(city), {});
  const Mesh mesh = read_mesh(scene_ / "mesh.ply");
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
  // A strip of four faces; the outer ones have one candidate each, the inner ones both at a small difference:
  // with smoothness 1 one cut is needed, cheapest between the second and the third face.
  const fs::path mesh = folder_.write("strip.obj",
                                      "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 2 0 0\nv 2 1 0\n"
                                      "f 1 3 2\nf 2 3 4\nf 3 5 4\nf 4 5 6\n");
  const CostTable table{{0, 1, 3, 5, 6}, {7, 7, 9, 7, 9, 9}, {0.5f, 0.1f, 0.2f, 0.3f, 0.1f, 0.5f}};
  write_costs(folder_.path() / "costs", table);
  const Outcome outcome =
      run({"label", (folder_.path() / "costs").string(), mesh.string(), "-o", out_.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(npy<std::int32_t>(out_ / "labels.npy"), (std::vector<std::int32_t>{7, 7, 9, 9}));
  EXPECT_TRUE(contains(outcome.out, "energy 2.200, 1 differing pairs, 2 patches"));
  // Costs of another mesh.
  const fs::path other = out_.parent_path() / "other";
  expect_one_sentence(run({"label", (folder_.path() / "costs").string(), (scene_ / "mesh.ply").string(), "-o",
                           other.string()}),
                      "costs", "4 faces");
  EXPECT_FALSE(fs::exists(other));
}

TEST_F(App, InspectSaysWhatItUnderstood) {
  const Outcome outcome = run({"inspect", (scene_ / "colmap").string(), (scene_ / "mesh.ply").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* words :
       {"views    5", "240 x 160 px", "fx 200.00", "k1 -0.06", "up       +z", "x -25.000 .. 25.000"})
    EXPECT_TRUE(contains(outcome.out, words));
}

// --- bad input ---

TEST_F(App, RefusesAMissingImage) {
  fs::remove(scene_ / "images" / "nadir_001.jpg");
  expect_refused("nadir_001.jpg", "");
}

TEST_F(App, RefusesATruncatedImage) {
  const fs::path photo = scene_ / "images" / "nadir_001.jpg";
  fs::resize_file(photo, fs::file_size(photo) / 2);
  // Visibility needs no pixel of it; texture does.
  expect_one_sentence(run(texture(out_)), "nadir_001.jpg", "");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(App, RefusesCamerasCutInTheMiddle) {
  const fs::path cameras = scene_ / "colmap" / "cameras.txt";
  fs::resize_file(cameras, fs::file_size(cameras) - 40);
  expect_refused("cameras.txt", "");
}

TEST_F(App, RefusesImagesCutInTheMiddle) {
  const fs::path images = scene_ / "colmap" / "images.txt";
  const std::string text = read_file(images);
  fs::resize_file(images, text.find("nadir_001.jpg") - 20);
  expect_refused("images.txt", "");
}

TEST_F(App, RefusesAMissingScene) {
  fs::remove_all(scene_ / "colmap");
  expect_refused("colmap", "");
}

TEST_F(App, RefusesAMeshWithNan) {
  std::ofstream(scene_ / "mesh.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n";
  expect_refused("mesh.ply", "");
}

TEST_F(App, RefusesAMeshWithIndicesOutOfRange) {
  std::ofstream(scene_ / "mesh.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n";
  expect_refused("mesh.ply", "3");
}

TEST_F(App, RefusesAMeshWithoutFaces) {
  std::ofstream(scene_ / "mesh.ply")
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n0 0 0\n";
  expect_refused("mesh.ply", "face");
}

TEST_F(App, ExplainsAMeshInAnotherFrame) {
  std::ofstream(scene_ / "mesh.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
         "property double z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n500000 5000000 0\n500001 5000000 0\n500000 5000001 0\n3 0 1 2\n";
  expect_one_sentence(run(texture(out_)), "no photo sees any face", "same coordinates");
  EXPECT_FALSE(fs::exists(out_));
}

// --- the output folder ---

TEST_F(App, RefusesAnOutputThatCannotBeWritten) {
  const fs::path file = folder_.write("file", "x");
  for (const fs::path& out : {file, file / "out", fs::path("/proc/gpvc-out")}) {
    expect_one_sentence(run(texture(out)), out.string(), "");
    expect_one_sentence(run({"synth", "city", "-o", out.string()}), out.string(), "");
  }
  EXPECT_EQ(read_file(file), "x");
}

TEST_F(App, RefusesToReplaceAResultUnlessForced) {
  ASSERT_EQ(run(texture(out_, {"--texture", "png"})).exit_code, 0);
  folder_.write("some/out/notes.txt", "mine");
  const auto before = files_of(out_);
  expect_one_sentence(run(texture(out_)), out_.string(), "--force");
  EXPECT_TRUE(files_of(out_) == before);
  // A forced run that fails leaves the earlier result.
  const std::string mesh = read_file(scene_ / "mesh.ply");
  folder_.write("scene/mesh.ply", "ply\n");
  expect_one_sentence(run(texture(out_, {"--force"})), "mesh.ply", "");
  EXPECT_TRUE(files_of(out_) == before);
  // One that succeeds replaces it, and nothing else.
  folder_.write("scene/mesh.ply", mesh);
  ASSERT_EQ(run(texture(out_, {"--force"})).exit_code, 0);
  EXPECT_FALSE(fs::exists(out_ / "model_0.png"));
  EXPECT_TRUE(fs::exists(out_ / "model_0.jpg"));
  EXPECT_EQ(read_file(out_ / "notes.txt"), "mine");
}

TEST_F(App, RefusesToOverwriteItsOwnMesh) {
  folder_.write("scene/model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto before = files_of(scene_);
  expect_one_sentence(run({"texture", (scene_ / "colmap").string(), (scene_ / "model.obj").string(), "-o",
                           scene_.string(), "--force"}),
                      "model.obj", "input");
  EXPECT_TRUE(files_of(scene_) == before);
}

// A limit on the size of a file stands in for a full disk: it hits one file or another as it grows.
TEST_F(App, FullDiskAnywhereLeavesNothing) {
  auto visibility = texture(out_);
  visibility[0] = "visibility";
  const std::vector<std::pair<std::vector<std::string>, rlim_t>> runs{
      {texture(out_), 2000},
      {texture(out_), 20000},
      {texture(out_), 200000},
      {texture(out_), 500000},
      {visibility, 2000},
      {{"synth", "city", "-o", out_.string(), "--size", "40", "--photos", "1"}, 20000},
      {{"synth", "city", "-o", out_.string(), "--size", "40", "--photos", "1"}, 200000}};
  for (const auto& [words, limit] : runs) {
    const Outcome outcome = run(words, [limit = limit] {
      const rlimit size{limit, limit};
      setrlimit(RLIMIT_FSIZE, &size);
    });
    expect_one_sentence(outcome, out_.string(), "");
    EXPECT_FALSE(fs::exists(out_)) << words[0] << ' ' << limit;
  }
}

TEST_F(App, FullFileSystemLeavesNothing) {
  const fs::path disk = folder_.path() / "disk";
  fs::create_directories(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=300k") != 0)
    GTEST_SKIP()
        << "no permission to mount a small file system; FullDiskAnywhereLeavesNothing covers the rest";
  const Outcome outcome = run(texture(disk / "out"));
  const bool left = fs::exists(disk / "out");
  umount2(disk.c_str(), MNT_DETACH);
  expect_one_sentence(outcome, (disk / "out").string(), "No space left");
  EXPECT_FALSE(left);
}

TEST_F(App, NamesCannotLeaveTheOutputFolder) {
  fs::rename(scene_ / "images" / "east_001.jpg", scene_ / "escaped.jpg");
  replace_in(scene_ / "colmap" / "images.txt", "east_001.jpg", "../escaped.jpg");
  auto words = texture(out_);
  words[0] = "visibility";
  expect_one_sentence(run(words), "../escaped.jpg", "");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(App, InterruptLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM})
    for (const int after_ms : {0, 60, 150}) {
      Program program(texture(out_, {"--threads", "1"}));
      while (program.running() && !fs::exists(out_))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::this_thread::sleep_for(std::chrono::milliseconds(after_ms));
      const bool in_time = program.running();
      program.send(signal);
      const Outcome outcome = program.wait();
      if (!in_time || outcome.exit_code == 0) {  // a quick machine
        fs::remove_all(out_);
        ASSERT_NE(after_ms, 0);
        continue;
      }
      EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
      EXPECT_TRUE(contains(outcome.err, "interrupted"));
      EXPECT_FALSE(fs::exists(out_)) << after_ms;
    }
}

TEST_F(App, LogFileGetsEverything) {
  const fs::path log = folder_.path() / "run.log";
  const Outcome outcome = run(texture(out_, {"--quiet", "--log", log.string()}));
  ASSERT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* stage : {"read", "visibility and costs", "view selection", "atlas", "write"})
    EXPECT_TRUE(contains(read_file(log), stage));
  expect_one_sentence(run(texture(folder_.path() / "b", {"--log", "/proc/none/log"})), "/proc/none/log", "");
}

TEST_F(App, LogReplacesOnlyLogs) {
  const fs::path mesh = scene_ / "mesh.ply", log = folder_.path() / "run.log";
  const std::string before = read_file(mesh);
  expect_one_sentence(run(texture(out_, {"--log", mesh.string()})), "mesh.ply", "no earlier log");
  EXPECT_EQ(read_file(mesh), before);
  const std::vector<std::string> inspect{"inspect", (scene_ / "colmap").string(), "--log", log.string()};
  EXPECT_EQ(run(inspect).exit_code, 0);
  EXPECT_EQ(run(inspect).exit_code, 0) << "its own log may be replaced";
}

TEST_F(App, LostOutputIsAFailure) {
  const auto full = [] { ASSERT_NE(freopen("/dev/full", "w", stdout), nullptr); };
  const Outcome outcome = run({"inspect", (scene_ / "colmap").string()}, full);
  expect_one_sentence(outcome, "standard output", "cannot be written");
}

TEST_F(App, EvaluateWantsATexturedModel) {
  ASSERT_EQ(run(texture(out_, {"--quiet"})).exit_code, 0);
  const std::vector<std::string> evaluate{"evaluate", (out_ / "model.obj").string(),
                                          (scene_ / "colmap").string()};
  const Outcome scored = run(evaluate);
  EXPECT_EQ(scored.exit_code, 0) << scored.err;
  EXPECT_TRUE(contains(scored.out, "mean"));
  fs::remove(out_ / "model.mtl");
  expect_one_sentence(run(evaluate), "model.obj", "no textured face");
  std::ofstream(out_ / "model.obj", std::ios::trunc).close();
  expect_one_sentence(run(evaluate), "model.obj", "no textured face");
}

}  // namespace
}  // namespace gpvc
