// Inputs to learn from.
#pragma once

#include <random>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore::test {

/// (rows, columns), uniform in [-1, 1].
inline RowMatrix random_inputs(int rows, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return RowMatrix::NullaryExpr(rows, columns, [&] { return uniform(generator); });
}

}  // namespace lfdcore::test
