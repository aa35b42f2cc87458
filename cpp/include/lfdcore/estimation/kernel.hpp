// Stationary covariance functions with a length-scale for every input dimension (App. C.3.1).
#pragma once

#include <Eigen/Core>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

enum class KernelFamily {
  squared_exponential,  ///< a^2 exp(-r^2 / 2), C.5
  matern_3_2,           ///< a^2 (1 + sqrt(3) r) exp(-sqrt(3) r), C.6 with nu = 1.5
  matern_5_2,           ///< a^2 (1 + sqrt(5) r + 5 r^2 / 3) exp(-sqrt(5) r), C.6 with nu = 2.5
};

/// k(x, x') over r^2 = sum_d ((x_d - x'_d) / l_d)^2. C.5's H is diag(l_d^2), C.6's rho is absorbed into l_d.
struct Kernel {
  KernelFamily family = KernelFamily::squared_exponential;
  double amplitude = 1;          ///< a, the standard deviation of f, in the targets' unit
  Eigen::VectorXd lengthscales;  ///< (D,), in the inputs' units
};

/// Throws std::invalid_argument unless there is at least one length-scale and all parameters are > 0 and finite.
void validate(const Kernel& kernel);

/// Inputs (N, D) and (M, D) -> (N, M). Throws std::invalid_argument for another D or a bad kernel; NaN gives NaN.
RowMatrix covariance(const Kernel& kernel, const RowMatrix& a, const RowMatrix& b);

}  // namespace lfdcore
