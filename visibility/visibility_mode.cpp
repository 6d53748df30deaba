// Names of the visibility modes.
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

constexpr std::array kSamplings{"gpvc", "gpvc:ves", "gpvc:dense"};

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

/// The second and third word of `kind:CHOICE:EPS`: returns the number of the choice, sets the bias.
std::size_t biased(std::string_view mode, const std::vector<std::string_view>& parts,
                   const std::array<std::string_view, 2>& choices, double& epsilon) {
  const std::string kind(parts[0]), first(choices[0]), second(choices[1]);
  if (parts.size() != 3) refuse(mode, "expected " + kind + ":" + first + ":EPS or " + kind + ":" + second + ":EPS");
  for (std::size_t choice = 0; choice < choices.size(); ++choice) {
    if (parts[1] != choices[choice]) continue;
    epsilon = bias(mode, parts[2]);
    return choice;
  }
  refuse(mode, quoted(parts[1]) + " is neither " + first + " nor " + second);
}

std::string shortest(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

}  // namespace

void set_visibility_mode(std::string_view mode, VisibilityOptions& options) {
  constexpr std::array<std::string_view, 2> kProjections{"apc", "spc"}, kRays{"sparse", "dense"};
  for (std::size_t sampling = 0; sampling < kSamplings.size(); ++sampling) {
    if (mode != kSamplings[sampling]) continue;
    options.method = Method::gpvc;
    options.sampling = static_cast<Sampling>(sampling);
    return;
  }
  const std::vector<std::string_view> parts = words(mode);
  if (mode == "none") {
    options.method = Method::none;
  } else if (parts[0] == "shadow-map") {
    options.projection = static_cast<Projection>(biased(mode, parts, kProjections, options.epsilon));
    options.method = Method::shadow_map;
  } else if (parts[0] == "ray") {
    options.rays = static_cast<Rays>(biased(mode, parts, kRays, options.epsilon));
    options.method = Method::ray;
  } else {
    refuse(mode,
           "expected gpvc, gpvc:ves, gpvc:dense, shadow-map:spc:EPS, shadow-map:apc:EPS, ray:sparse:EPS, "
           "ray:dense:EPS or none");
  }
}

std::string visibility_mode_name(const VisibilityOptions& options) {
  switch (options.method) {
    case Method::shadow_map:
      return (options.projection == Projection::spc ? "shadow-map:spc:" : "shadow-map:apc:") +
             shortest(options.epsilon);
    case Method::ray:
      return (options.rays == Rays::sparse ? "ray:sparse:" : "ray:dense:") + shortest(options.epsilon);
    case Method::none:
      return "none";
    case Method::gpvc:
      break;
  }
  return kSamplings[static_cast<std::size_t>(options.sampling)];
}

}  // namespace gpvc::visibility
