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

struct OutputSize {
  std::string file;  ///< relative to the job's folder
  std::uintmax_t bytes = 0;
};

struct Done {
  io::WorkKey key;
  std::vector<OutputSize> outputs{};
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();  ///< of the unit
};

/// nullopt where the file is missing or is none.
std::optional<Done> read_done(const std::filesystem::path& file);
/// Throws OutputError.
void write_done(const std::filesystem::path& file, const Done& done);

}  // namespace gpvc::tiles
