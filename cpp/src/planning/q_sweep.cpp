#include "q_sweep.hpp"

#include "../vectorised.hpp"

namespace lfdcore::detail {
namespace {

LFDCORE_INLINE double larger(double a, double b) { return a > b ? a : b; }

LFDCORE_INLINE void maxima_along(const double* q, double* __restrict row, int stride) {
  for (int x = 0; x < stride; ++x) row[x] = larger(larger(q[x - 1], q[x + 1]), q[x]);
}

LFDCORE_INLINE void fill_blocked(double* row, int stride) {
  for (int x = 0; x < stride; ++x) row[x] = q_blocked_value;
}

LFDCORE_INLINE void update_row(double* __restrict q, const double* __restrict gain, const double* __restrict below,
                               const double* __restrict row, const double* __restrict above, double keep, double pull,
                               int stride) {
  for (int x = 0; x < stride; ++x) {
    q[x] = keep * q[x] + gain[x] + pull * larger(larger(below[x], above[x]), row[x]);
  }
}

}  // namespace

// A row is overwritten only after the maxima along it and its neighbours were taken, so no second grid is needed.
LFDCORE_CLONES void q_sweep(double* q, const double* gain, double keep, double pull, int height, int stride,
                            double* rows) {
  double *below = rows, *row = rows + stride, *above = rows + 2 * stride;
  fill_blocked(below, stride);
  maxima_along(q, row, stride);
  for (int iy = 0; iy < height; ++iy) {
    if (iy + 1 < height) {
      maxima_along(q + (iy + 1) * stride, above, stride);
    } else {
      fill_blocked(above, stride);
    }
    update_row(q + iy * stride, gain + iy * stride, below, row, above, keep, pull, stride);
    double* const oldest = below;
    below = row, row = above, above = oldest;
  }
}

}  // namespace lfdcore::detail
