// The vectorised inner loops of the action model's moments, apart from Eigen and <cmath>: see action_sums.cpp.
#pragma once

#include <cstddef>

namespace lfdcore::detail {

// W_ij = exp(left_i + right_j + sum_d slopes_di at_dj), <= 1: the part of Q_ab,ij that depends on the goals i and j
// alone. Rows and columns are each a table of values[d * stride + index].
struct PairTerms {
  const double* left;
  const double* slopes;
  std::size_t row_stride;
  const double* right;
  const double* at;
  std::size_t column_stride;
  int dims;
};

// out[i] = W_ij, i < count
void pair_column(const PairTerms& terms, std::size_t column, std::size_t count, double* out);

// For the 32 rows from `row`: sum_ij x_i W_ij y_j over the columns [first, last), and the same sum with k_i k_j D_ij
// in place of x_i y_j if `inverse` is not null: D of these rows, 32 of a column contiguous, from `first` on.
struct PairSums {
  double weighted = 0, traced = 0;
};
PairSums pair_sums(const PairTerms& terms, std::size_t row, std::size_t first, std::size_t last, const double* x,
                   const double* y, const double* k, const double* inverse);

// sum_cc' W_cc' z_c' z_c over symmetric W (count, count); z_c are 32 contiguous values.
double class_products(const double* z, const double* W, std::size_t count);

// sum_i a_i b_i
double inner_product(const double* a, const double* b, std::size_t count);

}  // namespace lfdcore::detail
