// Radial basis function networks built greedily (App. C.1, Alg. 5 as corrected by ERRATA 45), with a 0 prior.
#pragma once

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

struct RbfNetworkConfig {
  double sigma = 0.3;       ///< standard deviation of every Gaussian, in the inputs' units
  double threshold = 0.01;  ///< stop once the largest SQUARED residual is below this
  int max_centres = 20;     ///< stop at this many basis functions
};

/// Throws std::invalid_argument unless sigma > 0, threshold >= 0 and max_centres >= 1, all finite.
void validate(const RbfNetworkConfig& config);

/// y = sum_j w_j exp(-|x - m_j|^2 / (2 sigma^2)), clipped to [0, 1]. The Gaussian's constant factor of App. C.1 is left
/// to the weights, so an activation is 1 at its centre. Far from every centre y is 0: the strong 0 prior.
struct RbfNetwork {
  RowMatrix centres;        ///< (M, D)
  Eigen::VectorXd weights;  ///< (M,)
  double sigma = 0.3;

  /// Inputs (N, D) -> (N,) in [0, 1]; an input with NaN gives 0. Throws std::invalid_argument for another D.
  Eigen::VectorXd predict(const RowMatrix& inputs) const;
};

/// Alg. 5: the next centre is the training input of the largest squared residual (ties: the first), then all weights
/// are fitted again by least squares. An input that already is a centre, or that would make the fit singular, is
/// skipped; the network is done when none is left. Throws std::invalid_argument for no or non-finite data.
RbfNetwork fit_rbf_network(const RowMatrix& inputs, const Eigen::VectorXd& targets, const RbfNetworkConfig& config);

}  // namespace lfdcore
