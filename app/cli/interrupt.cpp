#include "app/cli/interrupt.h"

#include <atomic>
#include <csignal>

#include "io/error.h"

namespace gpvc::cli {
namespace {

std::atomic<bool> asked_to_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

void on_signal(int) { asked_to_stop = true; }

}  // namespace

void install_signal_handlers() {
  struct sigaction action = {}, inherited = {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);  // the second one has its default effect
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // Signals that nohup, or a shell for its background jobs, has set to be ignored stay ignored.
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  signal(SIGXFSZ, SIG_IGN);
  signal(SIGPIPE, SIG_IGN);
}

void throw_if_interrupted() {
  if (asked_to_stop) throw Cancelled();
}

}  // namespace gpvc::cli
