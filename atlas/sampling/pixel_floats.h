// The channels of a pixel of bytes as floats, computed with at once.
#pragma once

#include <cstdint>

namespace gpvc::atlas {

// Split by the compiler to what the processor has.
using FourFloats = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));

/// The channels of a pixel, bytes r, g, b from the lowest, where they are in its word: times 1, 2^8 and 2^16, which rounds no
/// float.
inline FourFloats in_place(std::uint32_t pixel) {
  const auto word = static_cast<std::int32_t>(pixel);
  return __builtin_convertvector((FourInts{word, word, word, word} & FourInts{0xFF, 0xFF00, 0xFF0000, 0}), FourFloats);
}

/// What undoes these factors.
inline constexpr FourFloats kOutOfPlace{1, 1.0f / (1 << 8), 1.0f / (1 << 16), 0};

}  // namespace gpvc::atlas
