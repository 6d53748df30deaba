// What is written once a unit is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
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

}  // namespace gpvc::tiles
