// A JSON file with places for error messages, on nlohmann/json.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"

namespace gpvc::io {

using Json = nlohmann::json;

/// How a file writes its numbers; quoted: as texts, too.
enum class JsonNumbers { plain, quoted };

class JsonFile {
 public:
  /// Members that `omit` names by their depth (1: of the root) and key are not kept: points outweigh cameras a
  /// thousandfold. Throws InputError where the text is not well-formed. Borrowed: `file`, which is only named.
  JsonFile(const std::filesystem::path& file, std::string_view text,
           const std::function<bool(int depth, const std::string& key)>& omit = {},
           JsonNumbers numbers = JsonNumbers::plain);

  const Json& root() const { return root_; }
  const std::filesystem::path& path() const { return file_; }
  [[noreturn]] void fail(const std::string& place, const std::string& reason) const {
    throw InputError(file_, place, reason);
  }

  // Members of an object. They throw InputError at `place` where the member is of another type or, unless it is
  // optional, missing.
  double number(const std::string& place, const Json& object, const char* key) const;
  double optional_number(const std::string& place, const Json& object, const char* key, double otherwise = 0) const;
  std::string text(const std::string& place, const Json& object, const char* key) const;
  /// A whole number of 1 to 2^24.
  int side(const std::string& place, const Json& object, const char* key) const;
  /// A list of `count` numbers; with `rows` above 0, of `rows` such lists, which follow each other in the result.
  std::vector<double> numbers(const std::string& place, const Json& object, const char* key, std::size_t count,
                              std::size_t rows = 0) const;
  const Json& object(const std::string& place, const Json& object, const char* key) const;
  /// A list of objects.
  const Json& objects(const std::string& place, const Json& object, const char* key) const;

 private:
  const Json& member(const std::string& place, const Json& object, const char* key) const;
  std::optional<double> number_in(const Json& value) const;

  const std::filesystem::path& file_;
  JsonNumbers numbers_;
  Json root_;
};

/// The keys of the object that a file named .json or .sfm holds, as far as its first bytes show them; empty for other files.
std::set<std::string> json_root_keys(const std::filesystem::path& file);

}  // namespace gpvc::io
