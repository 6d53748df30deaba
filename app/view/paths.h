// Numbers in the paths that the page asks for.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string_view>

namespace gpvc::view {

/// "quarters/12" behind "quarters/" is 12; nullopt for anything else. \param count numbers are below it
inline std::optional<std::size_t> number_behind(std::string_view path, std::string_view folder, std::size_t count) {
  if (!path.starts_with(folder)) return std::nullopt;
  path.remove_prefix(folder.size());
  std::size_t number = 0;
  const auto [at, failed] = std::from_chars(path.data(), path.data() + path.size(), number);
  if (failed != std::errc{} || at != path.data() + path.size() || number >= count) return std::nullopt;
  return number;
}

}  // namespace gpvc::view
