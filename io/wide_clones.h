// Functions that are compiled twice, for wide vectors and for the baseline processor.
#pragma once

// Compiles a function for AVX2 and for the baseline processor; the program chooses when it starts. Both versions do the
// same operations in the same order. What is called within is compiled for AVX2 only where it is inlined.
#if defined(__x86_64__) && defined(__ELF__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define GPVC_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define GPVC_WIDE_CLONES
#endif
