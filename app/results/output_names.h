// Names of output files in run.json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace gpvc::results {

/// The names as JSON; for one that is not UTF-8 {"name", "bytes"}, with `bytes` in hexadecimal digits.
nlohmann::ordered_json outputs_json(const std::vector<std::string>& names);

/// Back from JSON. Leaves out what is no name, and names that lead out of the folder.
std::vector<std::string> output_names(const nlohmann::ordered_json& list);

}  // namespace gpvc::results
