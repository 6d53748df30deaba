#include "app/compare/compare_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace gpvc::compare {
namespace {

std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream rest(list);
  for (std::string word; std::getline(rest, word, ',');) {
    word.erase(0, word.find_first_not_of(' '));
    word.erase(word.find_last_not_of(' ') + 1);
    if (!word.empty()) words.push_back(word);
  }
  return words;
}

bool takes_epsilon(const std::string& word) {
  return word == "shadow-map:spc" || word == "shadow-map:apc" || word == "ray:sparse" || word == "ray:dense";
}

visibility::Method method_of(const std::string& word) {
  using visibility::PaperGpvc, visibility::Projection, visibility::CoverageCorrection;
  if (word == "gpvc:uncorrected") return PaperGpvc{.correction = CoverageCorrection::off};
  if (word == "gpvc:uncorrected:spc")
    return PaperGpvc{.projection = Projection::spc, .correction = CoverageCorrection::off};
  if (word == "gpvc:paper") return PaperGpvc{.correction = CoverageCorrection::paper};
  return visibility::parse_visibility_mode(word);
}

ComparedMode one_mode(const std::string& word) {
  ComparedMode mode;
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

std::vector<ComparedMode> compared_modes(const std::string& list, const EpsilonsOf& epsilons) {
  std::vector<ComparedMode> modes;
  const auto add = [&](const std::string& word) {
    ComparedMode mode = one_mode(word);
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
  if (modes.empty()) throw std::invalid_argument("the list names no mode");
  return modes;
}

}  // namespace gpvc::compare
