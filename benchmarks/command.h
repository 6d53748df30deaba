// What the benchmarks' programs share: arguments and exit status, CPU time and memory of the process.
#pragma once

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <stdexcept>

namespace gpvc {

inline rusage process_usage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

/// Of all threads, user and system.
inline double cpu_seconds() {
  const rusage usage = process_usage();
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

inline double peak_megabytes() { return static_cast<double>(process_usage().ru_maxrss) / 1024; }

/// Parses the arguments, calls body() and returns the exit status: body's own, 1 after an exception, 2 for bad usage.
template <class Body>
int run_benchmark(CLI::App& app, int argc, char** argv, Body body) {
  try {
    app.parse(argc, argv);
    return body();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace gpvc
