// A run that does not look whether it was interrupted.
#include "app/cli/interrupt.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "app/results/output_folder.h"
#include "io/file_bytes.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

TEST(Interrupt, EndsARunThatDoesNotListenAndClearsAway) {
  const test::TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "out";
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    cli::install_signal_handlers();
    results::OutputFolder files(out, false, "texture");
    std::ofstream(files.file("model.obj")) << "half";
    const cli::EndsSoonAfterSignal ends([&] { files.discard(); });
    raise(SIGTERM);
    for (;;) sleep(60);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)) << "a second, on an idle machine";
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Interrupt, LeavesARunAloneThatIsPublishing) {
  const pid_t child = fork();
  if (child == 0) {
    cli::install_signal_handlers();
    {
      const cli::EndsSoonAfterSignal ends([] {});
    }
    raise(SIGTERM);
    std::this_thread::sleep_for(std::chrono::seconds(1));
    _exit(7);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

TEST(Interrupt, AFileThatIsCutShortWhileItIsMappedGivesOneSentence) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "mesh.ply";
  std::ofstream(file) << std::string(1 << 20, ' ');
  int said[2];
  ASSERT_EQ(pipe(said), 0);
  const pid_t child = fork();
  if (child == 0) {
    dup2(said[1], STDERR_FILENO);
    cli::install_signal_handlers();
    const io::FileBytes bytes(file, io::FileBytes::Use::in_places);
    std::filesystem::resize_file(file, 1);
    volatile char last = bytes.view().back();
    _exit(last == ' ' ? 7 : 8);
  }
  close(said[1]);
  std::string text(4096, '\0');
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, read(said[0], text.data(), text.size()))));
  close(said[0]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(text.starts_with("gpvc: error: a file became shorter while it was read")) << text;
}

}  // namespace
}  // namespace gpvc
