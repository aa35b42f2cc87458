// A series to align.
#pragma once

#include <random>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore::test {

/// (count, dimensions), with steps of standard deviation 1.
inline RowMatrix walk(int count, int dimensions, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  RowMatrix result = RowMatrix::NullaryExpr(count, dimensions, [&] { return normal(random); });
  for (int t = 1; t < count; ++t) result.row(t) += result.row(t - 1);
  return result;
}

}  // namespace lfdcore::test
