// Runs that are killed at every step of publishing, and two runs in one folder.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "app/results/output_folder.h"
#include "app/results/output_names.h"
#include "tests/support/temporary_folder.h"

namespace {

int steps_left = -1;  ///< before the process kills itself; -1: never

void step() {
  if (steps_left >= 0 && steps_left-- == 0) kill(getpid(), SIGKILL);
}

}  // namespace

// In place of the C library's, so that every change of a name is a step.
extern "C" int renameat2(int from, const char* name, int to, const char* new_name, unsigned flags) noexcept {
  step();
  return static_cast<int>(syscall(SYS_renameat2, from, name, to, new_name, flags));
}
extern "C" int rename(const char* name, const char* new_name) noexcept {
  step();
  return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, name, AT_FDCWD, new_name, 0U));
}
extern "C" int unlinkat(int folder, const char* name, int flags) noexcept {
  step();
  return static_cast<int>(syscall(SYS_unlinkat, folder, name, flags));
}
extern "C" int unlink(const char* name) noexcept {
  step();
  return static_cast<int>(syscall(SYS_unlinkat, AT_FDCWD, name, 0));
}
extern "C" int remove(const char* name) noexcept {
  step();
  const auto unlinked = [&](int flags) { return static_cast<int>(syscall(SYS_unlinkat, AT_FDCWD, name, flags)); };
  return unlinked(0) == 0 ? 0 : unlinked(AT_REMOVEDIR);
}

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::read_file;

using Files = std::map<std::string, std::string>;

class PublicationTest : public testing::Test {
 protected:
  void publish(const Files& files) const {
    results::OutputFolder folder(out_, true, "texture");
    for (const auto& [name, text] : files) std::ofstream(folder.file(name)) << text;
    std::ofstream run(folder.file("run.json"));
    run << nlohmann::json{
        {"program", "gpvc"}, {"command", "texture"}, {"outputs", results::outputs_json(folder.promised())}};
    run.close();
    fs::create_directories(out_ / ".work");
    std::ofstream(out_ / ".work/view-0.part-1") << "kept until there is a result";
    folder.publish();
  }
  // Runs `work` in a process that is killed at its step `steps`. Returns false if it ended before.
  static bool killed_at(int steps, const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
      steps_left = steps;
      try {
        work();
      } catch (const std::exception&) {
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status);
  }
  std::string refusal() const {
    try {
      const results::OutputFolder folder(out_, false, "texture");
    } catch (const OutputError& error) {
      return error.what();
    }
    return "";
  }
  // All files of OUT but run.json, hidden ones too.
  Files files() const {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(out_))
      if (!entry.is_directory()) files[entry.path().lexically_relative(out_).string()] = read_file(entry.path());
    files.erase("run.json");
    return files;
  }
  // The files that run.json claims.
  std::vector<std::string> listed() const {
    return results::output_names(nlohmann::ordered_json::parse(read_file(out_ / "run.json"))["outputs"]);
  }
  void expect_whole(const Files& result) const {
    EXPECT_EQ(files(), result);
    for (const std::string& name : listed()) EXPECT_TRUE(fs::exists(out_ / name)) << name;
    EXPECT_EQ(listed().size(), result.size() + 1);
  }

  const Files first_{{"model.obj", "1"}, {"old/page.jpg", "1"}, {"views/a\xFF.npy", "1"}},
      second_{{"model.obj", "2"}, {"new/page.jpg", "2"}, {"views/a\xFF.npy", "2"}};
  test::TemporaryFolder folder_;
  fs::path out_ = folder_.path() / "out";
};

TEST_F(PublicationTest, AKillAtAnyStepIsRepairedByTheNextRun) {
  int steps = 0, finished = 0;
  for (bool killed = true; killed; ++steps) {
    fs::remove_all(out_);
    publish(first_);
    killed = killed_at(steps, [&] { publish(second_); });
    EXPECT_TRUE(contains(refusal(), "already holds a result")) << steps;
    // Whole, the one or the other: whichever there was when the moves began.
    const bool fresh = read_file(out_ / "model.obj") == "2";
    finished += fresh;
    if (!fresh) fs::remove_all(out_ / ".work");  // for the run that goes on
    expect_whole(fresh ? second_ : first_);
  }
  EXPECT_GT(steps, 12) << "eight renames, and what clears away after them";
  EXPECT_GT(finished, 8);
}

TEST_F(PublicationTest, AKillDuringTheRepairIsRepairedToo) {
  for (const int steps : {1, 2, 6, 10}) {
    bool again = true;
    for (int more = 0; again; ++more) {
      fs::remove_all(out_);
      publish(first_);
      killed_at(steps, [&] { publish(second_); });
      again = killed_at(more, [&] { refusal(); });
      EXPECT_TRUE(contains(refusal(), "already holds a result")) << steps << ' ' << more;
      const bool fresh = read_file(out_ / "model.obj") == "2";
      if (!fresh) fs::remove_all(out_ / ".work");
      expect_whole(fresh ? second_ : first_);
    }
  }
}

TEST_F(PublicationTest, AFirstResultIsFinishedAndSaid) {
  ASSERT_TRUE(killed_at(3, [&] { publish(second_); }));
  EXPECT_TRUE(contains(refusal(), "had begun to publish and is complete now"));
  expect_whole(second_);
}

TEST_F(PublicationTest, WhatCannotBeFinishedLeavesBothResults) {
  publish(first_);
  ASSERT_TRUE(killed_at(7, [&] { publish(second_); }));
  EXPECT_FALSE(fs::exists(out_ / "run.json"));
  std::ofstream(out_ / "new") << "mine";
  for (int run = 0; run < 2; ++run) {
    EXPECT_TRUE(contains(refusal(), "cannot be finished"));
    EXPECT_EQ(read_file(out_ / "model.obj"), "1");
    EXPECT_EQ(read_file(out_ / "old/page.jpg"), "1");
    EXPECT_EQ(listed().size(), first_.size() + 1);
  }
  fs::remove(out_ / "new");
  EXPECT_TRUE(contains(refusal(), "complete now"));
  expect_whole(second_);
}

TEST_F(PublicationTest, ASecondRunIsRefusedAtItsStart) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    results::OutputFolder folder(out_, false, "texture");
    std::ofstream(folder.file("model.obj")) << "half";
    if (write(ready[1], "x", 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_TRUE(contains(refusal(), "another run of gpvc (process " + std::to_string(child)));
  EXPECT_EQ(files().size(), 2u) << "the lock, and a file in the making";
  // The lock dies with its process.
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(refusal(), "");
  EXPECT_EQ(files(), Files{});
}

TEST_F(PublicationTest, DiscardingLeavesNothing) {
  results::OutputFolder folder(out_, false, "texture");
  std::ofstream(folder.file("model.obj")) << "half";
  folder.discard();
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
}  // namespace gpvc
