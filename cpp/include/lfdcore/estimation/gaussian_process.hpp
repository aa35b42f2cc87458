// Gaussian process regression with a noise variance for every sample (App. C.3, ERRATA 33): conditioning, prediction.
#pragma once

#include <memory>
#include <span>

#include "lfdcore/estimation/kernel.hpp"

namespace lfdcore {

/// Mean and variance of each query's Gaussian.
struct GaussianMoments {
  Eigen::VectorXd mean;      ///< (M,)
  Eigen::VectorXd variance;  ///< (M,), >= 0
};

/// y_n = f(x_n) + e_n, f ~ GP(0, k), e_n ~ N(0, var_n + noise^2): conditioned once, then asked as often as wanted.
/// Immutable, so copies share their data and any thread may ask.
class GaussianProcess {
 public:
  /// Inputs (N, D), targets (N,), the samples' own noise variances (N,); `noise` is a standard deviation.
  /// Throws std::invalid_argument for no, non-finite or ill-fitting data, for bad parameters, and if the covariance is
  /// not numerically positive definite (duplicate inputs, or far too long length-scales, without noise).
  GaussianProcess(const RowMatrix& inputs, const Eigen::VectorXd& targets, const Eigen::VectorXd& noise_variances,
                  Kernel kernel, double noise);

  /// Queries (M, D) -> mean and variance of f there (C.4), or with `with_noise` of y: noise^2 added.
  /// A query with NaN or infinity gives NaN. Throws std::invalid_argument for another D.
  GaussianMoments predict(const RowMatrix& queries, bool with_noise = false) const;

  /// The same for one query (D,), without an allocation if `scratch` holds scratch_size() doubles.
  void predict(std::span<const double> query, std::span<double> scratch, double& mean, double& variance) const;
  std::size_t scratch_size() const;

  Eigen::Index size() const;
  Eigen::Index dimensions() const;
  const Kernel& kernel() const;
  double noise() const;
  double log_likelihood() const;  ///< C.3 of the data it was conditioned on

 private:
  struct Conditioned;
  std::shared_ptr<const Conditioned> data_;
};

}  // namespace lfdcore
