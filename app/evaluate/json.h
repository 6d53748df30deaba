// JSON as reports and records are written.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "app/pipeline/observer.h"

namespace gpvc::evaluate {

using Json = nlohmann::ordered_json;

/// Throws OutputError.
void write_text(const std::filesystem::path& file, const std::string& text);
/// Indented by one space; bytes that are not UTF-8 are replaced. Throws OutputError.
void write_json(const std::filesystem::path& file, const Json& json);

/// Adds a figure to an object; a dot in the name leads into a nested object.
void set_figure(Json& figures, const std::string& name, const pipeline::Figure& value);

}  // namespace gpvc::evaluate
