#include "lfdcore/estimation/gaussian_process_likelihood.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "../allocation_count.hpp"
#include "random_regression.hpp"

namespace lfdcore {
namespace {

using test::families;
using test::kernel_of;
using test::random_regression;
using test::RegressionData;
using test::slow_likelihood;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<double> logs(const Kernel& kernel, double noise) {
  std::vector<double> all{std::log(kernel.amplitude)};
  for (const double l : kernel.lengthscales) all.push_back(std::log(l));
  all.push_back(std::log(noise));
  return all;
}

TEST(GaussianProcessLikelihood, is_c_3_for_every_kernel_size_and_dimension) {
  for (const auto family : families)
    for (const int dims : {1, 2, 5})
      for (const int count : {1, 2, 31, 32, 33, 64, 100, 200}) {
        const RegressionData data = random_regression(count, dims, unsigned(count));
        const Kernel kernel = kernel_of(family, dims);
        GaussianProcessLikelihood likelihood(data.X, data.y, data.variances, family);
        const double slow = slow_likelihood(data, kernel, 0.2);
        EXPECT_NEAR(likelihood.evaluate(logs(kernel, 0.2)), slow, 1e-9 * (1 + std::abs(slow))) << count << " " << dims;
      }
}

TEST(GaussianProcessLikelihood, has_the_gradient_that_central_differences_show) {
  for (const auto family : families)
    for (const int count : {1, 40, 100}) {
      const RegressionData data = random_regression(count, 3, 7);
      GaussianProcessLikelihood likelihood(data.X, data.y, data.variances, family);
      std::vector<double> at = logs(kernel_of(family, 3), 0.3), slope(5);
      likelihood.evaluate_with_gradient(at, slope);
      for (std::size_t p = 0; p < at.size(); ++p) {
        std::vector<double> up = at, down = at;
        up[p] += 1e-5, down[p] -= 1e-5;
        const double numeric = (likelihood.evaluate(up) - likelihood.evaluate(down)) / 2e-5;
        EXPECT_NEAR(slope[p], numeric, 1e-5 * (1 + std::abs(numeric))) << "parameter " << p << ", N = " << count;
      }
    }
}

TEST(GaussianProcessLikelihood, gives_up_only_on_what_is_below_the_bound) {
  const RegressionData data = random_regression(150, 2, 3);
  GaussianProcessLikelihood likelihood(data.X, data.y, data.variances, KernelFamily::squared_exponential);
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-3, 2);
  int given_up = 0;
  for (int i = 0; i < 300; ++i) {
    const std::vector<double> at{uniform(generator), uniform(generator), uniform(generator), uniform(generator)};
    const double exact = likelihood.evaluate(at), bound = exact + 40 * uniform(generator);
    const double bounded = likelihood.evaluate(at, bound);
    if (bounded != exact) {
      EXPECT_EQ(bounded, -infinity);
      EXPECT_LT(exact, bound);
      ++given_up;
    }
  }
  EXPECT_GT(given_up, 0);
}

TEST(GaussianProcessLikelihood, does_not_allocate) {
  if (!test::counts_allocations) GTEST_SKIP() << "malloc is the sanitizer's";
  const RegressionData data = random_regression(100, 2, 3);
  GaussianProcessLikelihood likelihood(data.X, data.y, data.variances, KernelFamily::matern_5_2);
  const std::vector<double> at(4, -0.5);
  std::vector<double> slope(4);
  likelihood.evaluate_with_gradient(at, slope);
  const long before = test::allocation_count();
  likelihood.evaluate(at);
  likelihood.evaluate(at, 0.0);
  likelihood.evaluate_with_gradient(at, slope);
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(GaussianProcessLikelihood, is_minus_infinity_where_the_covariance_is_singular_or_no_number) {
  const RowMatrix twice = RowMatrix::Zero(3, 2);
  GaussianProcessLikelihood likelihood(twice, Eigen::VectorXd::Ones(3), Eigen::VectorXd::Zero(3), families[0]);
  std::vector<double> slope(4);
  EXPECT_EQ(likelihood.evaluate(std::vector<double>{0, 0, 0, -infinity}), -infinity);
  EXPECT_EQ(likelihood.evaluate(std::vector<double>{800, 0, 0, 0}), -infinity);
  EXPECT_EQ(likelihood.evaluate(std::vector<double>{0, -800, 0, 0}), -infinity);
  EXPECT_EQ(likelihood.evaluate_with_gradient(std::vector<double>{0, 0, 0, -infinity}, slope), -infinity);
  EXPECT_TRUE(std::isnan(slope[0]));
  EXPECT_THROW(likelihood.evaluate(std::vector<double>{0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(likelihood.evaluate(std::vector<double>{0, 0, NAN, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
