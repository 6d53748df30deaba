// Messages to the user while a command runs, and the log file, which gets all of them.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

namespace spdlog {
class logger;
}

namespace gpvc::cli {

enum class Loudness { quiet, normal, verbose };

/// Thread-safe. On a terminal the last line of stderr is a status line that other lines push down.
class Console {
 public:
  /// `log_file` empty: none. Throws OutputError when it cannot be opened.
  Console(Loudness loudness, const std::filesystem::path& log_file);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void result(const std::string& text);   ///< stdout: the command's result
  void note(const std::string& text);     ///< stderr, unless quiet
  void detail(const std::string& text);   ///< stderr when verbose
  void warning(const std::string& text);  ///< stderr, always
  void error(const std::string& text);    ///< stderr, always: "gpvc: error: ..."

  /// Progress of a stage. On a terminal a line that is overwritten; else a plain line every five seconds.
  void status(const std::string& text);
  void clear_status();

 private:
  void say(int level, bool shown, const std::string& text, const char* prefix = "");
  void print(const std::string& text);

  std::mutex mutex_;
  Loudness loudness_;
  bool terminal_ = false, status_shown_ = false;
  std::chrono::steady_clock::time_point last_status_;
  std::shared_ptr<spdlog::logger> log_;
};

}  // namespace gpvc::cli
