#include "gaussian_kernel.hpp"

// glibc's libmvec is used by declaring exp ourselves as vectorisable; <cmath> would declare it without. NaN, infinities
// and subnormals stay as they are (no -ffast-math), at most 2 ulp off. Elsewhere the loops are scalar.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
extern "C" __attribute__((simd("notinbranch"), const)) double exp(double) noexcept;
#define LFDCORE_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#include <cmath>
using std::exp;
#define LFDCORE_CLONES
#endif

namespace lfdcore::detail {

LFDCORE_CLONES void weighted_exp(double* values, const double* weights, double scale, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = weights[i] * exp(-values[i] * scale);
}

LFDCORE_CLONES void add_squared_distance(double* values, const double* column, double at, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] += (column[i] - at) * (column[i] - at);
}

}  // namespace lfdcore::detail
