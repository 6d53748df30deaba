// JSON as reports and records are written. A source that looks into it includes <nlohmann/json.hpp>.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace gpvc::evaluate {

using Json = nlohmann::ordered_json;

/// Indented by one space; bytes that are not UTF-8 are replaced.
std::string json_text(const Json& json);
/// Throws OutputError.
void write_json(const std::filesystem::path& file, const Json& json);

}  // namespace gpvc::evaluate
