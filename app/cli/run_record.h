// The frame of every command that writes a result: console output, run.json and the output folder.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/options.h"
#include "app/evaluate/json.h"
#include "app/evaluate/run_log.h"
#include "app/results/output_folder.h"

namespace gpvc::cli {

using evaluate::Json;

/// Shows a run on the console and keeps its stages and figures for run.json. Throws Cancelled after Ctrl-C.
class RunRecord final : public evaluate::RunLog {
 public:
  /// `watcher` hears of stages, progress and warnings as well, and can cancel; null: nobody.
  explicit RunRecord(Console& shown_on, results::Observer* watcher = nullptr) : console(shown_on), watcher_(watcher) {}

  void begin(const results::StageInfo& stage) override;
  void progress(std::size_t done, std::size_t total) override;
  /// Prints "NAME: SUMMARY, 1.23 s".
  void end(const std::string& summary) override;
  void note(const std::string& text) override { console.note(text); }
  void detail(const std::string& text) override { console.detail(text); }
  void warning(const std::string& text, const std::vector<Cure>& cures = {}) override;
  void check_cancelled() override;

  Console& console;

 private:
  /// The first report of a stage. Rates are counted from there, because a stage may prepare its steps first.
  struct FirstReport {
    std::size_t done;
    double seconds;
  };
  std::optional<FirstReport> first_;
  results::Observer* watcher_;
};

/// Has the console say what is kept of a run that is interrupted.
void note_kept_work(const CommandOptions& options, const pipeline::Settings& settings, Console& console);

/// What a command gives beside its files.
struct RunFacts {
  Json options = Json::object();  ///< for run.json, as the device
  Json device = Json::object();
  std::string result{};   ///< printed once the files have their final names; empty: nothing
  std::string failure{};  ///< then thrown; empty: none
};

/// Runs a command whose result is a folder: calls `body`, which writes files into the folder, adds run.json and gives
/// everything its final name. Errors name files by their final names. \param watcher of RunRecord
void run_command(const std::string& name, const CommandOptions& options, Console& console,
                 const std::function<RunFacts(RunRecord& record, results::OutputFolder& folder)>& body,
                 results::Observer* watcher = nullptr);

}  // namespace gpvc::cli
