// An Observer receives the progress, messages and figures of a run, and can cancel it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <variant>

#include "../../io/progress.h"

namespace gpvc::pipeline {

/// A stage of a run, as the user sees it.
struct StageInfo {
  std::string name;         ///< "view selection"
  std::string unit = {};    ///< what progress() counts, plural ("views"); empty: the stage reports no progress
  bool ends_early = false;  ///< progress() is told an upper limit, not the amount of work
};

using Figure = std::variant<std::size_t, double, std::string>;

/// Hears what a run does. Every function does nothing unless it is overridden. What an override throws stops the run and
/// passes through to the caller; throw Cancelled to cancel. Functions are called one at a time, from any thread, but for
/// check_cancelled(), which may be called by several threads at once.
class Observer {
 public:
  virtual ~Observer() = default;

  /// Stages follow one another; a stage that throws does not end.
  virtual void begin(const StageInfo& /*stage*/) {}
  virtual void progress(std::size_t /*done*/, std::size_t /*total*/) {}
  /// `summary`: what the stage made, "12 views"; may be empty.
  virtual void end(const std::string& /*summary*/) {}

  virtual void note(const std::string& /*text*/) {}
  virtual void detail(const std::string& /*text*/) {}
  virtual void warning(const std::string& /*text*/) {}

  /// A figure of the whole run. A dot in the name groups figures: "tags.seen".
  virtual void figure(const std::string& /*name*/, const Figure& /*value*/) {}
  /// A figure of the current stage: a part of its time, say.
  virtual void stage_figure(const std::string& /*name*/, const Figure& /*value*/) {}

  /// Called often where there is nothing to report.
  virtual void check_cancelled() {}

  /// progress() as the libraries below take it; valid as long as the observer.
  Progress reporter() {
    return [this](std::size_t done, std::size_t total) { progress(done, total); };
  }
};

/// Progress of a part of a larger whole of `total` steps, `before` of which precede the part. Borrows `whole`.
inline Progress part_of(const Progress& whole, std::size_t before, std::size_t total) {
  return [&whole, before, total](std::size_t done, std::size_t) { whole(before + done, total); };
}

/// 1234567 as "1 234 567".
std::string readable_count(std::size_t count);
/// "45 s", "2 min 10 s", "3 h 5 min".
std::string readable_duration(double seconds);
/// The first `most` of some names: "a, b, c, ...".
std::string readable_list(std::span<const std::string> names, std::size_t most);

}  // namespace gpvc::pipeline
