// Names of the visibility modes.
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/number_text.h"
#include "visibility/method.h"

namespace gpvc::visibility {
namespace {

std::string quoted(std::string_view text) {
  std::string result(1, '\'');
  result.append(text).push_back('\'');
  return result;
}

[[noreturn]] void refuse(std::string_view mode, const std::string& reason) {
  throw std::invalid_argument(quoted(mode) + " is no visibility mode: " + reason);
}

std::vector<std::string_view> words(std::string_view mode) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= mode.size();) {
    const std::size_t colon = std::min(mode.find(':', at), mode.size());
    parts.push_back(mode.substr(at, colon - at));
    at = colon + 1;
  }
  return parts;
}

double bias(std::string_view mode, std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value) || !(value > 0))
    refuse(mode, "its bias " + quoted(text) + " is not a number above 0, like 0.001 or 1e-5");
  return value;
}

/// Reads `kind:CHOICE:EPS`: sets the bias and returns the value that CHOICE names in a table of two.
template <class Value>
Value biased(std::string_view mode, const std::vector<std::string_view>& parts, const Named<Value> (&choices)[2],
             double& epsilon) {
  const std::string kind(parts[0]), first(choices[0].name), second(choices[1].name);
  if (parts.size() != 3) refuse(mode, "expected " + kind + ":" + first + ":EPS or " + kind + ":" + second + ":EPS");
  for (const Named<Value>& choice : choices) {
    if (parts[1] != choice.name) continue;
    epsilon = bias(mode, parts[2]);
    return choice.value;
  }
  refuse(mode, quoted(parts[1]) + " is neither " + first + " nor " + second);
}

std::string biased_name(const char* kind, const char* choice, double epsilon) {
  return std::string(kind) + ":" + choice + ":" + io::shortest_text(epsilon);
}

}  // namespace

Method parse_visibility_mode(std::string_view mode) {
  for (const auto& [name, sampling] : kSamplingNames)
    if (mode == name) return Gpvc{sampling};
  if (mode == "none") return NoTest{};
  const std::vector<std::string_view> parts = words(mode);
  if (parts[0] == "shadow-map") {
    ShadowMap shadow_map;
    shadow_map.projection = biased(mode, parts, kProjectionNames, shadow_map.epsilon);
    return shadow_map;
  }
  if (parts[0] == "ray") {
    RayTracing rays;
    rays.sampling = biased(mode, parts, kRaySamplingNames, rays.epsilon);
    return rays;
  }
  refuse(mode,
         "expected gpvc, gpvc:ves, gpvc:dense, shadow-map:spc:EPS, shadow-map:apc:EPS, ray:sparse:EPS, "
         "ray:dense:EPS or none");
}

std::string visibility_mode_name(const Method& method) {
  if (const auto* shadow_map = std::get_if<ShadowMap>(&method))
    return biased_name("shadow-map", name_of(kProjectionNames, shadow_map->projection), shadow_map->epsilon);
  if (const auto* rays = std::get_if<RayTracing>(&method))
    return biased_name("ray", name_of(kRaySamplingNames, rays->sampling), rays->epsilon);
  if (std::holds_alternative<NoTest>(method)) return "none";
  const auto* paper = std::get_if<PaperGpvc>(&method);
  return name_of(kSamplingNames, paper != nullptr ? paper->sampling : std::get<Gpvc>(method).sampling);
}

}  // namespace gpvc::visibility
