// The vectorised inner loop of the RBF networks, apart from Eigen and <cmath>: see gaussian_kernel.cpp.
#pragma once

#include <cstddef>

namespace lfdcore::detail {

/// values[i] = weights[i] exp(-values[i] * scale)
void weighted_exp(double* values, const double* weights, double scale, std::size_t count);

/// values[i] += (column[i] - at)^2
void add_squared_distance(double* values, const double* column, double at, std::size_t count);

}  // namespace lfdcore::detail
