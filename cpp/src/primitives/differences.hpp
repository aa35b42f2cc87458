// Derivatives of sampled motions.
#pragma once

#include <Eigen/Core>

#include "lfdcore/primitives/basis.hpp"

namespace lfdcore::detail {

/// d values / d time, second order inside and at the ends, for samples (T >= 3,) at increasing times, as NumPy's
/// gradient(values, time, edge_order=2).
Eigen::VectorXd derivative(const Eigen::Ref<const Eigen::VectorXd>& values,
                           const Eigen::Ref<const Eigen::VectorXd>& time);

/// F of 5.12, f + alpha_y beta_y g (ERRATA 35), of positions (T >= 3,) at increasing normalised times.
Eigen::VectorXd observed_forcing(const Eigen::Ref<const Eigen::VectorXd>& positions,
                                 const Eigen::Ref<const Eigen::VectorXd>& time, const DmpConfig& config);

/// Throws std::invalid_argument, naming the value, unless all are finite and at most 1e9 in size.
void require_positions(const Series& positions, const char* name);

}  // namespace lfdcore::detail
