// Ctrl-C.
#pragma once

namespace gpvc {

/// From now on the first SIGINT, SIGTERM or SIGHUP asks the run to stop at its next step; a second one kills
/// it. A file size limit (SIGXFSZ) becomes an ordinary write error.
void install_signal_handlers();

bool interrupted();

/// Throws Cancelled once a signal has come.
void throw_if_interrupted();

}  // namespace gpvc
