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

}  // namespace gpvc::io
