#include "app/cli/console.h"

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "app/cli/cures.h"
#include "app/results/observer.h"
#include "io/utf8.h"

namespace gpvc::cli {
namespace {

constexpr auto kTerminalPeriod = std::chrono::milliseconds(100);
constexpr auto kPlainPeriod = std::chrono::seconds(5);

std::size_t terminal_columns() {
  winsize size = {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1) return size.ws_col;
  return 80;
}

// A log may replace an earlier log but no other file: a user may well give the mesh to --log by mistake.
void refuse_other_files(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!std::filesystem::is_directory(folder)) throw OutputError(file, "its folder does not exist");
  if (!std::filesystem::is_regular_file(file) || std::filesystem::file_size(file) == 0) return;
  std::string begin(11, ' ');  // 2026-01-31T
  std::ifstream(file).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  for (std::size_t i = 0; i < begin.size(); ++i) {
    const char wanted = i == 4 || i == 7 ? '-' : i == 10 ? 'T' : '0';
    if (wanted == '0' ? std::isdigit(static_cast<unsigned char>(begin[i])) == 0 : begin[i] != wanted)
      throw OutputError(file, "exists and is no earlier log; it is not replaced by one");
  }
}

std::shared_ptr<spdlog::logger> open_log(const std::filesystem::path& file) {
  if (file.empty()) return nullptr;
  refuse_other_files(file);
  try {
    auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file.string(), true);
    auto log = std::make_shared<spdlog::logger>("gpvc", sink);
    log->set_level(spdlog::level::trace);
    log->flush_on(spdlog::level::trace);
    log->set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
    // A run goes on without its log when the disk is full, but says so once.
    log->set_error_handler([warned = false](const std::string& reason) mutable {
      if (!warned) std::fprintf(stderr, "gpvc: warning: the log is incomplete: %s\n", reason.c_str());
      warned = true;
    });
    return log;
  } catch (const spdlog::spdlog_ex&) {
    throw OutputError(file, "cannot be opened for writing as the log");
  }
}

// A dumb terminal understands no escape sequences.
bool has_cursor(int descriptor) {
  const char* kind = std::getenv("TERM");
  return isatty(descriptor) != 0 && kind != nullptr && std::string_view(kind) != "dumb" && *kind != '\0';
}

}  // namespace

Console::Console(Loudness loudness, const std::filesystem::path& log_file)
    : loudness_(loudness), terminal_(has_cursor(STDERR_FILENO)), log_(open_log(log_file)) {}

Console::~Console() { clear_status(); }

void Console::result(const std::string& text) {
  const std::lock_guard lock(mutex_);
  const std::string shown = results::printable(text);
  if (status_shown_) print("");
  if (log_) log_->info("{}", shown);
  const bool good = std::fputs((shown + "\n").c_str(), stdout) >= 0 && std::fflush(stdout) == 0;
  if (good || lost_) return;
  lost_ = true;
  reader_ended_ = errno == EPIPE;
}

bool Console::results_were_lost() {
  const std::lock_guard lock(mutex_);
  return lost_ && !reader_ended_;
}

void Console::note(const std::string& text) { say(spdlog::level::info, loudness_ != Loudness::quiet, text); }
void Console::detail(const std::string& text) { say(spdlog::level::debug, loudness_ == Loudness::verbose, text); }
void Console::warning(const std::string& text, std::span<const Cure> cures) {
  say(spdlog::level::warn, true, with_cures(text, cures, of_job_), "gpvc: warning: ");
}
void Console::error(const std::string& text, std::span<const Cure> cures) {
  say(spdlog::level::err, true, with_cures(text, cures, of_job_), "gpvc: error: ");
}

// `level`: of spdlog, whose headers stay out of ours.
void Console::say(int level, bool shown, const std::string& text, const char* prefix) {
  const std::lock_guard lock(mutex_);
  if (log_) log_->log(static_cast<spdlog::level::level_enum>(level), "{}", results::printable(text));
  if (shown) print(prefix + text + "\n");
}

void Console::status(const std::string& text) {
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (now - last_status_ < (terminal_ ? std::chrono::nanoseconds(kTerminalPeriod) : kPlainPeriod)) return;
  last_status_ = now;
  if (log_) log_->trace("{}", results::printable(text));
  if (loudness_ == Loudness::quiet) return;
  if (!terminal_) {
    print(text + "\n");
    return;
  }
  const std::string shown = results::printable(text);
  std::fputs(fmt::format("\r\x1b[K{}", io::whole_characters(shown, terminal_columns() - 1)).c_str(), stderr);
  std::fflush(stderr);
  status_shown_ = true;
}

void Console::clear_status() {
  const std::lock_guard lock(mutex_);
  if (status_shown_) print("");
  // The first plain line of the next stage waits for the period to pass, so that short stages print only their summary.
  last_status_ = terminal_ ? std::chrono::steady_clock::time_point{} : std::chrono::steady_clock::now();
}

void Console::print(const std::string& text) {
  if (status_shown_) std::fputs("\r\x1b[K", stderr);
  status_shown_ = false;
  std::fputs(results::printable(text).c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace gpvc::cli
