// Vector types of the compiler, which splits them to the width of the processor's registers.
#pragma once

#include <cstdint>

namespace gpvc::visibility {

using FourDoubles = double __attribute__((vector_size(32)));
using FourInts = std::int32_t __attribute__((vector_size(16)));
using FourFlags = std::int64_t __attribute__((vector_size(32)));
using EightFloats = float __attribute__((vector_size(32)));
using EightInts = std::int32_t __attribute__((vector_size(32)));
using EightIds = std::uint32_t __attribute__((vector_size(32)));

}  // namespace gpvc::visibility
