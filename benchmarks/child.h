// Programs, and parts of a benchmark, that run in processes of their own.
#pragma once

#include <sys/resource.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gpvc {

struct Ended {
  int status = 0;  ///< as wait() gives it; 0: success
  rusage usage{};
};

/// "exit status 2", "signal 9"
std::string how_ended(int status);

/// Runs a program to its end with its output in `log`. A program that cannot be started ends with 127. Throws
/// std::system_error.
Ended run_program(std::vector<std::string> words, const std::filesystem::path& log);

/// What body() returns, called in a process of its own. A program inherits the memory peak of the process that starts it
/// (getrusage's ru_maxrss outlives exec), so a process that measures programs must stay small. Throws std::runtime_error
/// with the message of what body() throws. \pre this process has not used TBB: a fork has none of its threads
std::string in_own_process(const std::function<std::string()>& body);

}  // namespace gpvc
