// Whether all numbers of a value are finite.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <ranges>
#include <string>
#include <tuple>

#include "members.h"

namespace gpvc::io {

/// All floating-point members, however deep, of structs with a list of their members (members.h), of lists and numbers. Texts and
/// paths have none.
template <typename T>
bool is_finite(const T& value) {
  if constexpr (std::floating_point<T>)
    return std::isfinite(value);
  else if constexpr (Listed<const T>)
    return std::apply([](const auto&... member) { return (is_finite(member) && ...); }, members_of(value));
  else if constexpr (std::ranges::range<T> && !std::same_as<T, std::string> && !std::same_as<T, std::filesystem::path>)
    return std::ranges::all_of(value, [](const auto& each) { return is_finite(each); });
  else
    return true;
}

}  // namespace gpvc::io
