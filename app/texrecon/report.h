// What a run prints: plain lines, as logs keep them.
#pragma once

#include <string>

#include "app/evaluate/run_log.h"

namespace gpvc::texrecon {

/// Prints on standard output: a line for each stage, and within it every five seconds. Warnings go to standard error. Throws
/// Cancelled after a signal.
class Report final : public evaluate::RunLog {
 public:
  void begin(const results::StageInfo& stage) override;
  void progress(std::size_t done, std::size_t total) override;
  void end(const std::string& summary) override;
  void note(const std::string& text) override;
  void warning(const std::string& text, const std::vector<Cure>& cures = {}) override;
  void check_cancelled() override;

  /// The stages as texrecon's _timings.csv has its own.
  std::string timings() const;
  /// The last line: what was written, and how long all of it took.
  void finish(const std::string& what);

 private:
  Clock::time_point start_ = Clock::now(), last_line_ = start_;
};

}  // namespace gpvc::texrecon
