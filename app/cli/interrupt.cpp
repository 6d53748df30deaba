#include "app/cli/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <mutex>
#include <string_view>
#include <thread>

#include "app/cli/app.h"
#include "io/error.h"

namespace gpvc::cli {
namespace {

std::atomic<bool> asked_to_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

int wake_up[2] = {-1, -1};  ///< a pipe, from the handler to the thread
constexpr auto kPatience = std::chrono::milliseconds(500);

std::mutex clearing;
std::function<void()> clear_away_now;  ///< guarded by `clearing`; empty: leave the run alone

void on_signal(int) {
  const int error = errno;
  asked_to_stop = true;
  static_cast<void>(write(wake_up[1], "", 1) > 0);
  errno = error;
}

// A mapped file has fewer pages than it had: nothing can be computed from here on, and only write() is safe.
void on_lost_page(int) {
  constexpr std::string_view kSentence =
      "gpvc: error: a file became shorter while it was read, or its disk is gone; nothing was written under a final "
      "name\n";
  static_cast<void>(write(STDERR_FILENO, kSentence.data(), kSentence.size()) > 0);
  _exit(kFailed);
}

void end_overdue_run() {
  char byte = 0;
  while (read(wake_up[0], &byte, 1) < 0 && errno == EINTR) continue;
  std::this_thread::sleep_for(kPatience);
  const std::lock_guard lock(clearing);
  if (!clear_away_now) return;
  clear_away_now();
  _exit(kInterrupted);
}

}  // namespace

void install_signal_handlers() {
  if (pipe2(wake_up, O_CLOEXEC) == 0) std::thread(end_overdue_run).detach();
  struct sigaction action = {}, inherited = {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);  // the second one has its default effect
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // Signals that nohup, or a shell for its background jobs, has set to be ignored stay ignored.
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  action.sa_handler = on_lost_page;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGBUS, &action, nullptr);
  signal(SIGXFSZ, SIG_IGN);
  signal(SIGPIPE, SIG_IGN);
}

void throw_if_interrupted() {
  if (asked_to_stop) throw Cancelled();
}

EndsSoonAfterSignal::EndsSoonAfterSignal(std::function<void()> clear_away) {
  const std::lock_guard lock(clearing);
  clear_away_now = std::move(clear_away);
}

EndsSoonAfterSignal::~EndsSoonAfterSignal() {
  const std::lock_guard lock(clearing);
  clear_away_now = nullptr;
}

}  // namespace gpvc::cli
