// Ctrl-C.
#pragma once

namespace gpvc::cli {

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the run to stop at its next step; a second one kills it. Those
/// that whoever started the program has it ignore (nohup: SIGHUP) stay ignored. A file size limit (SIGXFSZ) and a
/// reader that is gone (SIGPIPE) become ordinary write errors.
void install_signal_handlers();

bool interrupted();

/// Throws Cancelled once a signal has come.
void throw_if_interrupted();

}  // namespace gpvc::cli
