#include "app/texrecon/report.h"

#include <fmt/format.h>

#include <cstdio>

#include "app/cli/interrupt.h"

namespace gpvc::texrecon {
namespace {

void print(std::FILE* to, const std::string& text) {
  std::fputs((results::printable(text) + "\n").c_str(), to);
  std::fflush(to);
}

}  // namespace

void Report::begin(const results::StageInfo& stage) {
  check_cancelled();
  RunLog::begin(stage);
  last_line_ = Clock::now();
}

void Report::progress(std::size_t done, std::size_t total) {
  check_cancelled();
  constexpr double kEvery = 5;
  if (seconds_since(last_line_) < kEvery) return;
  last_line_ = Clock::now();
  print(stdout, stage().ends_early ? fmt::format("{}: {} {}", stage().name, done, stage().unit)
                                   : fmt::format("{}: {}/{} {}", stage().name, done, total, stage().unit));
}

void Report::end(const std::string& summary) {
  RunLog::end(summary);
  print(stdout, fmt::format("{}: {}{:.1f} s", stage().name, summary.empty() ? "" : summary + ", ",
                            stages.back()["wall_s"].get<double>()));
  check_cancelled();
}

void Report::note(const std::string& text) { print(stdout, text); }

void Report::warning(const std::string& text, const std::vector<Cure>&) {
  std::fflush(stdout);
  print(stderr, "gpvc-texrecon: warning: " + text);
}

void Report::check_cancelled() { cli::throw_if_interrupted(); }

std::string Report::timings() const {
  std::string csv = "Event, Absolute clocks, Absolute milliseconds, Relative clocks, Relative milliseconds\n";
  double wall = 0, cpu = 0;
  for (const evaluate::Json& stage : stages) {
    const double stage_wall = 1000 * stage["wall_s"].get<double>(), stage_cpu = 1000 * stage["cpu_s"].get<double>();
    wall += stage_wall;
    cpu += stage_cpu;
    csv += fmt::format("{}, {:.0f}, {:.0f}, {:.0f}, {:.0f}\n", stage["name"].get<std::string>(), cpu, wall, stage_cpu,
                       stage_wall);
  }
  return csv;
}

void Report::finish(const std::string& what) {
  print(stdout, fmt::format("{}, {:.1f} s in all", what, seconds_since(start_)));
}

}  // namespace gpvc::texrecon
