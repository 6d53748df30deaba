#include "app/evaluate/json.h"

#include <nlohmann/json.hpp>

#include "io/output_file.h"

namespace gpvc::evaluate {

std::string json_text(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

void write_json(const std::filesystem::path& file, const Json& json) { io::write_file(file, json_text(json)); }

}  // namespace gpvc::evaluate
