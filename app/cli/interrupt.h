// How Ctrl-C and other signals stop a run.
#pragma once

namespace gpvc::cli {

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the run to stop at its next step; a second one kills it. Signals
/// that the program was started with as ignored (nohup: SIGHUP) stay ignored. A file size limit (SIGXFSZ) and a closed
/// pipe (SIGPIPE) become ordinary write errors.
void install_signal_handlers();

/// Throws Cancelled once a signal has come.
void throw_if_interrupted();

}  // namespace gpvc::cli
