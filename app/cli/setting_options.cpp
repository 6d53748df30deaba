#include "app/cli/setting_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>

#include "app/cli/command_options.h"
#include "io/images.h"

namespace gpvc::cli {
namespace {

using evaluate::Json;
using pipeline::OptionInfo;

using pipeline::IsNamed;
using pipeline::names_of;

using Color = std::array<std::uint8_t, 3>;
using ortho::Bounds;
using tileset::Place;

std::optional<Place> place_from(const std::string& option, const std::string& given) {
  Place place;
  char rest = 0;
  const int read = std::sscanf(given.c_str(), "%lf,%lf,%lf%c%lf%c", &place.latitude, &place.longitude, &place.height,
                               &rest, &place.heading, &rest);
  const bool is_place = (read == 3 || (read == 5 && rest == ',')) && std::abs(place.latitude) <= 90 &&
                        std::abs(place.longitude) <= 360 && std::abs(place.height) < 1e7 &&
                        std::abs(place.heading) <= 360;
  if (!is_place)
    throw CLI::ValidationError(
        option, fmt::format("'{}' is not LAT,LON,HEIGHT or LAT,LON,HEIGHT,HEADING in degrees and metres", given));
  return place;
}

std::optional<Bounds> bounds_from(const std::string& option, const std::string& given) {
  Bounds b;
  char rest = 0;
  const int read = std::sscanf(given.c_str(), "%lf,%lf,%lf,%lf%c", &b.west, &b.south, &b.east, &b.north, &rest);
  const bool is_box = read == 4 && b.west < b.east && b.south < b.north && std::abs(b.west) < 1e12 &&
                      std::abs(b.south) < 1e12 && std::abs(b.east) < 1e12 && std::abs(b.north) < 1e12;
  if (!is_box)
    throw CLI::ValidationError(
        option,
        fmt::format("'{}' is not WEST,SOUTH,EAST,NORTH, four numbers with west below east and south below north",
                    given));
  return b;
}

// --- options

// Adds an option of each kind of value.
struct Adder {
  CLI::App& app;

  void operator()(visibility::Method& method, const OptionInfo&) const { add_method(app, method); }
  void operator()(std::vector<pipeline::ViewRule>&, const OptionInfo&) const {}  // read from a file
  void operator()(bool& value, const OptionInfo& info) const {
    app.add_flag((value ? "!--no-" : "--") + std::string(info.name), value, info.help)->group(info.group);
  }
  void operator()(Color& color, const OptionInfo& info) const {
    const auto take = [&color](const std::vector<int>& channels) {
      for (std::size_t c = 0; c < 3; ++c) color[c] = static_cast<std::uint8_t>(channels[c]);
    };
    app.add_option_function<std::vector<int>>(flag(info), take, info.help)
        ->type_name(info.kind)
        ->delimiter(',')
        ->expected(3)
        ->check(in_range(static_cast<int>(info.least), static_cast<int>(info.most)))
        ->default_str(fmt::format("{},{},{}", color[0], color[1], color[2]))
        ->group(info.group);
  }
  void operator()(std::string& text, const OptionInfo& info) const {
    const char* kind = *info.kind == '\0' ? "TEXT" : info.kind;
    OptionGroup{app, info.group}.add(flag(info), text, kind, info.help)->check(not_empty());
  }
  void operator()(std::optional<Bounds>& bounds, const OptionInfo& info) const {
    OptionGroup{app, info.group}.parsed(
        flag(info), [&bounds, name = flag(info)](const std::string& given) { bounds = bounds_from(name, given); },
        "W,S,E,N", "", info.help);
  }
  void operator()(std::optional<Place>& place, const OptionInfo& info) const {
    OptionGroup{app, info.group}.parsed(
        flag(info), [&place, name = flag(info)](const std::string& given) { place = place_from(name, given); },
        "LAT,LON,HEIGHT[,HEADING]", "", info.help);
  }
  template <typename Value>
  void operator()(Value& value, const OptionInfo& info) const {
    const OptionGroup group{app, info.group};
    if constexpr (IsNamed<Value>) {
      CLI::Option* option = group.choice(flag(info), names_of(value), value, info.help);
      if constexpr (std::same_as<Value, pipeline::KeepWork>) add_never(value, info, option);
    } else if constexpr (std::is_arithmetic_v<Value>) {
      if (info.is_amount()) return add_bytes(value, info);
      CLI::Option* option = group.number(flag(info), value, info.least, info.most, info.kind, info.help);
      if (static_cast<double>(value) < info.least) option->default_str("");  // no limit
    }
  }

 private:
  static std::string flag(const OptionInfo& info) { return "--" + std::string(info.name); }
  template <typename Value>
  void add_bytes(Value& value, const OptionInfo& info) const {
    OptionGroup{app, info.group}.parsed(
        flag(info),
        [&value, name = flag(info)](const std::string& given) { value = static_cast<Value>(bytes_from(name, given)); },
        info.kind, info.unset, info.help);
  }
  void add_never(pipeline::KeepWork& value, const OptionInfo& info, CLI::Option* option) const {
    app.add_flag_callback(
           "--no-" + std::string(info.name), [&value] { value = pipeline::KeepWork::never; },
           "Keep no work, and use none that is kept: --resume never")
        ->group(info.group)
        ->excludes(option);
  }
};

// --- JSON

void put_json(Json& json, const visibility::Method& method, const OptionInfo&) { json.update(method_json(method)); }
void put_json(Json&, const std::vector<pipeline::ViewRule>&, const OptionInfo&) {}
void put_json(Json& json, const std::optional<Place>& place, const OptionInfo& info) {
  json[info.name] = place ? Json{place->latitude, place->longitude, place->height, place->heading} : Json();
}
void put_json(Json& json, const std::optional<Bounds>& b, const OptionInfo& info) {
  json[info.name] = b ? Json{b->west, b->south, b->east, b->north} : Json();
}
template <typename Value>
void put_json(Json& json, const Value& value, const OptionInfo& info) {
  std::string name = info.name;
  std::ranges::replace(name, '-', '_');
  if constexpr (IsNamed<Value>)
    json[name] = name_of(names_of(value), value);
  else
    json[name] = value;
}

template <typename T>
Json json_of(const T& settings, const OptionFilter& wanted) {
  Json json = Json::object();
  pipeline::for_each_option(settings, [&](const auto& value, const OptionInfo& info) {
    if (wanted(info)) put_json(json, value, info);
  });
  return json;
}

template <typename T>
void add_all(CLI::App& app, T& settings, const OptionFilter& wanted) {
  const Adder add{app};
  pipeline::for_each_option(settings, [&](auto& value, const OptionInfo& info) {
    if (info.group != nullptr && wanted(info)) add(value, info);
  });
}

bool any_option(const OptionInfo&) { return true; }

}  // namespace

void add_settings(CLI::App& app, pipeline::Settings& settings, const OptionFilter& wanted) {
  add_all(app, settings, wanted);
}
void add_settings(CLI::App& app, tiles::JobSettings& settings, const OptionFilter& wanted) {
  add_all(app, settings, wanted);
}
void add_settings(CLI::App& app, tileset::TilesetSettings& settings) { add_all(app, settings, any_option); }
void add_settings(CLI::App& app, ortho::OrthoSettings& settings) { add_all(app, settings, any_option); }
void add_settings(CLI::App& app, visibility::VisibilityOptions& settings) { add_all(app, settings, any_option); }

OptionFilter options_for(pipeline::For result) {
  return [result](const OptionInfo& info) { return info.result <= result; };
}

void refuse_contradictions(const pipeline::Settings& settings) {
  const pipeline::OutputSettings& output = settings.output;
  if (output.target == pipeline::Target::full && output.max_bytes > 0)
    throw UsageError("--max-bytes belongs to --target web");
  if (output.target == pipeline::Target::web && settings.atlas.page_size > io::kMostWebpEdge)
    throw UsageError(fmt::format("--target web: a WebP has at most {} texels an edge, and --page-size {} is more",
                                 io::kMostWebpEdge, settings.atlas.page_size));
}

Json settings_json(const pipeline::Settings& settings, const OptionFilter& wanted) { return json_of(settings, wanted); }
Json settings_json(const tiles::JobSettings& settings, const OptionFilter& wanted) { return json_of(settings, wanted); }
Json settings_json(const tileset::TilesetSettings& settings) { return json_of(settings, any_option); }
Json settings_json(const ortho::OrthoSettings& settings) { return json_of(settings, any_option); }
Json settings_json(const visibility::VisibilityOptions& settings) { return json_of(settings, any_option); }

}  // namespace gpvc::cli
