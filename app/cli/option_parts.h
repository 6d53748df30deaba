// Kinds of options and the groups of them that several commands share.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <iterator>
#include <string>
#include <type_traits>
#include <vector>

#include "app/cli/options.h"
#include "io/names.h"

namespace gpvc::cli {

template <class Value>
using Choice = Named<Value>;

// A number of the type within bounds. Unlike CLI::Range it refuses NaN, says what it wanted, and keeps out of the help.
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

// An option that takes one of a few words.
template <class Value, std::size_t kCount>
CLI::Option* add_choice(CLI::App& app, const std::string& name, const Choice<Value> (&choices)[kCount],
                        std::function<void(Value)> set, const std::string& fallback, const std::string& text) {
  std::string words;
  for (const auto& choice : choices) words += (words.empty() ? "" : "|") + std::string(choice.name);
  const std::vector<Choice<Value>> known(std::begin(choices), std::end(choices));
  const auto parse = [known, set, words, name](const std::string& given) {
    for (const auto& choice : known)
      if (given == choice.name) return set(choice.value);
    throw CLI::ValidationError(name, fmt::format("'{}' is none of {}", given, words));
  };
  return app.add_option_function<std::string>(name, parse, text)->type_name(words)->default_str(fallback);
}

CLI::Validator not_empty();

// Each adds its options to `app` and lets them fill what is given, which must outlive the parsing.
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
