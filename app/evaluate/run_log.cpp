#include "app/evaluate/run_log.h"

#include <sys/resource.h>

#include <cmath>

namespace gpvc::evaluate {
namespace {

rusage process_usage() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

// Processor time of the whole process, user and system.
double process_cpu_seconds() {
  const rusage usage = process_usage();
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double rounded(double seconds) { return std::round(seconds * 1e4) / 1e4; }

// A dot in the name leads into a nested object.
void set_figure(Json& figures, const std::string& name, const results::Figure& value) {
  const std::size_t dot = name.find('.');
  if (dot != std::string::npos) return set_figure(figures[name.substr(0, dot)], name.substr(dot + 1), value);
  std::visit([&](const auto& known) { figures[name] = known; }, value);
}

}  // namespace

std::size_t peak_resident_bytes() {
  return static_cast<std::size_t>(process_usage().ru_maxrss) * 1024;  // Linux counts in KiB
}

void RunLog::begin(const results::StageInfo& stage) {
  stage_ = stage;
  stage_figures_ = Json::object();
  start_ = Clock::now();
  start_cpu_s_ = process_cpu_seconds();
}

void RunLog::end(const std::string&) {
  Json stage = {{"name", stage_.name},
                {"wall_s", rounded(stage_seconds())},
                {"cpu_s", rounded(process_cpu_seconds() - start_cpu_s_)},
                {"peak_resident_bytes", peak_resident_bytes()}};
  stage.update(stage_figures_);
  stages.push_back(std::move(stage));
}

void RunLog::figure(const std::string& name, const results::Figure& value) { set_figure(counts, name, value); }

void RunLog::stage_figure(const std::string& name, const results::Figure& value) {
  set_figure(stage_figures_, name, value);
}

}  // namespace gpvc::evaluate
