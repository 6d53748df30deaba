// The command line of gpvc.
#pragma once

namespace gpvc::cli {

inline constexpr int kFailed = 1, kBadUsage = 2, kInterrupted = 130;  ///< exit codes beside 0

/// Runs one command and returns its exit code: 0 when every promised file is complete, 1 for bad input or a failed run,
/// 2 for bad usage, 130 when interrupted. Results go to stdout; progress, warnings and errors to stderr.
int run_command_line(int argc, char** argv);

}  // namespace gpvc::cli
