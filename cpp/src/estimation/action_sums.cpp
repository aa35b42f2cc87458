#include "action_sums.hpp"

#include "../vectorised.hpp"

LFDCORE_VECTOR_MATH(double exp(double));

namespace lfdcore::detail {
namespace {

constexpr std::size_t lanes = 32;
constexpr double lowest = -600;  // the vector exp is slow near its underflow

// log W <= 0; where goals are 1e8 length-scales apart, rounding would have it otherwise.
inline double bounded(double exponent) { return exponent < lowest ? lowest : exponent > 0 ? 0 : exponent; }

}  // namespace

LFDCORE_CLONES void pair_column(const PairTerms& terms, std::size_t column, std::size_t count, double* __restrict out) {
  const double right = terms.right[column];
  for (std::size_t i = 0; i < count; ++i) out[i] = terms.left[i] + right;
  for (int d = 0; d < terms.dims; ++d) {
    const double at = terms.at[d * terms.column_stride + column];
    const double* slopes = terms.slopes + d * terms.row_stride;
    for (std::size_t i = 0; i < count; ++i) out[i] += slopes[i] * at;
  }
  for (std::size_t i = 0; i < count; ++i) out[i] = bounded(out[i]);
  for (std::size_t i = 0; i < count; ++i) out[i] = exp(out[i]);
}

LFDCORE_CLONES PairSums pair_sums(const PairTerms& terms, std::size_t row, std::size_t first, std::size_t last,
                                  const double* x, const double* y, const double* k, const double* inverse) {
  double W[lanes], weighted[lanes] = {}, traced[lanes] = {};
  for (std::size_t j = first; j < last; ++j) {
    for (std::size_t i = 0; i < lanes; ++i) W[i] = terms.left[row + i] + terms.right[j];
    for (int d = 0; d < terms.dims; ++d) {
      const double at = terms.at[d * terms.column_stride + j];
      const double* slopes = terms.slopes + d * terms.row_stride + row;
      for (std::size_t i = 0; i < lanes; ++i) W[i] += slopes[i] * at;
    }
    for (std::size_t i = 0; i < lanes; ++i) W[i] = bounded(W[i]);
    for (std::size_t i = 0; i < lanes; ++i) W[i] = exp(W[i]);
    for (std::size_t i = 0; i < lanes; ++i) weighted[i] += W[i] * y[j];
    if (!inverse) continue;
    for (std::size_t i = 0; i < lanes; ++i) traced[i] += W[i] * k[j] * inverse[(j - first) * lanes + i];
  }
  PairSums sums;
  for (std::size_t i = 0; i < lanes; ++i) sums.weighted += weighted[i] * x[row + i];
  for (std::size_t i = 0; inverse && i < lanes; ++i) sums.traced += traced[i] * k[row + i];
  return sums;
}

LFDCORE_CLONES double class_products(const double* z, const double* W, std::size_t count) {
  double sums[lanes] = {};
  for (std::size_t c = 0; c < count; ++c) {
    double row[lanes] = {};
    for (std::size_t other = 0; other < c; ++other) {
      const double twice = 2 * W[c * count + other];
      for (std::size_t i = 0; i < lanes; ++i) row[i] += twice * z[other * lanes + i];
    }
    const double own = W[c * count + c];
    for (std::size_t i = 0; i < lanes; ++i) sums[i] += (row[i] + own * z[c * lanes + i]) * z[c * lanes + i];
  }
  double sum = 0;
  for (const double lane : sums) sum += lane;
  return sum;
}

LFDCORE_CLONES double inner_product(const double* a, const double* b, std::size_t count) {
  double sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) sums[l] += a[i + l] * b[i + l];
  for (; i < count; ++i) sums[0] += a[i] * b[i];
  double sum = 0;
  for (const double lane : sums) sum += lane;
  return sum;
}

}  // namespace lfdcore::detail
