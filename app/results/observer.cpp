#include "app/results/observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "io/utf8.h"

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

std::string printable(const std::string& text) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = io::character_length(text, at);
    const auto first = static_cast<unsigned char>(text[at]);
    const bool control =
        (first < 0x20 && first != '\n' && first != '\t') || first == 0x7F ||
        (first == 0xC2 && length == 2 && static_cast<unsigned char>(text[at + 1]) < 0xA0);  // U+0080 to U+009F
    if (length > 0 && !control) {
      shown += text.substr(at, length);
      at += length;
    } else {
      shown += fmt::format("\\x{:02x}", first);
      ++at;
    }
  }
  return shown;
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

std::optional<std::size_t> bytes_from_text(const std::string& text) {
  constexpr std::string_view kUnits = "kmgt";
  constexpr double kMost = 0x1p60;
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (end == text.c_str()) return std::nullopt;
  std::string unit;
  for (; *end != '\0'; ++end)
    if (*end != ' ') unit.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(*end))));
  double factor = 1;
  if (const std::size_t power = unit.empty() ? std::string_view::npos : kUnits.find(unit.front());
      power != std::string_view::npos) {
    const bool binary = unit.size() > 1 && unit[1] == 'i';
    factor = std::pow(binary ? 1024.0 : 1000.0, static_cast<double>(power + 1));
    unit.erase(0, binary ? 2 : 1);
  }
  if (!(unit.empty() || unit == "b") || !(number > 0) || !(number * factor < kMost)) return std::nullopt;
  return static_cast<std::size_t>(number * factor);
}

std::string readable_list(std::span<const std::string> names, std::size_t most) {
  std::string text;
  for (std::size_t n = 0; n < std::min(most, names.size()); ++n) text += (n == 0 ? "" : ", ") + names[n];
  return names.size() > most ? text + ", ..." : text;
}

}  // namespace gpvc::results
