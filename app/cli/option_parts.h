// Kinds of options, and options that several commands share.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <iterator>
#include <string>
#include <type_traits>
#include <vector>

#include "app/cli/options.h"
#include "app/evaluate/json.h"
#include "app/pipeline/options.h"
#include "io/names.h"

namespace gpvc::cli {

/// Accepts a number of the type within bounds. Unlike CLI::Range it refuses NaN, says what was expected, and adds nothing
/// to the help.
template <class Value>
CLI::Validator in_range(Value least, Value most) {
  const std::string kind = std::is_integral_v<Value> ? "a whole number" : "a number";
  return CLI::Validator(
      [least, most, kind](std::string& given) {
        Value value{};
        if (CLI::detail::lexical_cast(given, value) && value >= least && value <= most) return std::string();
        return fmt::format("'{}' is not {} from {} to {}", given, kind, least, most);
      },
      "");
}

CLI::Validator not_empty();

/// results::bytes_from_text(). Throws CLI::ValidationError about `option`.
std::size_t bytes_from(const std::string& option, const std::string& given);

/// Adds options of a command under one heading of its help. They write into `value`, which must outlive the parsing.
struct OptionGroup {
  CLI::App& app;
  const char* heading;

  /// `kind`: what the help calls the value, "FILE".
  template <class Value>
  CLI::Option* add(const std::string& name, Value& value, const char* kind, const std::string& text) const {
    return app.add_option(name, value, text)->type_name(kind)->group(heading);
  }
  /// The value it has now is the default, here and in choice().
  template <class Value, class Bound>
  CLI::Option* number(const std::string& name, Value& value, Bound least, Bound most, const char* kind,
                      const std::string& text) const {
    return add(name, value, kind, text)
        ->check(in_range(static_cast<Value>(least), static_cast<Value>(most)))
        ->default_str(fmt::format("{}", value));
  }
  CLI::Option* flag(const std::string& name, bool& value, const std::string& text) const {
    return app.add_flag(name, value, text)->group(heading);
  }
  /// Hands the option's argument to `parse`, which may throw CLI::ValidationError.
  CLI::Option* parsed(const std::string& name, const std::function<void(const std::string&)>& parse,
                      const std::string& kind, const std::string& fallback, const std::string& text) const {
    return app.add_option_function<std::string>(name, parse, text)
        ->type_name(kind)
        ->default_str(fallback)
        ->group(heading);
  }
  /// Takes one of the names in a table and hands its value to `set`, which may throw CLI::ValidationError.
  template <class Value, std::size_t kCount>
  CLI::Option* choice(const std::string& name, const Named<Value> (&names)[kCount],
                      std::type_identity_t<std::function<void(Value)>> set, const Value& fallback,
                      const std::string& text) const {
    std::string words;
    for (const Named<Value>& known : names) words += (words.empty() ? "" : "|") + std::string(known.name);
    const std::vector<Named<Value>> all(std::begin(names), std::end(names));
    const auto parse = [all, words, name, set](const std::string& given) {
      const auto found = std::find_if(all.begin(), all.end(), [&](const Named<Value>& n) { return given == n.name; });
      if (found == all.end()) throw CLI::ValidationError(name, fmt::format("'{}' is none of {}", given, words));
      set(found->value);
    };
    return parsed(name, parse, words, name_of(names, fallback), text);
  }
  template <class Value, std::size_t kCount>
  CLI::Option* choice(const std::string& name, const Named<Value> (&names)[kCount], Value& value,
                      const std::string& text) const {
    return choice(
        name, names, [&value](Value given) { value = given; }, value, text);
  }
};

/// --threads and what else every command has; the footer of the help, which the exit status follows.
void add_common(CLI::App& app, CommonOptions& common, const std::string& footer);
/// SCENE, which every command but evaluate describes.
void add_scene(CLI::App& app, SceneInput& input);
CLI::Option* add_mesh(CLI::App& app, std::filesystem::path& mesh);
void add_masks(CLI::App& app, SceneInput& input);
/// --bands, --composite.
void add_bands(CLI::App& app, SceneInput& input);
/// --skip-bad-photos.
void add_skipping(CLI::App& app, SceneInput& input);
/// --mesh-crs, which means something else by command.
void add_mesh_crs(const OptionGroup& group, SceneInput& input, const std::string& meaning);
/// The photos, the views to use, and the masks.
void add_photos(CLI::App& app, SceneInput& input);
void add_output(CLI::App& app, CommandOptions& options);
/// --visibility, and the options that change a mode's steps.
void add_method(CLI::App& app, visibility::Method& method);
/// The same in run.json.
evaluate::Json method_json(const visibility::Method& method);
/// Options of earlier versions, which work with a note and are not in the help.
void add_earlier_names(CLI::App& app, pipeline::Settings& settings, CommonOptions& common);
/// --allow, and what its file holds.
void add_rules(CLI::App& app, std::filesystem::path& allow);
extern const char* const kRulesHelp;

}  // namespace gpvc::cli
