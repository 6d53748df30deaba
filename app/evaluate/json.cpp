#include "app/evaluate/json.h"

#include "io/output_file.h"

namespace gpvc::evaluate {

void write_text(const std::filesystem::path& file, const std::string& text) {
  io::OutputFile out(file);
  out.write(text);
  out.commit();
}

void write_json(const std::filesystem::path& file, const Json& json) {
  write_text(file, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

void set_figure(Json& figures, const std::string& name, const pipeline::Figure& value) {
  const std::size_t dot = name.find('.');
  if (dot != std::string::npos) return set_figure(figures[name.substr(0, dot)], name.substr(dot + 1), value);
  std::visit([&](const auto& known) { figures[name] = known; }, value);
}

}  // namespace gpvc::evaluate
