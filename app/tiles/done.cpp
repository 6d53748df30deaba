#include "app/tiles/done.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "app/results/output_folder.h"
#include "io/file_bytes.h"
#include "io/output_file.h"
#include "io/paths.h"

namespace gpvc::tiles {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const io::WorkKey& key) { return fmt::format("{:016x}{:016x}", key.bits[0], key.bits[1]); }

std::optional<io::WorkKey> key_member(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) return std::nullopt;
  const std::string& text = found->get_ref<const std::string&>();
  if (text.size() != 32 || text.find_first_not_of("0123456789abcdef") != std::string::npos) return std::nullopt;
  return io::WorkKey{{std::stoull(text.substr(0, 16), nullptr, 16), std::stoull(text.substr(16), nullptr, 16)}};
}

bool stays_inside(const std::string& name) try {
  return results::contained_path(name) == name;
} catch (const OutputError&) {
  return false;
}

std::optional<UnitOutput> output_from(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  const auto file = json.find("file"), bytes = json.find("bytes");
  if (file == json.end() || !file->is_string() || bytes == json.end() || !bytes->is_number_unsigned())
    return std::nullopt;
  const std::optional<io::WorkKey> hash = key_member(json, "hash");
  if (!hash || !stays_inside(file->get<std::string>())) return std::nullopt;
  return UnitOutput{file->get<std::string>(), bytes->get<std::uintmax_t>(), *hash};
}

bool are_figures(const Json& json) {
  return json.is_object() &&
         std::ranges::all_of(json, [](const Json& figure) { return figure.is_number() || figure.is_null(); });
}

std::optional<Done> done_from(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("outputs") || !json["outputs"].is_array()) return std::nullopt;
  const std::optional<io::WorkKey> key = key_member(json, "key");
  if (!key || !json.contains("figures") || !are_figures(json["figures"])) return std::nullopt;
  Done done{*key};
  for (const Json& each : json["outputs"]) {
    const std::optional<UnitOutput> output = output_from(each);
    if (!output) return std::nullopt;
    done.outputs.push_back(*output);
  }
  done.figures = json["figures"];
  return done;
}

io::WorkKey hash_of(std::string_view bytes) {
  io::WorkHash hash;
  hash.add(bytes);
  return hash.key();
}

}  // namespace

UnitOutput output_of(const std::filesystem::path& job, const std::filesystem::path& file) {
  const io::FileBytes bytes(file);
  return {file.lexically_relative(job).string(), bytes.view().size(), hash_of(bytes.view())};
}

std::optional<Done> read_done(const std::filesystem::path& file) {
  if (!io::is_file(file)) return std::nullopt;
  return done_from(io::FileBytes(file).view());
}

void write_done(const std::filesystem::path& file, const Done& done) {
  Json outputs = Json::array();
  for (const UnitOutput& output : done.outputs)
    outputs.push_back(Json{{"file", output.file}, {"bytes", output.bytes}, {"hash", text_of(output.hash)}});
  const Json json{{"key", text_of(done.key)}, {"outputs", outputs}, {"figures", done.figures}};
  io::write_file(file, json.dump(1) + "\n");
}

std::shared_ptr<const Done> DoneList::read() {
  if (!io::is_file(file_)) return nullptr;
  const io::FileBytes bytes(file_);
  const io::WorkKey hash = hash_of(bytes.view());
  const std::lock_guard lock(mutex_);
  if (hash != hash_) {
    std::optional<Done> done = done_from(bytes.view());
    done_ = done ? std::make_shared<const Done>(std::move(*done)) : nullptr;
    hash_ = hash;
  }
  return done_;
}

}  // namespace gpvc::tiles
