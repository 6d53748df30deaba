// Errors that carry their context: which file, where in it, what was expected.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace gpvc {

/// Input that cannot be used. what() is one sentence: "FILE: PLACE: REASON" (PLACE may be empty).
class InputError : public std::runtime_error {
 public:
  /// `place` is "line 12", "byte 340", "face 7" or empty; `reason` says what was expected and what was found.
  InputError(const std::filesystem::path& file, const std::string& place, const std::string& reason)
      : std::runtime_error(file.string() + ": " + (place.empty() ? "" : place + ": ") + reason) {}
};

/// A promised file that cannot be written (no permission, disk full). what() is "FILE: REASON".
class OutputError : public std::runtime_error {
 public:
  OutputError(const std::filesystem::path& file, const std::string& reason)
      : std::runtime_error(file.string() + ": " + reason) {}
};

/// The user asked to stop (Ctrl-C); unwinds to main, which exits with 130.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace gpvc
