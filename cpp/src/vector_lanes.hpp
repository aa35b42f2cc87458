// Vectors of N doubles for loops that the compiler does not vectorise well by itself, and the instruction sets that
// they are written for. Passed between inlined functions only, since their ABI differs between instruction sets.
#pragma once

#include <cstdint>

#include "vectorised.hpp"

namespace lfdcore::detail {

template <int N>
struct Lanes {
  using Double __attribute__((vector_size(8 * N))) = double;
  using Bits __attribute__((vector_size(8 * N))) = std::uint64_t;
  using Unaligned __attribute__((vector_size(8 * N), aligned(8), may_alias)) = double;
};
template <int N>
using Vec = typename Lanes<N>::Double;

template <int N>
LFDCORE_INLINE Vec<N> load(const double* from) {
  return *reinterpret_cast<const typename Lanes<N>::Unaligned*>(from);
}
template <int N>
LFDCORE_INLINE void store(double* to, Vec<N> value) {
  *reinterpret_cast<typename Lanes<N>::Unaligned*>(to) = value;
}

#if defined(__x86_64__)
// Before a function: it is compiled for 4 or 8 lanes; call it only where the CPU has them.
#define LFDCORE_AVX2 __attribute__((target("avx2,fma")))
#define LFDCORE_AVX512 __attribute__((target("avx2,fma,avx512f,avx512dq,avx512bw,avx512vl")))

inline bool has_avx2() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }
inline bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
}
#endif

}  // namespace lfdcore::detail
