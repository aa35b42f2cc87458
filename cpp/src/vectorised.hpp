// How a hot loop is compiled for several instruction sets, of which the widest is chosen when the library is loaded.
//
// Both LFDCORE_CLONES and LFDCORE_VECTOR_MATH need x86-64, GCC and glibc (the choice is an ifunc, which neither musl
// nor macOS has). Elsewhere loops are compiled once, for the baseline, and call the scalar functions.
#pragma once

#include <cmath>

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)

// Before a function: it is compiled for AVX-512, AVX2 and the baseline.
#define LFDCORE_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))

// LFDCORE_VECTOR_MATH(double exp(double)); at global scope: loops of this file may call glibc's vector variant
// (libmvec), which glibc itself declares under -ffast-math only. NaN, infinities and subnormals stay as they are; a
// result is a few ulp off. Each file says it for what it needs, so that no other loop's last digits change.
#define LFDCORE_VECTOR_MATH(declaration) extern "C" __attribute__((simd("notinbranch"), const)) declaration noexcept

#else
#define LFDCORE_CLONES
#define LFDCORE_VECTOR_MATH(declaration) static_assert(true)
#endif

// For what the cloned functions call: inlined, it is compiled for the caller's instruction set, else for the baseline.
#define LFDCORE_INLINE inline __attribute__((always_inline))
