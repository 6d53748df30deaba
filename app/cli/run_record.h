// What a run did and what it cost: the stages as the user sees them, and run.json.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/cli/console.h"
#include "io/clock.h"
#include "io/io.h"

namespace gpvc::cli {

using Json = nlohmann::ordered_json;

/// Seconds of processor time of the whole process, user and system.
double process_cpu_seconds();
/// Peak resident memory of the process.
std::size_t peak_resident_bytes();

struct RunRecord {
  Json stages = Json::array();  ///< name, wall_s, cpu_s, and what the stage adds
  Json counts = Json::object();
};

/// Progress of a part of a whole of `total` steps, `before` of which were done before it. Borrows `whole`.
inline Progress part_of(const Progress& whole, std::size_t before, std::size_t total) {
  return [&whole, before, total](std::size_t done, std::size_t) { whole(before + done, total); };
}

/// A stage of a command from construction to finish(): progress on the console, time into the record.
class Stage {
 public:
  /// `unit`: what progress counts ("views"), plural. `ends_early`: the total is a limit, not an estimate of the work.
  Stage(Console& console, RunRecord& record, std::string name, std::string unit = "", bool ends_early = false);

  /// Throws Cancelled after Ctrl-C.
  void progress(std::size_t done, std::size_t total);
  /// progress() as the stages take it; valid as long as this object.
  Progress reporter();
  /// Something for the record: a share of the time, a count.
  void add(const std::string& key, const Json& value) { extra_[key] = value; }
  /// Prints "NAME: SUMMARY in 1.23 s".
  void finish(const std::string& summary);

 private:
  double wall_s() const;

  Console& console_;
  RunRecord& record_;
  std::string name_, unit_;
  bool ends_early_;
  Clock::time_point start_;
  double start_cpu_s_;
  Json extra_ = Json::object();
};

}  // namespace gpvc::cli
