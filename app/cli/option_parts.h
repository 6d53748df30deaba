// Kinds of options, and groups of options that several commands share.
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
#include "io/names.h"

namespace gpvc::cli {

// Accepts a number of the type within bounds. Unlike CLI::Range it refuses NaN, says what was expected, and adds nothing
// to the help.
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

// An option that takes one of the names in a table and hands its value to `set`, which may throw.
template <class Value, std::size_t kCount>
CLI::Option* add_choice(CLI::App& app, const std::string& name, const Named<Value> (&names)[kCount],
                        std::type_identity_t<std::function<void(Value)>> set, const std::string& fallback,
                        const std::string& text) {
  std::string words;
  for (const Named<Value>& known : names) words += (words.empty() ? "" : "|") + std::string(known.name);
  const std::vector<Named<Value>> all(std::begin(names), std::end(names));
  const auto parse = [all, words, name, set](const std::string& given) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Named<Value>& n) { return given == n.name; });
    if (found == all.end()) throw CLI::ValidationError(name, fmt::format("'{}' is none of {}", given, words));
    set(found->value);
  };
  return app.add_option_function<std::string>(name, parse, text)->type_name(words)->default_str(fallback);
}

// Sets `value`, whose present value is the default.
template <class Value, std::size_t kCount>
CLI::Option* add_choice(CLI::App& app, const std::string& name, const Named<Value> (&names)[kCount], Value& value,
                        const std::string& text) {
  return add_choice(
      app, name, names, [&value](Value given) { value = given; }, name_of(names, value), text);
}

CLI::Validator not_empty();

// Each function adds options to `app`. They write into the given struct, which must outlive the parsing.
void add_common(CLI::App& app, CommonOptions& common);
CLI::Option* add_mesh(CLI::App& app, std::filesystem::path& mesh);
void add_scene(CLI::App& app, SceneInput& input);
void add_masks(CLI::App& app, SceneInput& input);
void add_photos(CLI::App& app, SceneInput& input);
/// Scene, mesh and photos.
void add_scene_input(CLI::App& app, SceneInput& input);
void add_output(CLI::App& app, std::filesystem::path& out, bool& force);
void add_visibility(CLI::App& app, visibility::VisibilityOptions& options);
void add_edge_weights(CLI::App& app, labeling::EdgeWeights& weights);

}  // namespace gpvc::cli
