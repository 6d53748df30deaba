// Numbers as text, the same in every locale.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace gpvc::io {

/// The shortest text that reads back as the same number.
inline std::string shortest_text(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// The fewest of 15 to 17 digits that read back as the same number, written as printf's %g does: 100000, where
/// shortest_text has 1e+05.
inline std::string general_text(double value) {
  std::array<char, 32> text{};
  for (int digits = 15;; ++digits) {
    char* end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits).ptr;
    double back = 0;
    std::from_chars(text.data(), end, back);
    if (back == value || digits == 17) return std::string(text.data(), end);
  }
}

}  // namespace gpvc::io
