// What series of samples must be. Private to primitives/.
#pragma once

#include <string>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore::detail {

/// Samples whose values are larger are refused: their squares would leave the range of double.
inline constexpr double largest_sample = 1e100;

/// Throws std::invalid_argument, naming the series and the first bad row, unless (T, D) has T, D >= 1 and all values
/// are finite and within +-largest_sample.
void require_series(const std::string& name, const RowMatrix& series);

/// Throws std::invalid_argument for an infinite or huge value; NaN stands for what was not seen.
void require_sample(const double* sample, int dimensions);

}  // namespace lfdcore::detail
