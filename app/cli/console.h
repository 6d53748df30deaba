// Messages to the user while a command runs, and the log file, which gets all of them.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <system_error>

#include "io/error.h"

namespace spdlog {
class logger;
}

namespace gpvc::cli {

enum class Loudness { quiet, normal, verbose };

/// Thread-safe. Shows printable() text alone, and logs no other. On a terminal the last line of stderr is a status line that other lines push down, unless TERM says that it
/// is dumb.
class Console {
 public:
  /// `log_file` empty: none. Throws OutputError when it cannot be opened.
  Console(Loudness loudness, const std::filesystem::path& log_file);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void result(const std::string& text);  ///< stdout: the command's result
  void note(const std::string& text);    ///< stderr, unless quiet
  void detail(const std::string& text);  ///< stderr when verbose
  /// stderr, always, with what can be done about it: "gpvc: warning: ..."
  void warning(const std::string& text, std::span<const Cure> cures = {});
  void error(const std::string& text, std::span<const Cure> cures = {});
  /// From now on cures speak of the options that the job of this run was made with, see with_cures().
  void speak_of_job() { of_job_ = true; }
  void interrupted() {
    std::error_code ignored;
    error("interrupted; " + (std::filesystem::exists(kept_in_, ignored) ? kept_ : "nothing was written"));
  }
  /// What an interrupted command leaves behind if `folder` is there by then. Before the command starts.
  void note_kept(const std::filesystem::path& folder, const std::string& what) {
    kept_in_ = folder;
    kept_ = what;
  }

  /// True if standard output could not be written completely (a full disk behind a redirection). That a pipe's reader has
  /// ended (`| head`) is no loss: it has what it wanted.
  bool results_were_lost();

  /// Progress of a stage. On a terminal a line that is overwritten; else a plain line every five seconds.
  void status(const std::string& text);
  void clear_status();

 private:
  void say(int level, bool shown, const std::string& text, const char* prefix = "");
  void print(const std::string& text);

  std::mutex mutex_;
  Loudness loudness_;
  bool terminal_ = false, status_shown_ = false;
  bool of_job_ = false;
  bool lost_ = false, reader_ended_ = false;
  std::chrono::steady_clock::time_point last_status_;
  std::filesystem::path kept_in_;
  std::string kept_;
  std::shared_ptr<spdlog::logger> log_;
};

}  // namespace gpvc::cli
