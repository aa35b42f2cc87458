#include "gaussian_kernel.hpp"

#include "../vectorised.hpp"

LFDCORE_VECTOR_MATH(double exp(double));

namespace lfdcore::detail {

LFDCORE_CLONES void weighted_exp(double* values, const double* weights, double scale, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = weights[i] * exp(-values[i] * scale);
}

LFDCORE_CLONES void add_squared_distance(double* values, const double* column, double at, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] += (column[i] - at) * (column[i] - at);
}

}  // namespace lfdcore::detail
