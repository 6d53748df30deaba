// Numbers out of text, the same in every locale.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "io/utf8.h"

namespace gpvc::io {

/// The whole of `token` as a number; nullopt when it is none. "nan" and "inf" are numbers here; beyond double's range
/// is infinity, below it zero.
inline std::optional<double> number_from(std::string_view token) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error == std::errc::invalid_argument || end != token.data() + token.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    const std::size_t exponent = token.find_first_of("eE");
    const bool tiny = exponent != std::string_view::npos && exponent + 1 < token.size() && token[exponent + 1] == '-';
    return tiny ? 0.0 : std::numeric_limits<double>::infinity();
  }
  return value;
}

template <typename Integer = std::int64_t>
std::optional<Integer> integer_from(std::string_view token) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  Integer value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size()) return std::nullopt;
  return value;
}

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v'; }

/// The text without the blanks around it.
inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The text without the byte order mark that Windows editors begin UTF-8 files with, which would hide the first word.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

/// Removes and returns the next word of `text`; empty at its end.
inline std::string_view next_word(std::string_view& text) {
  std::size_t begin = 0;
  while (begin < text.size() && is_blank(text[begin])) ++begin;
  std::size_t end = begin;
  while (end < text.size() && !is_blank(text[end])) ++end;
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

/// Removes and returns the next line of `text` without its line end (LF or CR LF).
inline std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

/// Lower case of ASCII letters; other bytes stay, since file names are bytes.
inline std::string lower_case(std::string_view word) {
  std::string text(word);
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// `word` in quotes and cut to a length fit for a message, between characters of UTF-8; control characters of ASCII, and bytes
/// that are no UTF-8, as '?'.
inline std::string quote(std::string_view word) {
  const std::string_view shown = whole_characters(word, 40);
  std::string text = "'";
  for (std::size_t at = 0; at < shown.size();) {
    const std::size_t length = character_length(shown, at);
    const auto first = static_cast<unsigned char>(shown[at]);
    if (length == 0 || first < 0x20 || first == 0x7f)
      text += '?';
    else
      text += shown.substr(at, length);
    at += std::max<std::size_t>(1, length);
  }
  return text + (shown.size() < word.size() ? "...'" : "'");
}

}  // namespace gpvc::io
