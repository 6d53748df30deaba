// gpvc view, asked over HTTP as its page asks: what it answers is what the other commands say.
#include <httplib.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <set>
#include <thread>

#include "io/images.h"
#include "io/mesh.h"
#include "io/view_rules.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;
using Json = nlohmann::json;

// A program that serves, and what it answers.
class Served {
 public:
  explicit Served(std::vector<std::string> words)
      : out_(folder_.path() / "address"), program_(with_view(std::move(words)), [this] {
          const int file = open(out_.c_str(), O_CREAT | O_WRONLY, 0600);
          dup2(file, STDOUT_FILENO);
        }) {
    for (int tries = 0; tries < 600 && program_.running() && !contains(read_out(), "/\n"); ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::string address = read_out();
    const std::size_t port = address.find(':', 7), slash = address.find('/', 7);
    if (slash == std::string::npos) return;
    client_.emplace("127.0.0.1", std::stoi(address.substr(port + 1)));
    client_->set_read_timeout(120);
    root_ = address.substr(slash, address.find('\n') - slash);
  }
  ~Served() {
    if (program_.running()) end();
  }
  bool serves() const { return client_.has_value(); }
  std::string get(const std::string& path, int status = 200) {
    auto answered = client_->Get(root_ + path);
    EXPECT_TRUE(answered) << path;
    if (!answered) return "";
    EXPECT_EQ(answered->status, status) << path << ": " << answered->body.substr(0, 300);
    return answered->body;
  }
  Json get_json(const std::string& path) { return Json::parse(get(path)); }
  Json post(const std::string& path, const Json& body, int status = 200) {
    auto answered = client_->Post(root_ + path, body.dump(), "application/json");
    EXPECT_TRUE(answered) << path;
    if (!answered) return {};
    EXPECT_EQ(answered->status, status) << path << ": " << answered->body.substr(0, 300);
    return status == 200 ? Json::parse(answered->body) : Json(answered->body);
  }
  Outcome end() {
    program_.send(SIGINT);
    return program_.wait();
  }

 private:
  static std::vector<std::string> with_view(std::vector<std::string> words) {
    words.insert(words.begin(), "view");
    words.push_back("--no-browser");
    return words;
  }
  std::string read_out() const { return fs::exists(out_) ? read_file(out_) : ""; }
  TemporaryFolder folder_;
  fs::path out_;
  Program program_;
  std::optional<httplib::Client> client_;
  std::string root_;
};

class ViewCommand : public App {
 protected:
  void SetUp() override {
    App::SetUp();
    if (IsSkipped()) return;
    ASSERT_EQ(run(texture(out_, {"--editable"})).exit_code, 0);
    if (!contains(run({"view", out_.string(), "--export", (folder_.path() / "probe").string()}).err,
                  "not part of this program"))
      return;
    GTEST_SKIP() << "the page was not bundled: node and npm are missing";
  }
  Json photos_of(const std::vector<std::uint32_t>& faces) const {
    const fs::path file = folder_.path() / "answers.json";
    std::vector<std::string> words{
        "photos",     (scene_ / "colmap").string(), (scene_ / "mesh.ply").string(), "--from", out_.string(), "--json",
        file.string()};
    for (const std::uint32_t face : faces) words.insert(words.end(), {"--face", std::to_string(face)});
    EXPECT_EQ(run(words).exit_code, 0);
    return Json::parse(read_file(file))["points"];
  }
  static std::string question(const Json& at, const Json& face) {
    return "ask?x=" + at[0].dump() + "&y=" + at[1].dump() + "&z=" + at[2].dump() + "&face=" + face.dump();
  }
};

TEST_F(ViewCommand, AnswersAsPhotosDoes) {
  std::vector<std::uint32_t> faces;
  for (std::uint32_t face = 7; face < 5000; face += 250) faces.push_back(face);
  Served served({out_.string()});
  ASSERT_TRUE(served.serves());
  for (const Json& expected : photos_of(faces)) {
    Json found = served.get_json(question(expected["at"], expected["faces"][0]));
    for (Json& photo : found["photos"]) {
      EXPECT_FALSE(photo["plain"].get<std::string>().empty());
      photo.erase("plain");
    }
    EXPECT_EQ(found["shown"], expected["shown"]);
    ASSERT_EQ(found["photos"].size(), expected["photos"].size());
    for (std::size_t i = 0; i < found["photos"].size(); ++i)
      for (const char* member : {"name", "reason", "words", "class", "candidate", "textures_face", "face"})
        EXPECT_EQ(found["photos"][i][member], expected["photos"][i][member]) << member;
  }
  EXPECT_EQ(served.end().exit_code, 0) << "Ctrl-C is how it ends";
}

TEST_F(ViewCommand, GeometryIsTheMeshAndValuesAreItsFiles) {
  Served served({out_.string()});
  ASSERT_TRUE(served.serves());
  const std::string bytes = served.get("results/0/geometry");
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data(), 4);
  const Json head = Json::parse(bytes.substr(4, length));
  const Mesh mesh = io::read_mesh(scene_ / "mesh.ply");
  const std::size_t count = mesh.faces.size();
  ASSERT_EQ(head["faces"], count);
  std::size_t at = (4 + length + 7) / 8 * 8;
  std::vector<std::uint32_t> faces(count);
  std::memcpy(faces.data(), bytes.data() + at, 4 * count);
  at = (at + 4 * count + 7) / 8 * 8;
  std::vector<float> positions(9 * count);
  std::memcpy(positions.data(), bytes.data() + at, 36 * count);
  EXPECT_EQ(std::set<std::uint32_t>(faces.begin(), faces.end()).size(), count) << "each face is drawn once";
  for (std::size_t n = 0; n < count; ++n)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const WorldPoint& p = mesh.positions[mesh.faces[faces[n]][corner]];
      const double expected[] = {p.x, p.y, p.z};
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(positions[9 * n + 3 * corner + k] + head["origin"][k].get<double>(), expected[k], 1e-5);
    }
  std::size_t drawn = 0;
  for (const Json& block : head["blocks"]) {
    EXPECT_EQ(block["first"], drawn);
    drawn += block["count"].get<std::size_t>();
  }
  EXPECT_EQ(drawn, count);
  const std::string photos = served.get("results/0/values/photo");
  const auto labels = npy<std::int32_t>(out_ / "labels.npy");
  ASSERT_EQ(photos.size(), 4 * count);
  for (std::size_t n = 0; n < count; ++n) {
    float photo = 0;
    std::memcpy(&photo, photos.data() + 4 * n, 4);
    if (labels[faces[n]] < 0)
      EXPECT_TRUE(std::isnan(photo));
    else
      EXPECT_EQ(photo, static_cast<float>(labels[faces[n]]));
  }
  EXPECT_EQ(served.get("results/0/pages/0"), read_file(out_ / "model_0.jpg")) << "byte for byte";
  for (const char* nothing : {"results/0/pages/99", "results/1/model.json", "results/0/values/x", "run.json",
                              "model.obj", "results/0/pages/0x"})
    served.get(nothing, 404);
}

TEST_F(ViewCommand, AVetoIsAppliedAndTakenBack) {
  const auto before = npy<std::int32_t>(out_ / "labels.npy");
  const std::string result = read_file(out_ / "model.obj");
  Served served({out_.string()});
  ASSERT_TRUE(served.serves());
  const Json page = served.get_json("page.json");
  EXPECT_TRUE(page["changes"].get<bool>());
  std::uint32_t seen = 0;
  while (before[seen] < 0) ++seen;
  const Json chart = served.post("chart", {{"face", seen}})["faces"];
  const std::string photo = page["photos"][static_cast<std::size_t>(before[seen])];
  EXPECT_EQ(served.post("unseen", {{"view", before[seen]}, {"faces", {seen}}})["faces"], Json::array())
      << "its own photo sees it";
  served.post("rules", {{"rules", {{{"faces", chart}, {"forbid", photo}}}}});
  EXPECT_EQ(io::read_view_rules(out_ / "rules.json").size(), 1u) << "the file of --allow";
  EXPECT_EQ(read_file(out_ / "model.obj"), result) << "the earlier result stays until it is applied";
  const auto apply = [&] {
    const std::string key = served.get("results/0/values/photo");
    served.post("apply", Json::object());
    for (int tries = 0; tries < 600; ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (served.get("results/0/values/photo") != key) return;
    }
    ADD_FAILURE() << "nothing has changed";
  };
  apply();
  const auto after = npy<std::int32_t>(out_ / "labels.npy");
  for (const Json& entry : chart)
    for (std::uint32_t f = entry.is_array() ? entry[0] : entry;
         f <= (entry.is_array() ? entry[1] : entry).get<std::uint32_t>(); ++f)
      EXPECT_NE(after[f], before[seen]) << f;
  EXPECT_EQ(served.get_json("rules")["rules"].size(), 1u);
  served.post("rules", {{"rules", Json::array()}});
  apply();
  // Solved again between the labels of the others, some faces may come out otherwise than in the whole.
  const auto back = npy<std::int32_t>(out_ / "labels.npy");
  std::size_t differ = 0;
  for (std::size_t f = 0; f < back.size(); ++f) differ += back[f] != before[f];
  EXPECT_LT(differ, back.size() / 20);
  served.end();
  Served again({out_.string()});
  ASSERT_TRUE(again.serves());
  EXPECT_TRUE(again.get_json("page.json")["changes"].get<bool>()) << "what was changed can be changed again";
}

TEST_F(ViewCommand, FacesOfAPolygonAreThoseThatOneSees) {
  Served served({out_.string()});
  ASSERT_TRUE(served.serves());
  const Json view = served.get_json("page.json")["views"][0];
  const Json screen = {{"width", view["width"]},
                       {"height", view["height"]},
                       {"focal", view["fx"]},
                       {"rotation", view["rotation"]},
                       {"centre", view["centre"]}};
  Json question = screen;
  question["polygon"] = {{20, 20}, {120, 20}, {120, 100}, {20, 100}};
  const Json faces = served.post("faces-in", question)["faces"];
  ASSERT_FALSE(faces.empty());
  Json list;
  std::size_t count = 0;
  for (const Json& entry : faces) {
    list.push_back(entry);
    count += entry.is_array() ? entry[1].get<std::size_t>() - entry[0].get<std::size_t>() + 1 : 1;
  }
  // Nearly all of them are seen by the photo from there; its lens bends the frame's rim.
  const Json unseen = served.post("unseen", {{"view", 0}, {"faces", list}})["faces"];
  std::size_t missed = 0;
  for (const Json& entry : unseen)
    missed += entry.is_array() ? entry[1].get<std::size_t>() - entry[0].get<std::size_t>() + 1 : 1;
  EXPECT_LT(missed, count / 10) << count;
  question["polygon"] = {{20, 20}, {120, 20}};
  served.post("faces-in", question, 400);
  served.post("faces-in", screen, 400);
}

TEST_F(ViewCommand, BadQuestionsGetASentence) {
  Served served({out_.string()});
  ASSERT_TRUE(served.serves());
  for (const char* path : {"ask", "ask?x=1&y=2", "ask?x=nan&y=0&z=0", "ask?x=1e300&y=0&z=0", "ask?x=0&y=0&z=0&face=-1",
                           "cut?view=99&x=1&y=1&size=64", "cut?view=0&x=1&y=1&size=1e9"})
    served.get(path, path == std::string("cut?view=0&x=1&y=1&size=1e9") ? 200 : 400);
  served.get("photos/99", 404);
  for (const char* path : {"chart", "unseen", "faces-in", "rules"}) {
    served.post(path, Json::array(), 400);
    served.post(path, Json::object(), 400);
  }
  served.post("chart", {{"face", 4000000000u}}, 400);
  served.post("unseen", {{"view", 0}, {"faces", {{9, 3}}}}, 400);
  const Json refused = served.post("rules", {{"rules", {{{"faces", {1}}}}}}, 400);
  EXPECT_TRUE(contains(refused.get<std::string>(), "rule")) << refused;
  EXPECT_FALSE(fs::exists(out_ / "rules.json")) << "nothing was written";
  served.get("page.json");
}

TEST_F(ViewCommand, WithoutItsSceneItShowsWhatIsThere) {
  fs::rename(scene_, folder_.path() / "elsewhere");
  {
    Served served({out_.string()});
    ASSERT_TRUE(served.serves());
    const Json page = served.get_json("page.json");
    EXPECT_FALSE(page["asks"].get<bool>());
    EXPECT_FALSE(page["changes"].get<bool>());
    EXPECT_EQ(page["photos"].size(), 5u) << "names are in the result";
    EXPECT_EQ(served.get_json("results/0/model.json")["values"], Json({"photo", "tag"}));
    served.get("ask?x=0&y=0&z=0", 400);
    const Outcome outcome = served.end();
    EXPECT_TRUE(contains(outcome.err, "SCENE and MESH say where they are now")) << outcome.err;
  }
  const fs::path scene = folder_.path() / "elsewhere";
  Served served({out_.string(), (scene / "colmap").string(), (scene / "mesh.ply").string()});
  ASSERT_TRUE(served.serves());
  EXPECT_TRUE(served.get_json("page.json")["asks"].get<bool>());
}

TEST_F(ViewCommand, ExportsAFolderThatNeedsNoProgram) {
  const fs::path page = folder_.path() / "page";
  ASSERT_EQ(run({"view", out_.string(), "--beside", out_.string(), "--export", page.string()}).exit_code, 0);
  for (const char* file : {"index.html", "view.js", "view.css", "results/0/geometry", "results/1/pages/0",
                           "results/0/values/gsd", "photos/0"})
    EXPECT_TRUE(fs::is_regular_file(page / file)) << file;
  const Json info = Json::parse(read_file(page / "page.json"));
  for (const char* name : {"live", "asks", "changes"}) EXPECT_FALSE(info[name].get<bool>()) << name;
  EXPECT_EQ(info["results"].size(), 2u);
  const Outcome again = run({"view", out_.string(), "--export", page.string()});
  expect_one_sentence(again, page.string(), "holds files already");
}

TEST_F(ViewCommand, RefusesWhatIsNoResult) {
  expect_one_sentence(run({"view", (folder_.path() / "nothing").string(), "--no-browser"}), "nothing",
                      "does not exist");
  expect_one_sentence(run({"view", scene_.string(), "--no-browser"}), scene_.string(), "holds no textured model");
}

}  // namespace
}  // namespace gpvc
