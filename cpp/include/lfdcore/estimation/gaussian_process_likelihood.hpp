// The log marginal likelihood of a Gaussian process and its gradient, for optimisers of the hyper-parameters (App.
// C.3).
#pragma once

#include <limits>
#include <memory>
#include <span>

#include "lfdcore/estimation/kernel.hpp"

namespace lfdcore {

/// A function of (log a, log l_1 .. log l_D, log noise). Keeps its workspace: one thread at a time.
class GaussianProcessLikelihood {
 public:
  /// Inputs (N, D), targets (N,), the samples' own noise variances (N,). Throws std::invalid_argument for no,
  /// non-finite or ill-fitting data.
  GaussianProcessLikelihood(const RowMatrix& inputs, const Eigen::VectorXd& targets,
                            const Eigen::VectorXd& noise_variances, KernelFamily family);
  ~GaussianProcessLikelihood();
  GaussianProcessLikelihood(GaussianProcessLikelihood&&) noexcept;
  GaussianProcessLikelihood& operator=(GaussianProcessLikelihood&&) noexcept;

  /// log p(Y | X) with K + diag(var_n + noise^2) (C.3, ERRATA 33); -infinity where that is not positive definite.
  /// Also -infinity, and much sooner, where the result is certain to be below `give_up_below`: an optimiser that only
  /// asks "better than this?" loses nothing. No allocation. Throws std::invalid_argument for a wrong size or NaN.
  double evaluate(std::span<const double> log_parameters,
                  double give_up_below = -std::numeric_limits<double>::infinity());

  /// The likelihood and its derivatives by log_parameters; NaN derivatives where it is -infinity.
  /// No allocation from the second call on.
  double evaluate_with_gradient(std::span<const double> log_parameters, std::span<double> derivatives);

  Eigen::Index size() const;
  Eigen::Index dimensions() const;
  Eigen::Index parameters() const { return dimensions() + 2; }
  KernelFamily family() const { return family_; }

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
  KernelFamily family_;
};

}  // namespace lfdcore
