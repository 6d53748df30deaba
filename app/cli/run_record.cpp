#include "app/cli/run_record.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>

#include "app/cli/interrupt.h"
#include "io/clock.h"

namespace gpvc::cli {
namespace {

double seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

double rounded(double s) { return std::round(s * 1e4) / 1e4; }

}  // namespace

double process_cpu_seconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::size_t peak_resident_bytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

Stage::Stage(Console& console, RunRecord& record, std::string name, std::string unit, bool ends_early)
    : console_(console),
      record_(record),
      name_(std::move(name)),
      unit_(std::move(unit)),
      ends_early_(ends_early),
      start_(Clock::now()),
      start_cpu_s_(process_cpu_seconds()) {
  throw_if_interrupted();
  console_.clear_status();
  console_.status(name_ + " ...");
}

double Stage::wall_s() const { return seconds_since(start_); }

void Stage::progress(std::size_t done, std::size_t total) {
  throw_if_interrupted();
  const double elapsed = wall_s();
  std::string text = ends_early_ ? fmt::format("{}: {} {}, {} at most", name_, done, unit_, total)
                                 : fmt::format("{}: {}/{} {}", name_, done, total, unit_);
  if (!ends_early_ && done > 0 && total >= done && elapsed > 0) {
    const double rate = static_cast<double>(done) / elapsed;
    text += rate >= 1 ? fmt::format(", {:.3g}/s", rate) : fmt::format(", {:.3g} s each", 1 / rate);
    text += ", " + readable_duration(static_cast<double>(total - done) / rate) + " left";
  }
  console_.status(text);
}

Progress Stage::reporter() {
  return [this](std::size_t done, std::size_t total) { progress(done, total); };
}

void Stage::finish(const std::string& summary) {
  const double wall = wall_s(), cpu = process_cpu_seconds() - start_cpu_s_;
  Json stage = {{"name", name_}, {"wall_s", rounded(wall)}, {"cpu_s", rounded(cpu)}};
  stage.update(extra_);
  record_.stages.push_back(stage);
  console_.clear_status();
  console_.note(fmt::format("{}: {}{:.2f} s", name_, summary.empty() ? "" : summary + ", ", wall));
  throw_if_interrupted();
}

}  // namespace gpvc::cli
