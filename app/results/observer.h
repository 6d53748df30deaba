// An Observer receives the progress, messages and figures of a run, and can cancel it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "../../io/error.h"
#include "../../io/progress.h"

namespace gpvc::results {

/// A stage of a run, as the user sees it.
struct StageInfo {
  std::string name;         ///< "view selection"
  std::string unit = {};    ///< what progress() counts, plural ("views"); empty: the stage reports no progress
  bool ends_early = false;  ///< the total that progress() reports is an upper limit
};

using Figure = std::variant<std::size_t, double, std::string>;

/// Override the functions of interest; by default they do nothing. An exception thrown by one of them stops the run and
/// reaches its caller; throw Cancelled to cancel. Calls come one at a time, from any thread, except for check_cancelled(),
/// which several threads may call at once.
class Observer {
 public:
  virtual ~Observer() = default;

  /// Stages do not overlap. A stage that throws never calls end().
  virtual void begin(const StageInfo& /*stage*/) {}
  virtual void progress(std::size_t /*done*/, std::size_t /*total*/) {}
  /// `summary`: the result of the stage, "12 views"; may be empty.
  virtual void end(const std::string& /*summary*/) {}

  virtual void note(const std::string& /*text*/) {}
  virtual void detail(const std::string& /*text*/) {}
  /// `cures`: what the caller may do about it; the text names no option of a command line.
  virtual void warning(const std::string& /*text*/, const std::vector<Cure>& /*cures*/ = {}) {}

  /// A figure of the whole run. A dot in the name groups figures: "tags.seen".
  virtual void figure(const std::string& /*name*/, const Figure& /*value*/) {}
  /// A figure of the current stage, such as the time of one of its parts.
  virtual void stage_figure(const std::string& /*name*/, const Figure& /*value*/) {}

  /// Called between progress reports, so that a run can be cancelled soon.
  virtual void check_cancelled() {}

  /// progress() in the form that io and atlas take; valid as long as the observer.
  Progress reporter() {
    return [this](std::size_t done, std::size_t total) { progress(done, total); };
  }
};

/// Progress of a part of a larger whole of `total` steps, `before` of which precede the part. Borrows `whole`.
inline Progress part_of(const Progress& whole, std::size_t before, std::size_t total) {
  return [&whole, before, total](std::size_t done, std::size_t) { whole(before + done, total); };
}

/// `text` as it may be shown anywhere: control characters other than tabs and line ends, and bytes that are no UTF-8, which
/// names from files may contain, as \xNN.
std::string printable(const std::string& text);
/// 1234567 as "1 234 567".
std::string readable_count(std::size_t count);
/// "640 MB", "3.2 GB".
std::string readable_bytes(double bytes);
/// Reads "600M", "4G", "1.5 GB" (powers of 1000) or "4Gi", "4GiB" (powers of 1024); nullopt for what is no amount of 1 byte to 2^60.
std::optional<std::size_t> bytes_from_text(const std::string& text);
/// "45 s", "2 min 10 s", "3 h 5 min".
std::string readable_duration(double seconds);
/// The first `most` of some names: "a, b, c, ...".
std::string readable_list(std::span<const std::string> names, std::size_t most);

}  // namespace gpvc::results
