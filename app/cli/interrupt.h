// How Ctrl-C and other signals stop a run.
#pragma once

#include <functional>

namespace gpvc::cli {

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the run to stop at its next step; a second one kills it. Signals
/// that the program was started with as ignored (nohup: SIGHUP) stay ignored. A file size limit (SIGXFSZ) and a closed
/// pipe (SIGPIPE) become ordinary write errors. A mapped file that is cut short meanwhile (SIGBUS) ends the process with status 1
/// and one sentence. Starts a thread that waits for signals; to be called once.
void install_signal_handlers();

/// Throws Cancelled once a signal has come.
void throw_if_interrupted();

/// Ends the process where a run does not come to throw_if_interrupted() within half a second of a signal: in the middle of
/// a long computation, or waiting for a slow disk. `clear_away` is called first, on another thread than the run's, which
/// goes on meanwhile; then the process exits with status 130. Only one exists at a time; where none does, the run is left
/// to end by itself.
class EndsSoonAfterSignal {
 public:
  explicit EndsSoonAfterSignal(std::function<void()> clear_away);
  ~EndsSoonAfterSignal();
  EndsSoonAfterSignal(const EndsSoonAfterSignal&) = delete;
  EndsSoonAfterSignal& operator=(const EndsSoonAfterSignal&) = delete;
};

}  // namespace gpvc::cli
