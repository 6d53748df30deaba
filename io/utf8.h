// Text in UTF-8.
#pragma once

#include <cstddef>
#include <string_view>

namespace gpvc::io {

/// The longest beginning of `text` of at most `bytes` bytes that cuts no character apart.
inline std::string_view whole_characters(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  const auto continues = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; };
  while (bytes > 0 && continues(bytes)) --bytes;
  return text.substr(0, bytes);
}

}  // namespace gpvc::io
