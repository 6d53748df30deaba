#include "app/tiles/done.h"

#include <fmt/format.h>

#include "io/file_bytes.h"
#include "io/output_file.h"
#include "io/paths.h"

namespace gpvc::tiles {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const io::WorkKey& key) { return fmt::format("{:016x}{:016x}", key.bits[0], key.bits[1]); }

std::optional<io::WorkKey> key_from(const std::string& text) {
  if (text.size() != 32 || text.find_first_not_of("0123456789abcdef") != std::string::npos) return std::nullopt;
  return io::WorkKey{{std::stoull(text.substr(0, 16), nullptr, 16), std::stoull(text.substr(16), nullptr, 16)}};
}

}  // namespace

std::optional<Done> read_done(const std::filesystem::path& file) {
  if (!io::is_file(file)) return std::nullopt;
  const io::FileBytes bytes(file);
  const Json json = Json::parse(bytes.view(), nullptr, false);
  if (!json.is_object()) return std::nullopt;
  const std::optional<io::WorkKey> key = key_from(json.value("key", ""));
  if (!key || !json.contains("outputs") || !json["outputs"].is_array()) return std::nullopt;
  Done done{*key};
  for (const Json& output : json["outputs"])
    done.outputs.push_back({output.value("file", ""), output.value("bytes", std::uintmax_t{0})});
  done.figures = json.value("figures", Json::object());
  return done;
}

void write_done(const std::filesystem::path& file, const Done& done) {
  Json outputs = Json::array();
  for (const OutputSize& output : done.outputs) outputs.push_back({{"file", output.file}, {"bytes", output.bytes}});
  io::OutputFile out(file);
  out.write(Json{{"key", text_of(done.key)}, {"outputs", outputs}, {"figures", done.figures}}.dump(1) + "\n");
  out.commit();
}

}  // namespace gpvc::tiles
