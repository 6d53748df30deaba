// Vector types of the compiler, which splits them to the width of the processor's registers.
#pragma once

#include <cstdint>

// Compiles a function for AVX2 and for the baseline processor; the program chooses when it starts. Both versions do the
// same operations in the same order.
#if defined(__x86_64__) && defined(__ELF__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define GPVC_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define GPVC_WIDE_CLONES
#endif

namespace gpvc::visibility {

using FourDoubles = double __attribute__((vector_size(32)));
using FourInts = std::int32_t __attribute__((vector_size(16)));
using FourFlags = std::int64_t __attribute__((vector_size(32)));
using EightFloats = float __attribute__((vector_size(32)));
using EightInts = std::int32_t __attribute__((vector_size(32)));
using EightIds = std::uint32_t __attribute__((vector_size(32)));

}  // namespace gpvc::visibility
