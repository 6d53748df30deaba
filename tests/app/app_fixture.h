// The program itself, started on a copy of a small scene that may be spoilt.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc::test {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code = -1;  ///< 128 + signal when killed by one
  std::string out, err;
};

class Program {
 public:
  // Starts gpvc, or another program. `in_child` runs before it, in its process.
  explicit Program(const std::vector<std::string>& arguments, const std::function<void()>& in_child = {},
                   const char* binary = GPVC_BINARY) {
    const fs::path out = folder_.path() / "stdout", err = folder_.path() / "stderr";
    process_ = fork();
    if (process_ != 0) return;
    const int out_file = open(out.c_str(), O_CREAT | O_WRONLY, 0600),
              err_file = open(err.c_str(), O_CREAT | O_WRONLY, 0600);
    dup2(out_file, STDOUT_FILENO);
    dup2(err_file, STDERR_FILENO);
    // A shell's background jobs ignore SIGINT, and gpvc goes on ignoring what it was started to ignore.
    for (const int sent : {SIGINT, SIGTERM, SIGHUP}) signal(sent, SIG_DFL);
    if (in_child) in_child();
    std::vector<std::string> words{binary};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(binary, argv.data());
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

inline Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& in_child = {}) {
  return Program(arguments, in_child).wait();
}

/// A copy of the small scene that may be spoilt.
class App : public testing::Test {
 protected:
  void SetUp() override {
    if (visibility::list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    ASSERT_TRUE(fs::exists(fs::path(GPVC_APP_SCENE) / "run.json")) << "ctest makes the scene: app_scene.synth";
    fs::copy(GPVC_APP_SCENE, scene_, fs::copy_options::recursive);
  }
  std::vector<std::string> texture(const fs::path& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"texture", (scene_ / "colmap").string(), (scene_ / "mesh.ply").string(), "-o",
                                   out.string()};
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

inline nlohmann::json run_json(const fs::path& out) { return nlohmann::json::parse(read_file(out / "run.json")); }

// The values of a little-endian .npy of one dimension.
template <class T>
std::vector<T> npy(const fs::path& file) {
  const std::string bytes = read_file(file);
  if (bytes.size() < 10) return {};
  const std::size_t start = 10u + static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  std::vector<T> values((bytes.size() - start) / sizeof(T));
  std::memcpy(values.data(), bytes.data() + start, values.size() * sizeof(T));
  return values;
}

// Leaves OUT as a run does that is killed while it publishes a result, before it moves these files to their names.
inline void kill_publication(const fs::path& out, const std::vector<std::string>& files) {
  const fs::path work = out / ".gpvc-unfinished-abcdef";
  for (const std::string& name : files) {
    fs::create_directories((work / "new" / name).parent_path());
    fs::rename(out / name, work / "new" / name);
  }
  std::ofstream(work / "publishing.json") << nlohmann::json{{"replaced", nlohmann::json::array()}, {"promised", files}};
}

inline std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
  return files;
}
}  // namespace gpvc::test
