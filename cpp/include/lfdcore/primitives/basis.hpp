// The phase and the basis functions of dynamic movement primitives (Sec. 5.2).
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// The constants of 5.1 and 5.2 (ERRATA F13). Time is normalised: a demonstration lasts from s = 0 to s = 1.
struct DmpConfig {
  int basis_functions = 20;             ///< M
  double stiffness = 25.0;              ///< alpha_y
  double damping = 6.25;                ///< beta_y; critically damped at alpha_y / 4
  double phase_decay = std::log(100.);  ///< alpha_x: x = exp(-alpha_x s)

  bool operator==(const DmpConfig&) const = default;
};

/// Throws std::invalid_argument unless 2 <= M <= 1000, 0 < alpha_y, beta_y <= 1e4 and 0 < alpha_x <= 100.
void validate(const DmpConfig& config);

/// Phases (steps,) of samples evenly spread over a demonstration: exp(-alpha_x k / (steps - 1)), 2 to 1e6 steps.
Eigen::VectorXd phases(int steps, const DmpConfig& config = {});

/// phi(x)^T of 5.2 at phases (T,) in (0, 1], the factor x included -> (T, M). Centres exp(-alpha_x i / (M - 1)), widths
/// 1 / dc^2, the last repeated (ERRATA F13). Throws std::invalid_argument for a phase outside (0, 1].
RowMatrix basis(const Eigen::VectorXd& phase, const DmpConfig& config = {});

}  // namespace lfdcore
