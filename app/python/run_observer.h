// What a run reports, for Python.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "app/evaluate/run_log.h"
#include "app/python/python.h"
#include "app/python/worker.h"

namespace gpvc::python {

/// Keeps stages, figures and messages, tells a Python function of the progress, and cancels the run once it is asked to.
class RunObserver final : public evaluate::RunLog {
 public:
  /// \param progress called as progress(stage, done, total), with the interpreter's lock, ten times a second at most and at the
  /// end of a stage; total is 0 where a stage counts nothing; None: nobody
  RunObserver(CancelFlag cancelled, py::object progress);

  void begin(const results::StageInfo& stage) override;
  void progress(std::size_t done, std::size_t total) override;
  void end(const std::string& summary) override;
  void note(const std::string& text) override { notes_.push_back(text); }
  void warning(const std::string& text, const std::vector<Cure>& cures = {}) override;
  void check_cancelled() override;

  /// "stages", "counts", "notes" and "warnings" as JSON.
  std::string json() const;

 private:
  void tell(std::size_t done, std::size_t total);

  CancelFlag cancelled_;
  std::shared_ptr<const py::object> progress_;
  Clock::time_point told_{};
  std::vector<std::string> notes_, warnings_;
};

}  // namespace gpvc::python
