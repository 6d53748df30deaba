// The name of each value of an enum, as the command line reads it and run.json writes it. A table stands beside its enum.
#pragma once

#include <cstddef>

namespace gpvc {

template <class Value>
struct Named {
  const char* name;
  Value value;
};

/// The value's name in its table, nullptr where the table lacks it.
template <class Value, std::size_t kCount>
constexpr const char* name_of(const Named<Value> (&names)[kCount], const Value& value) {
  for (const Named<Value>& known : names)
    if (known.value == value) return known.name;
  return nullptr;
}

}  // namespace gpvc
