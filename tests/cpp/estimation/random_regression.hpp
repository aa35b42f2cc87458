// Noisy samples of a function, kernels for them, and their likelihood by a slow and obvious way.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "lfdcore/estimation/kernel.hpp"

namespace lfdcore::test {

struct RegressionData {
  RowMatrix X;
  Eigen::VectorXd y, variances;
};

inline RegressionData random_regression(int count, int dims, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  RegressionData data{RowMatrix::NullaryExpr(count, dims, [&] { return uniform(generator); }), {}, {}};
  data.y = (data.X.rowwise().sum().array() * 3).sin();
  data.variances = Eigen::VectorXd::NullaryExpr(count, [&] { return 0.01 + 0.1 * std::abs(uniform(generator)); });
  return data;
}

inline Kernel kernel_of(KernelFamily family, int dims) {
  return {family, 1.3, Eigen::VectorXd::LinSpaced(dims, 0.4, 0.9)};
}

inline RowMatrix noisy_covariance(const RegressionData& data, const Kernel& kernel, double noise) {
  RowMatrix K = covariance(kernel, data.X, data.X);
  K.diagonal() += data.variances;
  K.diagonal().array() += noise * noise;
  return K;
}

// C.3 by an eigenvalue-free textbook: determinant from Eigen's Cholesky, the inverse multiplied out.
inline double slow_likelihood(const RegressionData& data, const Kernel& kernel, double noise) {
  const Eigen::LLT<Eigen::MatrixXd> factor(noisy_covariance(data, kernel, noise));
  const Eigen::MatrixXd L = factor.matrixL();
  return -0.5 * data.y.dot(factor.solve(data.y)) - L.diagonal().array().log().sum() -
         0.5 * double(data.y.size()) * std::log(2 * std::numbers::pi);
}

inline const KernelFamily families[] = {KernelFamily::squared_exponential, KernelFamily::matern_3_2,
                                        KernelFamily::matern_5_2};

}  // namespace lfdcore::test
