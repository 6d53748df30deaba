#include "app/evaluate/run_log.h"

#include <cmath>

namespace gpvc::evaluate {
namespace {

double rounded(double seconds) { return std::round(seconds * 1e4) / 1e4; }

// A dot in the name leads into a nested object.
void set_figure(Json& figures, const std::string& name, const results::Figure& value) {
  const std::size_t dot = name.find('.');
  if (dot != std::string::npos) return set_figure(figures[name.substr(0, dot)], name.substr(dot + 1), value);
  std::visit([&](const auto& known) { figures[name] = known; }, value);
}

}  // namespace

void RunLog::begin(const results::StageInfo& stage) {
  stage_ = stage;
  stage_figures_ = Json::object();
  start_ = Clock::now();
  start_cpu_s_ = cpu_seconds();
}

void RunLog::end(const std::string&) {
  Json stage = {{"name", stage_.name},
                {"wall_s", rounded(stage_seconds())},
                {"cpu_s", rounded(cpu_seconds() - start_cpu_s_)},
                {"peak_resident_bytes", peak_resident_bytes()}};
  stage.update(stage_figures_);
  stages.push_back(std::move(stage));
}

void RunLog::figure(const std::string& name, const results::Figure& value) { set_figure(counts, name, value); }

void RunLog::stage_figure(const std::string& name, const results::Figure& value) {
  set_figure(stage_figures_, name, value);
}

}  // namespace gpvc::evaluate
