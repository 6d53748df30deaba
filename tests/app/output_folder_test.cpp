// What stands in OUT, before and after runs that end well, badly or not at all.
#include "app/results/output_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/results/observer.h"
#include "app/results/output_names.h"
#include "io/error.h"
#include "tests/support/errors.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::read_file;

class OutputFolderTest : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& text) const {
    fs::create_directories((out_ / name).parent_path());
    std::ofstream(out_ / name) << text;
  }
  static void make(results::OutputFolder& folder, const std::string& name, const std::string& text) {
    std::ofstream(folder.file(name)) << text;
  }
  // A result of one file, as `texture` leaves it.
  void publish_first() const {
    results::OutputFolder folder(out_, false, "texture");
    make(folder, "model.obj", "first");
    make(folder, "run.json", R"({"program": "gpvc", "command": "texture", "outputs": ["model.obj", "run.json"]})");
    folder.publish();
  }
  std::string refusal(bool force, const std::string& command = "texture") const {
    try {
      const results::OutputFolder folder(out_, force, command);
    } catch (const OutputError& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(out_))
      all.push_back(entry.path().lexically_relative(out_).string());
    std::sort(all.begin(), all.end());
    return all;
  }

  test::TemporaryFolder folder_;
  fs::path out_ = folder_.path() / "out";
};

TEST_F(OutputFolderTest, ForeignFilesAreRefusedAtOnce) {
  for (const char* name : {"model_view.png", "model_.png", "model_3.txt"}) put(name, "a screenshot");
  EXPECT_EQ(refusal(false), "");
  fs::remove_all(out_);
  for (const char* name : {"model.obj", "offset.txt", "model_3.jpg", "run.json"}) {
    put(name, "mine");
    for (const bool force : {false, true}) EXPECT_NE(refusal(force).find(name), std::string::npos) << name;
    EXPECT_EQ(read_file(out_ / name), "mine");
    fs::remove_all(out_);
  }
  put("mesh.ply", "mine");  // known when it is promised
  results::OutputFolder folder(out_, true, "synth city");
  EXPECT_THROW(folder.file("mesh.ply"), OutputError);
}

TEST_F(OutputFolderTest, AForeignListRemovesNothing) {
  put("notes.txt", "mine");
  put("run.json", R"({"outputs": ["notes.txt"]})");
  EXPECT_NE(refusal(true), "");
  put("run.json", R"({"program": "gpvc", "command": "synth city", "outputs": ["notes.txt"]})");
  EXPECT_NE(refusal(true), "");
  EXPECT_EQ(read_file(out_ / "notes.txt"), "mine");
}

TEST_F(OutputFolderTest, ReplacesItsOwnResultAlone) {
  publish_first();
  put("notes.txt", "mine");
  EXPECT_TRUE(contains(refusal(false), "already holds a result (model.obj"));
  EXPECT_EQ(test::cures_of([&] { const results::OutputFolder refused(out_, false, "texture"); }),
            (std::vector{Cure::other_folder, Cure::replace_result}));
  results::OutputFolder folder(out_, true, "texture");
  make(folder, "model.glb", "second");
  folder.publish();
  EXPECT_EQ(names(), (std::vector<std::string>{"model.glb", "notes.txt"}));
}

TEST_F(OutputFolderTest, ARunThatStartsOverPublishesWhatItWritesThen) {
  results::OutputFolder folder(out_, false, "texture");
  make(folder, "tiles/0_0.glb", "first");
  folder.file("preview.png");  // never written
  folder.start_over();
  EXPECT_TRUE(folder.promised().empty());
  make(folder, "tileset.json", "second");
  folder.publish();
  EXPECT_EQ(names(), (std::vector<std::string>{"tileset.json"}));
}

TEST_F(OutputFolderTest, AFailedPublishBringsTheEarlierResultBack) {
  publish_first();
  const std::string run_json = read_file(out_ / "run.json");
  {
    results::OutputFolder folder(out_, true, "texture");
    make(folder, "model.obj", "second");
    make(folder, "new/page.jpg", "second");
    put("new", "a file that came meanwhile, where a folder has to be");
    EXPECT_THROW(folder.publish(), OutputError);
  }
  EXPECT_EQ(names(), (std::vector<std::string>{"model.obj", "new", "run.json"}));
  EXPECT_EQ(read_file(out_ / "model.obj"), "first");
  EXPECT_EQ(read_file(out_ / "run.json"), run_json);
}

TEST_F(OutputFolderTest, NamesThatAreNoUtf8AreListedAsTheyAre) {
  const std::string latin =
      "images/\xDC"
      "ber.jpg";
  for (const bool force : {false, true}) {
    results::OutputFolder folder(out_, force, "convert");
    folder.refuse_foreign_file(
        "images/./\xDC"
        "ber.jpg");
    make(folder, latin, force ? "second" : "first");
    std::ofstream run(folder.file("run.json"));
    run << nlohmann::json{
        {"program", "gpvc"}, {"command", "convert"}, {"outputs", results::outputs_json(folder.promised())}};
    run.close();
    folder.publish();
  }
  EXPECT_EQ(read_file(out_ / latin), "second");
  EXPECT_FALSE(results::outputs_json({"plain.jpg"})[0].is_object());
}

TEST_F(OutputFolderTest, AFolderInTheWayLosesNothing) {
  publish_first();
  results::OutputFolder folder(out_, true, "texture");
  make(folder, "model.obj", "second");
  make(folder, "offset.txt", "second");
  put("offset.txt/mine", "mine");
  EXPECT_THROW(folder.publish(), OutputError);
  EXPECT_EQ(read_file(out_ / "model.obj"), "first");
  EXPECT_EQ(read_file(out_ / "offset.txt/mine"), "mine");
}

// A run.json may be anybody's, and so may what a link in OUT leads to.
TEST_F(OutputFolderTest, NoLinkLeadsOut) {
  const fs::path away = folder_.path() / "away";
  fs::create_directories(away / "deep");
  std::ofstream(away / "a.jpg") << "mine";
  std::ofstream(away / "deep/a.jpg") << "mine";
  fs::create_directories(out_ / "real");
  for (const char* name : {"images", "real/images"}) {
    fs::create_directory_symlink(away, out_ / name);
    for (const std::string file : {"/a.jpg", "/deep/a.jpg"}) {
      put("run.json",
          R"({"program": "gpvc", "command": "convert", "outputs": ["run.json", ")" + (name + file) + "\"]}");
      EXPECT_NE(refusal(true, "convert").find(name + std::string(": is a symbolic link")), std::string::npos);
    }
    put("run.json", R"({"program": "gpvc", "command": "convert", "outputs": ["run.json"]})");
    results::OutputFolder folder(out_, true, "convert");
    EXPECT_THROW(folder.file(name + std::string("/b.jpg")), OutputError);
    make(folder, "late/b.jpg", "new");
    fs::create_directory_symlink(away, out_ / "late");  // only after it was looked at
    EXPECT_THROW(folder.publish(), OutputError);
    fs::remove(out_ / "late");
    fs::remove(out_ / name);
  }
  // A link in the place of a file is replaced itself.
  put("run.json", R"({"program": "gpvc", "command": "convert", "outputs": ["b.jpg", "run.json"]})");
  fs::create_symlink(away / "a.jpg", out_ / "b.jpg");
  results::OutputFolder folder(out_, true, "convert");
  make(folder, "b.jpg", "new");
  folder.publish();
  EXPECT_EQ(names(), (std::vector<std::string>{"b.jpg", "real"}));
  EXPECT_EQ(read_file(away / "a.jpg") + read_file(away / "deep/a.jpg"), "minemine");
  EXPECT_EQ(std::distance(fs::directory_iterator(away), fs::directory_iterator()), 2);
}

TEST_F(OutputFolderTest, LeftoversAreRemovedAndNeverTaken) {
  // Of runs that were killed, whatever number their process had.
  for (const std::string name : {"1", "4242", "a1B2c3"}) put(".gpvc-unfinished-" + name + "/stale.jpg", "stale");
  std::optional<results::OutputFolder> folder(std::in_place, out_, false, "convert");
  make(*folder, "fresh.jpg", "fresh");
  // One under way is none.
  EXPECT_NE(refusal(false, "convert").find("another run"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder->in_making() / "fresh.jpg"));
  folder->promise_all();
  folder->publish();
  folder.reset();
  EXPECT_EQ(read_file(out_ / "fresh.jpg"), "fresh");
  EXPECT_FALSE(fs::exists(out_ / "stale.jpg"));
  EXPECT_EQ(names(), std::vector<std::string>{"fresh.jpg"});
}

TEST_F(OutputFolderTest, SaysBeforeTheWorkThatTheDiskIsTooFull) {
  struct Warnings : results::Observer {
    void warning(const std::string& text, const std::vector<Cure>& /*cures*/ = {}) override { said += text; }
    std::string said;
  } observer;
  const results::OutputFolder folder(out_, false, "texture");
  const auto free = static_cast<double>(fs::space(out_).available);
  folder.expect_space(0, free / 2, observer);
  EXPECT_EQ(observer.said, "");
  folder.expect_space(0, 2 * free + 1e9, observer);
  EXPECT_TRUE(test::contains(observer.said, "out: the disk has "));
  EXPECT_TRUE(test::contains(observer.said, "may take"));
  EXPECT_THROW(folder.expect_space(2 * free + 1e9, 2 * free + 1e9, observer), OutputError);
}

}  // namespace
}  // namespace gpvc
