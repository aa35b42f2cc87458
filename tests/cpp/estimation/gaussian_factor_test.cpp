#include "../../../cpp/src/estimation/gaussian_factor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random_regression.hpp"

namespace lfdcore {
namespace {

using test::families;
using test::kernel_of;
using test::random_regression;
using test::RegressionData;

TEST(GaussianFactor, gives_the_same_likelihood_and_gradient_with_every_instruction_set) {
  const RegressionData data = random_regression(75, 2, 1);
  for (const auto family : families) {
    const Kernel kernel = kernel_of(family, 2);
    Eigen::VectorXd first(4), other(4);
    double value = 0;
    for (const auto& kernels : detail::block_kernels_of_this_cpu()) {
      detail::GaussianFactor factor(data.X, data.y, data.variances, kernels);
      const double here = factor.factor({family, kernel.amplitude, {kernel.lengthscales.data(), 2}, 0.2});
      factor.invert();
      factor.gradient({other.data(), 4});
      if (value == 0) value = here, first = other;
      EXPECT_NEAR(here, value, 1e-10 * std::abs(value));
      EXPECT_LT((other - first).cwiseAbs().maxCoeff(), 1e-9 * first.cwiseAbs().maxCoeff());
    }
  }
}

}  // namespace
}  // namespace lfdcore
