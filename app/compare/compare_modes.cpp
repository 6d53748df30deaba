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

ComparedMode one_mode(const std::string& word, const visibility::VisibilityOptions& base) {
  ComparedMode mode;
  mode.visibility = base;
  std::string known = word;
  if (word == "gpvc:uncorrected" || word == "gpvc:uncorrected:spc" || word == "gpvc:paper") {
    known = "gpvc";
    if (word.ends_with(":spc")) mode.visibility.projection = visibility::Projection::spc;
    mode.visibility.correction =
        word == "gpvc:paper" ? visibility::CoverageCorrection::paper : visibility::CoverageCorrection::off;
  }
  try {
    visibility::set_visibility_mode(known, mode.visibility);
  } catch (const std::invalid_argument& error) {
    throw cli::UsageError(fmt::format("--modes: {}", error.what()));
  }
  mode.name = known == word ? visibility::visibility_mode_name(mode.visibility) : word;
  mode.family = mode.name;
  const visibility::Method method = mode.visibility.method;
  if (method == visibility::Method::shadow_map || method == visibility::Method::ray) {
    mode.epsilon = mode.visibility.epsilon;
    mode.family = mode.name.substr(0, mode.name.rfind(':'));
  }
  return mode;
}

}  // namespace

const std::string& default_modes() {
  static const std::string modes =
      "none,shadow-map:spc,shadow-map:apc,ray:sparse,ray:dense,gpvc:uncorrected,gpvc,gpvc:ves";
  return modes;
}

std::vector<double> default_epsilons() { return {1e-5, 1e-4, 1e-3, 1e-2}; }

std::vector<ComparedMode> compared_modes(const std::string& list, std::span<const double> epsilons,
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
    for (const double epsilon : epsilons) add(fmt::format("{}:{}", word, epsilon));
  }
  if (modes.empty()) throw cli::UsageError("--modes names no mode");
  return modes;
}

}  // namespace gpvc::compare
