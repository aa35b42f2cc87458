// The weights 2^y are kept as mantissa and exponent apart, m 2^n with n = round(y), and each 3 x 3 sum is taken
// relative to its own largest n: one exponential a cell, and nothing can over- or underflow however wide the values
// spread.
#include "dpp_sweep.hpp"

#include <array>

#include "../vector_lanes.hpp"

namespace lfdcore::detail {
namespace {

template <class V>
LFDCORE_INLINE V larger(V a, V b) {
  return a > b ? a : b;
}

// Adding it leaves an integer in the low bits of the sum (|x| < 2^51).
constexpr double round_magic = 0x1.8p52;

// 2^f for |f| <= 1/2: interpolated at the 11 Chebyshev nodes, relative error < 4e-16
template <class V>
LFDCORE_INLINE V exp2_fraction(V f) {
  constexpr std::array c{1.0,
                         0.69314718055995,
                         0.24022650695910097,
                         0.05550410866444772,
                         0.009618129107606888,
                         0.0013333558230164974,
                         0.0001540353044173605,
                         1.5252657260200837e-05,
                         1.321544258792169e-06,
                         1.0208690299958306e-07,
                         7.072585949269224e-09};
  V p = f * c[10] + c[9];
  for (int i = 8; i >= 0; --i) p = p * f + c[i];
  return p;
}

// 2^d for an integer d <= 0; 2^-400, which is nothing beside 1, for anything lower: products of two stay normal
// numbers, since arithmetic on subnormal ones is slow.
template <int N>
LFDCORE_INLINE Vec<N> power_of_two(Vec<N> d) {
  const Vec<N> biased = larger(d, Vec<N>{} - 400) + (round_magic + 1023);
  return reinterpret_cast<Vec<N>>(reinterpret_cast<typename Lanes<N>::Bits>(biased) << 52);
}

// Rows of one grid row: weights m 2^n and m y of its cells, then the same summed over three neighbours.
struct Row {
  double *m, *my, *n, *sum, *sum_y, *top;
};

Row row_at(double* rows, int stride, int slot) {
  const int pitch = stride + 2 * lane_padding;
  double* first = rows + 6 * slot * pitch + lane_padding;
  return {first, first + pitch, first + 2 * pitch, first + 3 * pitch, first + 4 * pitch, first + 5 * pitch};
}

void clear_sums(const Row& row, int stride) {
  for (int x = 0; x < stride; ++x) row.sum[x] = row.sum_y[x] = 0, row.top[x] = blocked_value;
}

// The cells left and right of a row weigh nothing.
void clear_ends(const Row& row, int stride) {
  for (const int x : {-1, stride}) row.m[x] = row.my[x] = 0, row.n[x] = blocked_value;
}

template <int N>
LFDCORE_INLINE void weigh(const double* y, const Row& row, int stride) {
  for (int x = 0; x < stride; x += N) {
    const Vec<N> value = load<N>(y + x);
    const Vec<N> n = (value + round_magic) - round_magic;
    const Vec<N> m = value > blocked_below ? exp2_fraction(value - n) : Vec<N>{};
    store<N>(row.m + x, m);
    store<N>(row.my + x, m * value);
    store<N>(row.n + x, n);
  }
}

template <int N>
LFDCORE_INLINE void sum_along(const Row& row, int stride) {
  for (int x = 0; x < stride; x += N) {
    const Vec<N> n0 = load<N>(row.n + x - 1), n1 = load<N>(row.n + x), n2 = load<N>(row.n + x + 1);
    const Vec<N> top = larger(larger(n0, n1), n2);
    const Vec<N> f0 = power_of_two<N>(n0 - top), f1 = power_of_two<N>(n1 - top), f2 = power_of_two<N>(n2 - top);
    store<N>(row.sum + x, load<N>(row.m + x - 1) * f0 + load<N>(row.m + x) * f1 + load<N>(row.m + x + 1) * f2);
    store<N>(row.sum_y + x, load<N>(row.my + x - 1) * f0 + load<N>(row.my + x) * f1 + load<N>(row.my + x + 1) * f2);
    store<N>(row.top + x, top);
  }
}

template <int N>
LFDCORE_INLINE void sum_across(const Row& below, const Row& row, const Row& above, const double* self,
                               const double* reward, double discount, double count, double* next, int stride) {
  for (int x = 0; x < stride; x += N) {
    const Vec<N> n0 = load<N>(below.top + x), n1 = load<N>(row.top + x), n2 = load<N>(above.top + x);
    const Vec<N> top = larger(larger(n0, n1), n2);
    const Vec<N> f0 = power_of_two<N>(n0 - top), f1 = power_of_two<N>(n1 - top), f2 = power_of_two<N>(n2 - top);
    const Vec<N> own = load<N>(self + x) * power_of_two<N>(load<N>(row.n + x) - top);
    const Vec<N> weight = load<N>(below.sum + x) * f0 + load<N>(row.sum + x) * f1 + load<N>(above.sum + x) * f2 +
                          load<N>(row.m + x) * own;
    const Vec<N> weighted = load<N>(below.sum_y + x) * f0 + load<N>(row.sum_y + x) * f1 +
                            load<N>(above.sum_y + x) * f2 + load<N>(row.my + x) * own;
    // D.7 summed over the moves, with the Boltzmann mean of D.8: weighted / weight.
    // A cell without any open neighbour has weight 0; it is blocked itself.
    store<N>(next + x, count * load<N>(reward + x) + discount * (weighted / larger(weight, Vec<N>{} + 1e-300)));
  }
}

template <int N>
LFDCORE_INLINE void sweep_lanes(const SweepGrid& grid, const double* y, double discount, double count, double* next) {
  const int stride = grid.stride;
  std::array<Row, 3> ring;  // the rows below, at and above the one that is summed, in turn
  for (int slot = 0; slot < 3; ++slot) clear_ends(ring[slot] = row_at(grid.rows, stride, slot), stride);
  clear_sums(ring[2], stride);
  for (int iy = 0; iy <= grid.height; ++iy) {
    const Row& above = ring[iy % 3];
    if (iy < grid.height) {
      weigh<N>(y + iy * stride, above, stride);
      sum_along<N>(above, stride);
    } else {
      clear_sums(above, stride);
    }
    if (iy == 0) continue;
    const int at = iy - 1;
    const double* self = at == 0 || at == grid.height - 1 ? grid.self_outer : grid.self_inner;
    sum_across<N>(ring[(at + 2) % 3], ring[at % 3], above, self, grid.reward + at * stride, discount, count,
                  next + at * stride, stride);
  }
}

void sweep_2(const SweepGrid& grid, const double* y, double discount, double count, double* next) {
  sweep_lanes<2>(grid, y, discount, count, next);
}

#if defined(__x86_64__)
LFDCORE_AVX2 void sweep_4(const SweepGrid& grid, const double* y, double discount, double count, double* next) {
  sweep_lanes<4>(grid, y, discount, count, next);
}
LFDCORE_AVX512 void sweep_8(const SweepGrid& grid, const double* y, double discount, double count, double* next) {
  sweep_lanes<8>(grid, y, discount, count, next);
}
#endif

}  // namespace

std::vector<Sweep*> sweeps_of_this_cpu() {
  std::vector<Sweep*> sweeps{sweep_2};
#if defined(__x86_64__)
  if (has_avx2()) sweeps.push_back(sweep_4);
  if (has_avx512()) sweeps.push_back(sweep_8);
#endif
  return sweeps;
}

void sweep_grid(const SweepGrid& grid, const double* y, double discount, double count, double* next) {
  static Sweep* const widest = sweeps_of_this_cpu().back();
  widest(grid, y, discount, count, next);
}

}  // namespace lfdcore::detail
