#include "app/results/observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gpvc::results {

std::string readable_count(std::size_t count) {
  const std::string digits = std::to_string(count);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text.push_back(' ');
    text.push_back(digits[i]);
  }
  return text;
}

std::string readable_duration(double seconds) {
  const auto whole = static_cast<long long>(std::llround(std::max(seconds, 0.0)));
  if (whole < 100) return fmt::format("{} s", whole);
  if (whole < 5400) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

std::string readable_bytes(double bytes) {
  return bytes < 0.995e9 ? fmt::format("{:.0f} MB", std::ceil(bytes / 1e6)) : fmt::format("{:.1f} GB", bytes / 1e9);
}

std::string readable_list(std::span<const std::string> names, std::size_t most) {
  std::string text;
  for (std::size_t n = 0; n < std::min(most, names.size()); ++n) text += (n == 0 ? "" : ", ") + names[n];
  return names.size() > most ? text + ", ..." : text;
}

}  // namespace gpvc::results
