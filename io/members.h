// One list of the members of each struct that is stored or hashed. What writes, reads and hashes the struct follows from it.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <ranges>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace gpvc::io {

template <typename Value, typename Type>
concept Like = std::same_as<std::remove_const_t<Value>, Type>;

/// A struct with a list of its members.
template <typename T>
concept Listed = requires(T& value) {
  members_of(value);
};

/// A value that equals another one exactly if all its bytes do. (Not so a bool: most bytes are no valid one.)
template <typename T>
concept PlainBytes = (std::has_unique_object_representations_v<T> || std::floating_point<T>)&&!std::same_as<T, bool> &&
                     (std::is_arithmetic_v<T> || std::is_enum_v<T>);

namespace detail {

template <typename T>
inline constexpr bool kIsArray = false;
template <typename T, std::size_t kCount>
inline constexpr bool kIsArray<std::array<T, kCount>> = true;
template <typename T>
inline constexpr bool kIsVector = false;
template <typename T>
inline constexpr bool kIsVector<std::vector<T>> = true;
template <typename T>
inline constexpr bool kIsOptional = false;
template <typename T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <typename T>
inline constexpr bool kIsVariant = false;
template <typename... Ts>
inline constexpr bool kIsVariant<std::variant<Ts...>> = true;

template <typename T>
constexpr bool is_dense();
template <typename... Members>
constexpr bool are_dense(std::size_t size, std::tuple<Members&...>*) {
  return (is_dense<Members>() && ...) && (sizeof(Members) + ... + 0) == size;
}
template <typename T>
constexpr bool is_dense() {
  if constexpr (PlainBytes<T>)
    return true;
  else if constexpr (kIsArray<T>)
    return is_dense<typename T::value_type>();
  else if constexpr (Listed<T>)
    return are_dense(sizeof(T), static_cast<decltype(members_of(std::declval<T&>()))*>(nullptr));
  else
    return false;
}

}  // namespace detail

/// A type without padding bytes of which every bit pattern is a valid value: arrays of it are written and read at once.
template <typename T>
concept Dense = detail::is_dense<T>();

/// Writes a number, an enum, a text, a path, a list, an optional or alternative value, or a struct with a list of its members,
/// by out.write(data, bytes).
template <typename Out, typename T>
void put_value(Out& out, const T& value) {
  if constexpr (Dense<T>) {
    out.write(&value, sizeof value);
  } else if constexpr (std::same_as<T, bool>) {
    put_value(out, static_cast<std::uint8_t>(value ? 1 : 0));
  } else if constexpr (std::same_as<T, std::filesystem::path>) {
    put_value(out, value.native());
  } else if constexpr (std::ranges::contiguous_range<T> && !detail::kIsArray<T>) {  // texts, vectors, spans
    const std::size_t count = std::ranges::size(value);
    put_value(out, count);
    if constexpr (Dense<std::ranges::range_value_t<T>>)
      out.write(std::ranges::data(value), count * sizeof(std::ranges::range_value_t<T>));
    else
      for (const auto& each : value) put_value(out, each);
  } else if constexpr (detail::kIsArray<T>) {
    for (const auto& each : value) put_value(out, each);
  } else if constexpr (detail::kIsOptional<T>) {
    put_value(out, value.has_value());
    if (value) put_value(out, *value);
  } else if constexpr (detail::kIsVariant<T>) {
    put_value(out, value.index());
    std::visit([&](const auto& alternative) { put_value(out, alternative); }, value);
  } else {
    static_assert(Listed<T>, "a struct that is stored or hashed needs a list of its members: GPVC_MEMBERS");
    std::apply([&](const auto&... member) { (put_value(out, member), ...); }, members_of(value));
  }
}

template <typename In, typename... Ts>
void get_alternative(In& in, std::variant<Ts...>& value) {
  const auto index = in.template get<std::size_t>();
  std::size_t at = 0;
  const bool known = ((at++ == index ? (get_value(in, value.template emplace<Ts>()), true) : false) || ...);
  if (!known) in.refuse();
}

/// Reads it back by in.read(data, bytes); calls in.refuse() for bytes that are no value. \pre value is a default one
template <typename In, typename T>
void get_value(In& in, T& value) {
  if constexpr (Dense<T>) {
    in.read(&value, sizeof value);
  } else if constexpr (std::same_as<T, bool>) {
    const auto byte = in.template get<std::uint8_t>();
    if (byte > 1) in.refuse();
    value = byte == 1;
  } else if constexpr (std::same_as<T, std::filesystem::path>) {
    value = in.template get<std::string>();
  } else if constexpr (std::same_as<T, std::string> || detail::kIsVector<T>) {
    using Item = typename T::value_type;
    const auto count = in.template get<std::size_t>();
    if constexpr (Dense<Item>) {
      if (count > in.left() / sizeof(Item)) in.refuse();
      value.resize(count);
      in.read(value.data(), count * sizeof(Item));
    } else {
      if (count > in.left()) in.refuse();  // each takes a byte or more
      for (std::size_t i = 0; i < count; ++i) get_value(in, value.emplace_back());
    }
  } else if constexpr (detail::kIsArray<T>) {
    for (auto& each : value) get_value(in, each);
  } else if constexpr (detail::kIsOptional<T>) {
    if (in.template get<bool>()) get_value(in, value.emplace());
  } else if constexpr (detail::kIsVariant<T>) {
    get_alternative(in, value);
  } else {
    static_assert(Listed<T>, "a struct that is stored needs a list of its members: GPVC_MEMBERS");
    std::apply([&](auto&... member) { (get_value(in, member), ...); }, members_of(value));
  }
}

}  // namespace gpvc::io

/// The list of all members of a struct, in its namespace: GPVC_MEMBERS(Pose, rotation, centre). A struct that has others does
/// not compile.
#define GPVC_MEMBERS(Type, ...)                      \
  template <::gpvc::io::Like<Type> GpvcValue>        \
  constexpr auto members_of(GpvcValue& gpvc_value) { \
    auto& [__VA_ARGS__] = gpvc_value;                \
    return std::tie(__VA_ARGS__);                    \
  }
