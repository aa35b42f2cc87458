// Derivatives of sampled motions.
#pragma once

#include <Eigen/Core>

#include "lfdcore/primitives/basis.hpp"

namespace lfdcore::detail {

/// F of 5.12, f + alpha_y beta_y g (ERRATA 35), of positions (T >= 3, D) at increasing normalised times. Derivatives
/// are second order inside and at the ends, as NumPy's gradient(values, time, edge_order=2).
Eigen::MatrixXd observed_forcing(const Eigen::MatrixXd& positions, const Eigen::VectorXd& time,
                                 const DmpConfig& config);

/// Throws std::invalid_argument, naming the value, unless all are finite and at most 1e9 in size.
void require_positions(const RowMatrix& positions, const char* name);

}  // namespace lfdcore::detail
