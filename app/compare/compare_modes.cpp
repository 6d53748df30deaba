#include "app/compare/compare_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "app/cli/options.h"

namespace gpvc::compare {
namespace {

std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t end = std::min(list.find(',', at), list.size());
    std::string word = list.substr(at, end - at);
    word.erase(0, word.find_first_not_of(' '));
    word.erase(word.find_last_not_of(' ') + 1);
    if (!word.empty()) words.push_back(word);
    at = end + 1;
  }
  return words;
}

bool takes_epsilon(const std::string& word) {
  constexpr const char* kBiased[] = {"shadow-map:spc", "shadow-map:apc", "ray:sparse", "ray:dense"};
  return std::find(std::begin(kBiased), std::end(kBiased), word) != std::end(kBiased);
}

visibility::Method method_of(const std::string& word) {
  using visibility::PaperGpvc, visibility::Projection, visibility::CoverageCorrection;
  if (word == "gpvc:uncorrected") return PaperGpvc{.correction = CoverageCorrection::off};
  if (word == "gpvc:uncorrected:spc")
    return PaperGpvc{.projection = Projection::spc, .correction = CoverageCorrection::off};
  if (word == "gpvc:paper") return PaperGpvc{.correction = CoverageCorrection::paper};
  try {
    return visibility::parse_visibility_mode(word);
  } catch (const std::invalid_argument& error) {
    throw cli::UsageError(fmt::format("--modes: {}", error.what()));
  }
}

ComparedMode one_mode(const std::string& word, const visibility::VisibilityOptions& base) {
  ComparedMode mode;
  mode.visibility = base;
  mode.visibility.method = method_of(word);
  const visibility::Method& method = mode.visibility.method;
  mode.name = std::holds_alternative<visibility::PaperGpvc>(method) ? word : visibility::visibility_mode_name(method);
  mode.family = mode.name;
  if (const auto* shadow_map = std::get_if<visibility::ShadowMap>(&method)) mode.epsilon = shadow_map->epsilon;
  if (const auto* rays = std::get_if<visibility::RayTracing>(&method)) mode.epsilon = rays->epsilon;
  if (mode.epsilon) mode.family = mode.name.substr(0, mode.name.rfind(':'));
  return mode;
}

}  // namespace

const std::string& default_modes() {
  static const std::string modes =
      "none,shadow-map:spc,shadow-map:apc,ray:sparse,ray:dense,gpvc:uncorrected,gpvc,gpvc:ves";
  return modes;
}

std::vector<ComparedMode> compared_modes(const std::string& list, const EpsilonsOf& epsilons,
                                         const visibility::VisibilityOptions& base) {
  std::vector<ComparedMode> modes;
  const auto add = [&](const std::string& word) {
    ComparedMode mode = one_mode(word, base);
    const auto same = [&](const ComparedMode& other) { return other.name == mode.name; };
    if (std::none_of(modes.begin(), modes.end(), same)) modes.push_back(std::move(mode));
  };
  for (const std::string& word : words_of(list)) {
    if (!takes_epsilon(word)) {
      add(word);
      continue;
    }
    for (const double epsilon : epsilons(word)) add(fmt::format("{}:{}", word, epsilon));
  }
  if (modes.empty()) throw cli::UsageError("--modes names no mode");
  return modes;
}

}  // namespace gpvc::compare
