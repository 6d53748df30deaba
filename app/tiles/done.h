// What is written once a unit is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/work_store.h"

namespace gpvc::tiles {

struct UnitOutput {
  std::string file;  ///< relative to the job's folder, and inside it
  std::uintmax_t bytes = 0;
  io::WorkKey hash{};  ///< of the bytes
  bool operator==(const UnitOutput&) const = default;
};
/// A file of the job as it is now. Throws InputError. O(bytes of the file).
UnitOutput output_of(const std::filesystem::path& job, const std::filesystem::path& file);

struct Done {
  io::WorkKey key;
  std::vector<UnitOutput> outputs{};
  nlohmann::ordered_json figures =
      nlohmann::ordered_json::object();  ///< of the unit: numbers, or null where there is none
};

/// nullopt where the file is missing or anything in it is not as write_done() writes it.
std::optional<Done> read_done(const std::filesystem::path& file);
/// Throws OutputError.
void write_done(const std::filesystem::path& file, const Done& done);

/// The file of a list that is looked up again and again, with thousands of outputs. Each look reads the bytes, so that
/// no change is missed, and parses them only where they have changed: parsing takes longer than reading an output does.
/// Thread-safe.
class DoneList {
 public:
  explicit DoneList(std::filesystem::path file) : file_(std::move(file)) {}
  /// What read_done() gives, null for nullopt.
  std::shared_ptr<const Done> read();

 private:
  std::filesystem::path file_;
  std::mutex mutex_;
  std::optional<io::WorkKey> hash_;   ///< of the bytes that were parsed last
  std::shared_ptr<const Done> done_;  ///< what they say
};

}  // namespace gpvc::tiles
