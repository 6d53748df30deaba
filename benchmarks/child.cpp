#include "benchmarks/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <exception>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace gpvc {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_errno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

Ended wait_for(pid_t child) {
  Ended ended;
  while (wait4(child, &ended.status, 0, &ended.usage) < 0)
    if (errno != EINTR) throw_errno("wait4");
  return ended;
}

}  // namespace

std::string how_ended(int status) {
  return WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status))
                             : fmt::format("exit status {}", WEXITSTATUS(status));
}

Ended run_program(std::vector<std::string> words, const fs::path& log) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int output = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (output < 0) throw_errno(log.string());
  const pid_t child = fork();
  if (child == 0) {
    if (dup2(output, STDOUT_FILENO) >= 0 && dup2(output, STDERR_FILENO) >= 0) execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(output);
  if (child < 0) throw_errno("fork");
  return wait_for(child);
}

std::string in_own_process(const std::function<std::string()>& body) {
  std::array<int, 2> ends{};  // of a pipe: to read from, to write to
  if (pipe(ends.data()) != 0) throw_errno("pipe");
  const pid_t child = fork();
  if (child < 0) throw_errno("fork");
  if (child == 0) {
    std::string text;
    int status = 0;
    try {
      text = body();
    } catch (const std::exception& error) {
      text = error.what();
      status = 1;
    }
    for (std::string_view rest = text; !rest.empty();) {
      const ssize_t written = write(ends[1], rest.data(), rest.size());
      if (written < 0) _exit(1);
      rest.remove_prefix(static_cast<std::size_t>(written));
    }
    _exit(status);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 4096> part;
  for (ssize_t got = 0; (got = read(ends[0], part.data(), part.size())) > 0;)
    text.append(part.data(), static_cast<std::size_t>(got));
  close(ends[0]);
  const Ended ended = wait_for(child);
  if (ended.status != 0)
    throw std::runtime_error(text.empty() ? "a part of it ended with " + how_ended(ended.status) : text);
  return text;
}

}  // namespace gpvc
