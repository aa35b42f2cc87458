#include "small_products.hpp"

#include <algorithm>

#include "../vectorised.hpp"

namespace lfdcore::detail {

// Tiles of 4 rows by 8 columns stay in registers while the contraction runs.
LFDCORE_CLONES void add_transposed_product(Rows a, Rows b, double* out, std::size_t rows, std::size_t a_columns,
                                           std::size_t b_columns) {
  constexpr std::size_t tile = 4;
  for (std::size_t i = 0; i < a_columns; i += tile) {
    for (std::size_t j = 0; j < b_columns; j += product_lanes) {
      double sums[tile][product_lanes] = {};
      for (std::size_t k = 0; k < rows; ++k) {
        const double* left = a.data + k * a.stride + i;
        const double* right = b.data + k * b.stride + j;
        for (std::size_t r = 0; r < tile; ++r)
          for (std::size_t c = 0; c < product_lanes; ++c) sums[r][c] += left[r] * right[c];
      }
      for (std::size_t r = 0; r < tile; ++r)
        for (std::size_t c = 0; c < product_lanes; ++c) out[(i + r) * b_columns + j + c] += sums[r][c];
    }
  }
}

void transposed_product(Rows a, Rows b, double* out, std::size_t rows, std::size_t a_columns, std::size_t b_columns) {
  std::fill_n(out, a_columns * b_columns, 0.0);
  add_transposed_product(a, b, out, rows, a_columns, b_columns);
}

}  // namespace lfdcore::detail
