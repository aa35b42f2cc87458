// The vectorised inner loop of the basis functions, apart from Eigen and <cmath>: see basis_kernel.cpp.
#pragma once

#include <cstddef>

namespace lfdcore::detail {

/// row[i] = x psi_i(x) / sum psi (5.2) for `count` functions, a multiple of 8. The exponents are taken relative to the
/// largest, so that the sum is never 0 far from all centres.
void basis_row(double x, const double* centres, const double* widths, std::size_t count, double* row);

}  // namespace lfdcore::detail
