// The stages and figures of a run, as run.json and reports list them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/evaluate/json.h"
#include "app/results/observer.h"
#include "io/clock.h"

namespace gpvc::evaluate {

/// Keeps what a run reports and shows nothing.
class RunLog : public results::Observer {
 public:
  void begin(const results::StageInfo& stage) override;
  void end(const std::string& summary) override;
  void figure(const std::string& name, const results::Figure& value) override;
  void stage_figure(const std::string& name, const results::Figure& value) override;

  Json stages = Json::array();  ///< name, wall_s, cpu_s, peak_resident_bytes until its end, and the stage's figures
  Json counts = Json::object();

 protected:
  const results::StageInfo& stage() const { return stage_; }
  double stage_seconds() const { return seconds_since(start_); }

 private:
  results::StageInfo stage_;
  Clock::time_point start_;
  double start_cpu_s_ = 0;
  Json stage_figures_ = Json::object();
};

}  // namespace gpvc::evaluate
