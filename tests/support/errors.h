// What errors say beside their sentences.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "io/error.h"

namespace gpvc::test {

/// The error that a call throws; nullopt: none of ours.
template <class Call>
std::optional<Error> caught(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

/// What a caller may do about the error that a call throws.
template <class Call>
std::vector<Cure> cures_of(const Call& call) {
  const std::optional<Error> error = caught(call);
  return error ? error->cures() : std::vector<Cure>();
}

/// NaN: the error has no such measure.
inline double measured(const Error& error, const std::string& name) {
  for (const Measure& measure : error.measures())
    if (measure.name == name) return measure.value;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace gpvc::test
