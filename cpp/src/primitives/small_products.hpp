// Products of small dense matrices for the instruction set at hand, without Eigen (whose kernels are fixed at compile
// time, and so to the baseline).
#pragma once

#include <cstddef>

namespace lfdcore::detail {

constexpr std::size_t product_lanes = 8;

/// The next multiple of the lanes: columns are padded with zeros up to it.
constexpr std::size_t padded(std::size_t columns) {
  return (columns + product_lanes - 1) / product_lanes * product_lanes;
}

/// A row-major matrix in someone else's memory; `stride` doubles from row to row.
struct Rows {
  const double* data;
  std::size_t stride;
};

/// out (a_columns, b_columns), stride b_columns, = A^T B over `rows` rows of both. Columns are multiples of the lanes.
void transposed_product(Rows a, Rows b, double* out, std::size_t rows, std::size_t a_columns, std::size_t b_columns);

/// out += A^T B, otherwise the same.
void add_transposed_product(Rows a, Rows b, double* out, std::size_t rows, std::size_t a_columns,
                            std::size_t b_columns);

}  // namespace lfdcore::detail
