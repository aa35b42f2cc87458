#include "gaussian_blocks.hpp"

#include "../vector_lanes.hpp"

LFDCORE_VECTOR_MATH(double exp(double));

namespace lfdcore::detail {
namespace {

// The exponent is held at -345, a covariance of 1e-150 where a^2 = 1: the vector exp is slow near its underflow, and
// Matern's polynomial must not be infinite there. Held here and not beside exp, where GCC would take the exponential of
// both. NaN stays.
LFDCORE_INLINE double largest_square(KernelFamily family) {
  return family == KernelFamily::squared_exponential ? 345 * 2.0 : 345 * 345 / 5.0;
}

LFDCORE_INLINE void squared_distances(const double* __restrict rows, const double* __restrict columns, int dims,
                                      int count, double largest, double* __restrict values) {
  for (int j = 0; j < count; ++j) {
    double* out = values + j * lanes;
    for (int i = 0; i < lanes; ++i) out[i] = 0;
    for (int d = 0; d < dims; ++d)
      for (int i = 0; i < lanes; ++i) {
        const double u = rows[d * lanes + i] - columns[d * lanes + j];
        out[i] += u * u;
      }
    for (int i = 0; i < lanes; ++i) out[i] = out[i] > largest ? largest : out[i];
  }
}

// C.5 and C.6 in place of the squared distances; the derivative by log l_d is slope u_d^2 in all three.
LFDCORE_INLINE void squared_exponential(double variance, int count, double* __restrict values) {
  for (int i = 0; i < count; ++i) values[i] = variance * exp(-0.5 * values[i]);
}
LFDCORE_INLINE void matern_3_2(double variance, int count, double* __restrict values) {
  for (int i = 0; i < count; ++i) {
    const double s = __builtin_sqrt(3 * values[i]);
    values[i] = variance * (1 + s) * exp(-s);
  }
}
LFDCORE_INLINE void matern_3_2_slope(double variance, int count, const double* __restrict squared,
                                     double* __restrict slopes) {
  for (int i = 0; i < count; ++i) slopes[i] = variance * 3 * exp(-__builtin_sqrt(3 * squared[i]));
}
LFDCORE_INLINE void matern_5_2(double variance, int count, double* __restrict values) {
  for (int i = 0; i < count; ++i) {
    const double s = __builtin_sqrt(5 * values[i]);
    values[i] = variance * (1 + s + s * s / 3) * exp(-s);
  }
}
LFDCORE_INLINE void matern_5_2_slope(double variance, int count, const double* __restrict squared,
                                     double* __restrict slopes) {
  for (int i = 0; i < count; ++i) {
    const double s = __builtin_sqrt(5 * squared[i]);
    slopes[i] = variance * (5.0 / 3) * (1 + s) * exp(-s);
  }
}

LFDCORE_INLINE void covariance_block(KernelFamily family, double variance, const double* rows, const double* columns,
                                     int dims, int count, double* values, double* slopes) {
  squared_distances(rows, columns, dims, count, largest_square(family), values);
  const int all = count * lanes;
  if (family == KernelFamily::squared_exponential) {
    squared_exponential(variance, all, values);
    for (int i = 0; slopes && i < all; ++i) slopes[i] = values[i];
  } else if (family == KernelFamily::matern_3_2) {
    if (slopes) matern_3_2_slope(variance, all, values, slopes);
    matern_3_2(variance, all, values);
  } else {
    if (slopes) matern_5_2_slope(variance, all, values, slopes);
    matern_5_2(variance, all, values);
  }
}

// W x V rows by 4 columns of the block stay in registers over all of depth.
template <int W, int V>
LFDCORE_INLINE void subtract_tile(double* block, const double* rows, const double* columns, int depth) {
  Vec<W> sum[4][V] = {};
  for (int k = 0; k < depth; ++k) {
    Vec<W> row[V];
    for (int v = 0; v < V; ++v) row[v] = load<W>(rows + k * lanes + v * W);
    for (int j = 0; j < 4; ++j)
      for (int v = 0; v < V; ++v) sum[j][v] += row[v] * columns[k * lanes + j];
  }
  for (int j = 0; j < 4; ++j)
    for (int v = 0; v < V; ++v) {
      double* at = block + j * lanes + v * W;
      store<W>(at, load<W>(at) - sum[j][v]);
    }
}

template <int W, int V>
LFDCORE_INLINE void subtract_block(double* block, const double* rows, const double* columns, int depth) {
  for (int i = 0; i < lanes; i += W * V)
    for (int j = 0; j < lanes; j += 4) subtract_tile<W, V>(block + j * lanes + i, rows + i, columns + j, depth);
}

// X L' = B, column after column: X_j = (B_j - sum_{m<j} L_jm X_m) / L_jj
template <int W>
LFDCORE_INLINE void solve_block(double* block, const double* lower) {
  for (int j = 0; j < lanes; ++j) {
    const double inverse = 1 / lower[j * lanes + j];
    Vec<W> column[lanes / W];
    for (int v = 0; v < lanes / W; ++v) column[v] = load<W>(block + j * lanes + v * W);
    for (int m = 0; m < j; ++m)
      for (int v = 0; v < lanes / W; ++v) column[v] -= load<W>(block + m * lanes + v * W) * lower[m * lanes + j];
    for (int v = 0; v < lanes / W; ++v) store<W>(block + j * lanes + v * W, column[v] * inverse);
  }
}

template <int W>
LFDCORE_INLINE int factor_block(double* block, const double* smallest) {
  for (int j = 0; j < lanes; ++j) {
    double* column = block + j * lanes;
    const double pivot = column[j];
    if (!(pivot > smallest[j] && pivot <= __DBL_MAX__)) return j;
    const double inverse = 1 / __builtin_sqrt(pivot);
    for (int i = 0; i < lanes; ++i) column[i] = i < j ? 0 : column[i] * inverse;
    for (int m = j + 1; m < lanes; ++m) {
      const double weight = column[m];
      double* right = block + m * lanes;
      for (int i = 0; i < lanes; i += W) store<W>(right + i, load<W>(right + i) - load<W>(column + i) * weight);
    }
  }
  return lanes;
}

template <int W>
LFDCORE_INLINE void accumulate_panel(double* sums, const double* panel, const double* values, int depth) {
  Vec<W> sum[lanes / W];
  for (int v = 0; v < lanes / W; ++v) sum[v] = load<W>(sums + v * W);
  for (int k = 0; k < depth; ++k)
    for (int v = 0; v < lanes / W; ++v) sum[v] += load<W>(panel + k * lanes + v * W) * values[k];
  for (int v = 0; v < lanes / W; ++v) store<W>(sums + v * W, sum[v]);
}

// One set of entry points for an instruction set: W doubles a register, V registers of rows in a tile.
#define LFDCORE_BLOCK_KERNELS(NAME, TARGET, W, V)                                                                  \
  struct NAME {                                                                                                    \
    TARGET static void covariance(KernelFamily family, double variance, const double* rows, const double* columns, \
                                  int dims, int count, double* values, double* slopes) {                           \
      covariance_block(family, variance, rows, columns, dims, count, values, slopes);                              \
    }                                                                                                              \
    TARGET static void subtract(double* block, const double* rows, const double* columns, int depth) {             \
      subtract_block<W, V>(block, rows, columns, depth);                                                           \
    }                                                                                                              \
    TARGET static void solve(double* block, const double* lower) { solve_block<W>(block, lower); }                 \
    TARGET static int factor(double* block, const double* smallest) { return factor_block<W>(block, smallest); }   \
    TARGET static void accumulate(double* sums, const double* panel, const double* values, int depth) {            \
      accumulate_panel<W>(sums, panel, values, depth);                                                             \
    }                                                                                                              \
  };

LFDCORE_BLOCK_KERNELS(Baseline, , 2, 2)
#if defined(__x86_64__)
LFDCORE_BLOCK_KERNELS(Avx2, LFDCORE_AVX2, 4, 2)
LFDCORE_BLOCK_KERNELS(Avx512, LFDCORE_AVX512, 8, 4)
#endif

template <class Set>
BlockKernels entries() {
  return {Set::covariance, Set::subtract, Set::solve, Set::factor, Set::accumulate};
}

}  // namespace

#if defined(__x86_64__)
constexpr unsigned flush_to_zero = 0x8040;  // results (FTZ) and operands (DAZ)
SubnormalsFlushed::SubnormalsFlushed() : before_(__builtin_ia32_stmxcsr()) {
  __builtin_ia32_ldmxcsr(before_ | flush_to_zero);
}
SubnormalsFlushed::~SubnormalsFlushed() { __builtin_ia32_ldmxcsr(before_); }
#else
SubnormalsFlushed::SubnormalsFlushed() : before_(0) {}
SubnormalsFlushed::~SubnormalsFlushed() {}
#endif

std::vector<BlockKernels> block_kernels_of_this_cpu() {
  std::vector<BlockKernels> found{entries<Baseline>()};
#if defined(__x86_64__)
  if (has_avx2()) found.push_back(entries<Avx2>());
  if (has_avx512()) found.push_back(entries<Avx512>());
#endif
  return found;
}

}  // namespace lfdcore::detail
