// What the program does to the output folder, and when it cannot write.
#include <sys/mount.h>
#include <sys/resource.h>

#include <chrono>
#include <thread>

#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;

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

TEST_F(App, CommandsThatReadAResultFinishItWhereItsPublicationWasKilled) {
  ASSERT_EQ(run(texture(out_, {"--editable"})).exit_code, 0);
  const auto before = files_of(out_);
  const auto is_finished_by = [&](const std::vector<std::string>& words) {
    kill_publication(out_, {"edit-model.bin", "faces.npy", "model.obj", "model_0.jpg", "run.json", "views.json"});
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return files_of(out_) == before;
  };
  EXPECT_TRUE(is_finished_by(texture(folder_.path() / "other", {"--from", out_.string()})));
  EXPECT_TRUE(is_finished_by({"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string()}));
  const std::string vertex = read_file(out_ / "model.obj");
  const std::size_t at = vertex.find("\nv ") + 3;
  std::string place = vertex.substr(at, vertex.find('\n', at) - at);
  std::ranges::replace(place, ' ', ',');
  EXPECT_TRUE(is_finished_by({"inspect", out_.string(), "--at", place}));
}

TEST_F(App, RefusesToOverwriteItsOwnMesh) {
  folder_.write("scene/model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto before = files_of(scene_);
  expect_one_sentence(
      run({"texture", (scene_ / "colmap").string(), (scene_ / "model.obj").string(), "-o", scene_.string(), "--force"}),
      "model.obj", "input");
  EXPECT_TRUE(files_of(scene_) == before);
}

TEST_F(App, ForceNeverRemovesWhatTheRunReads) {
  // The whole scene is listed in the run.json that synth left beside it.
  const auto before = files_of(scene_);
  for (const char* command : {"texture", "visibility"}) {
    auto words = texture(scene_, {"--force"});
    words[0] = command;
    expect_one_sentence(run(words), scene_.string(), "holds the result of 'gpvc synth city'");
    EXPECT_EQ(files_of(scene_), before);
  }
  // A copy of it without the command's name is told by what is read.
  replace_in(scene_ / "run.json", "\"command\": \"synth city\"", "\"command\": \"texture\"");
  const auto disguised = files_of(scene_);
  expect_one_sentence(run(texture(scene_, {"--force"})), scene_.string(), "is read by this run");
  EXPECT_EQ(files_of(scene_), disguised);
  // A result beside the cameras is no input.
  ASSERT_EQ(run(texture(scene_ / "colmap")).exit_code, 0);
  EXPECT_EQ(run(texture(scene_ / "colmap", {"--force"})).exit_code, 0);
  EXPECT_EQ(read_file(scene_ / "colmap" / "images.txt"), disguised.at("colmap/images.txt"));
  ASSERT_EQ(run(texture(out_)).exit_code, 0);
  const auto model = files_of(out_);
  expect_one_sentence(run({"evaluate", (out_ / "model.obj").string(), (scene_ / "colmap").string(), "--images",
                           (scene_ / "images").string(), "-o", out_.string(), "--force"}),
                      out_.string(), "holds the result of 'gpvc texture'");
  EXPECT_EQ(files_of(out_), model);
}

TEST_F(App, RunsOnAfterALogout) {
  const auto ignore = [] { signal(SIGHUP, SIG_IGN); };  // as nohup does
  Program program(texture(out_), ignore);
  while (program.running() && !fs::exists(out_)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  program.send(SIGHUP);
  EXPECT_EQ(program.wait().exit_code, 0);
  EXPECT_TRUE(fs::exists(out_ / "model.glb"));
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
    GTEST_SKIP() << "no permission to mount a small file system; FullDiskAnywhereLeavesNothing covers the rest";
  const Outcome outcome = run(texture(disk / "out"));
  const bool left = fs::exists(disk / "out");
  umount2(disk.c_str(), MNT_DETACH);
  expect_one_sentence(outcome, (disk / "out").string(), "No space left");
  EXPECT_FALSE(left);
}

TEST_F(App, AFullDiskIsSaidBeforeTheWork) {
  const fs::path disk = folder_.path() / "disk";
  fs::create_directories(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=40k") != 0)
    GTEST_SKIP() << "no permission to mount a small file system";
  auto words = texture(disk / "out");
  std::vector<Outcome> outcomes{run(words)};
  words[0] = "visibility";
  words.push_back("--ivm");
  outcomes.push_back(run(words));
  const bool left = fs::exists(disk / "out");
  umount2(disk.c_str(), MNT_DETACH);
  for (const Outcome& outcome : outcomes) {
    expect_one_sentence(outcome, (disk / "out").string(), "the result takes at least");
    EXPECT_EQ(outcome.err.find("drawing:"), std::string::npos) << outcome.err;
  }
  EXPECT_FALSE(left);
}

TEST_F(App, NamesCannotLeaveTheOutputFolder) {
  fs::rename(scene_ / "images" / "east_001.jpg", scene_ / "escaped.jpg");
  replace_in(scene_ / "colmap" / "images.txt", "east_001.jpg", "../escaped.jpg");
  auto words = texture(out_);
  words[0] = "visibility";
  expect_one_sentence(run(words), "1 of 5 photos are not in", "");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(App, InterruptLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM})
    for (const int after_ms : {0, 60, 150}) {
      Program program(texture(out_, {"--threads", "1"}));
      while (program.running() && !fs::exists(out_)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
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

TEST_F(App, ClosedStandardDescriptorsReachNoFile) {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    const Outcome outcome = run(texture(out_, {"--force", "-v"}), [descriptor] { close(descriptor); });
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const auto& [name, bytes] : files_of(out_))
      for (const char* said : {"drawing: ", "model.glb\n"}) EXPECT_EQ(bytes.find(said), std::string::npos) << name;
    EXPECT_TRUE(run_json(out_).is_object());
  }
}

// A reader that has ended, as of `gpvc texture ... | true`.
TEST_F(App, AReaderThatHasEndedIsNoFailure) {
  const auto no_reader = [] {
    int ends[2];
    if (pipe(ends) != 0) return;
    close(ends[0]);
    dup2(ends[1], STDOUT_FILENO);
  };
  const Outcome outcome = run(texture(out_), no_reader);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(out_ / "run.json"));
  const Outcome listing = run({"inspect", (scene_ / "colmap").string()}, no_reader);
  EXPECT_EQ(listing.exit_code, 0) << listing.err;
  EXPECT_EQ(listing.err, "");
}

// What a terminal of the kind `term` gets as standard error.
std::string on_terminal(const std::vector<std::string>& words, const char* term) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  EXPECT_GE(terminal, 0);
  EXPECT_EQ(grantpt(terminal) + unlockpt(terminal), 0);
  const int end = open(ptsname(terminal), O_RDWR | O_NOCTTY);
  run(words, [end, term] {
    setenv("TERM", term, 1);
    dup2(end, STDERR_FILENO);
  });
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  std::string text(1 << 16, '\0');
  const ssize_t size = read(terminal, text.data(), text.size());
  close(end);
  close(terminal);
  return text.substr(0, static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
}

TEST_F(App, TerminalsGetNoControlCharactersFromNames) {
  const std::string name = scene_.string() + "/a\x1b[31m\x07\xC2\x9Bz.ply";
  std::vector<std::string> words = texture(out_);
  words[2] = name;
  constexpr const char* kShown = "/a\\x1b[31m\\x07\\xc2\\x9bz.ply";
  for (const char* term : {"dumb", "xterm"}) {
    const std::string shown = on_terminal(words, term);
    EXPECT_TRUE(contains(shown, kShown)) << shown;
    EXPECT_EQ(shown.find("\x1b[31m"), std::string::npos);
  }
  EXPECT_TRUE(contains(run(words).err, kShown)) << "what is written to a file may be shown on a terminal";
}

TEST_F(App, DumbTerminalsGetNoEscapeSequences) {
  EXPECT_EQ(on_terminal(texture(out_), "dumb").find('\x1b'), std::string::npos);
  EXPECT_NE(on_terminal(texture(out_, {"--force"}), "xterm").find('\x1b'), std::string::npos);
}

TEST_F(App, LogFileGetsEverything) {
  const fs::path log = folder_.path() / "run.log";
  const Outcome outcome = run(texture(out_, {"--quiet", "--log", log.string()}));
  ASSERT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* stage : {"read", "see", "choose", "bake", "write"}) EXPECT_TRUE(contains(read_file(log), stage));
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

TEST_F(App, APictureOfPhotosReplacesNoFileThatIsRead) {
  fs::path photo;
  for (const auto& entry : fs::recursive_directory_iterator(scene_))
    if (entry.path().filename() == "east_001.jpg") photo = entry.path();
  const std::string before = read_file(photo);
  const std::vector<std::string> inspect{"inspect", (scene_ / "colmap").string(), (scene_ / "mesh.ply").string()};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = inspect;
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  };
  for (const fs::path& file : {photo, scene_ / "mesh.ply"})
    expect_one_sentence(with({"--check", "--picture", file.string()}), file.string(), "is a file that is read");
  EXPECT_EQ(read_file(photo), before);
  expect_one_sentence(with({"--check", "--picture", (folder_.path() / "no/x.png").string()}), "x.png",
                      "cannot be written");
  EXPECT_EQ(with({"--picture", "x.png"}).exit_code, 2);
  EXPECT_EQ(run({"inspect", (scene_ / "colmap").string(), "--check"}).exit_code, 2);
  EXPECT_EQ(with({"--views", "@" + scene_.string()}).exit_code, 1) << "a folder is no list";
}

}  // namespace
}  // namespace gpvc
