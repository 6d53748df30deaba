#include "app/cli/run_record.h"

#include <fmt/format.h>
#include <tbb/info.h>

#include "app/cli/interrupt.h"

namespace gpvc::cli {
namespace {

// To be called last: lists the files promised so far and the time spent.
void write_run_json(const std::string& command, const CommonOptions& common, const RunFacts& facts,
                    const RunRecord& record, results::OutputFolder& folder) {
  const auto file = folder.file("run.json");
  double wall = 0, cpu = 0;
  for (const Json& stage : record.stages) {
    wall += stage["wall_s"].get<double>();
    cpu += stage["cpu_s"].get<double>();
  }
  evaluate::write_json(file, {{"program", "gpvc"},
                              {"version", program_version()},
                              {"command", command},
                              {"command_line", common.command_line},
                              {"options", facts.options},
                              {"threads", common.threads > 0 ? common.threads : tbb::info::default_concurrency()},
                              {"device", facts.device},
                              {"stages", record.stages},
                              {"wall_s", wall},
                              {"cpu_s", cpu},
                              {"peak_resident_bytes", peak_resident_bytes()},
                              {"counts", record.counts},
                              {"outputs", Json::parse(folder.promised_json())}});
}

}  // namespace

void note_kept_work(const CommandOptions& options, const pipeline::Settings& settings, Console& console) {
  if (settings.keep_work == pipeline::KeepWork::never) return;
  const std::string folder = (options.out / ".work").string();
  console.note_kept(folder, fmt::format("work is kept in {}, and the same command goes on from there", folder));
}

void RunRecord::begin(const results::StageInfo& stage) {
  check_cancelled();
  RunLog::begin(stage);
  first_.reset();
  console.clear_status();
  console.status(stage.name + " ...");
  if (watcher_) watcher_->begin(stage);
}

void RunRecord::progress(std::size_t done, std::size_t total) {
  check_cancelled();
  if (watcher_) watcher_->progress(done, total);
  if (!first_) first_ = {done, stage_seconds()};
  const double elapsed = stage_seconds() - first_->seconds;
  const auto& [name, unit, ends_early] = stage();
  std::string text = ends_early ? fmt::format("{}: {} {}, {} at most", name, done, unit, total)
                                : fmt::format("{}: {}/{} {}", name, done, total, unit);
  if (!ends_early && done > first_->done && total >= done && elapsed > 0) {
    const double rate = static_cast<double>(done - first_->done) / elapsed;
    text += rate >= 1 ? fmt::format(", {:.3g}/s", rate) : fmt::format(", {:.3g} s each", 1 / rate);
    text += ", " + results::readable_duration(static_cast<double>(total - done) / rate) + " left";
  }
  console.status(text);
}

void RunRecord::end(const std::string& summary) {
  RunLog::end(summary);
  console.clear_status();
  console.note(fmt::format("{}: {}{:.2f} s", stage().name, summary.empty() ? "" : summary + ", ",
                           stages.back()["wall_s"].get<double>()));
  check_cancelled();
}

void RunRecord::warning(const std::string& text, const std::vector<Cure>& cures) {
  console.warning(text, cures);
  if (watcher_) watcher_->warning(text, cures);
}

void RunRecord::check_cancelled() {
  throw_if_interrupted();
  if (watcher_) watcher_->check_cancelled();
}

void run_command(const std::string& name, const CommandOptions& options, Console& console,
                 const std::function<RunFacts(RunRecord& record, results::OutputFolder& folder)>& body,
                 results::Observer* watcher) {
  RunFacts facts;
  results::OutputFolder folder(options.out, options.force, name);
  try {
    RunRecord record(console, watcher);
    {
      const EndsSoonAfterSignal ends([&] {
        folder.discard();
        console.interrupted();
      });
      facts = body(record, folder);
      write_run_json(name, options.common, facts, record, folder);
    }
    folder.publish();
  } catch (const OutputError& e) {
    throw Error(folder.with_final_names(e.what()), e.cures(), e.measures());
  }
  if (!facts.result.empty()) console.result(facts.result);
  if (!facts.failure.empty()) throw std::runtime_error(facts.failure);
}

}  // namespace gpvc::cli
