#include "lfdcore/estimation/gaussian_process.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "../../../cpp/src/estimation/gaussian_factor.hpp"
#include "../allocation_count.hpp"
#include "lfdcore/estimation/gaussian_process_likelihood.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Data {
  RowMatrix X;
  Eigen::VectorXd y, variances;
};

Data random_data(int count, int dims, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Data data{RowMatrix::NullaryExpr(count, dims, [&] { return uniform(generator); }), {}, {}};
  data.y = (data.X.rowwise().sum().array() * 3).sin();
  data.variances = Eigen::VectorXd::NullaryExpr(count, [&] { return 0.01 + 0.1 * std::abs(uniform(generator)); });
  return data;
}

Kernel kernel_of(KernelFamily family, int dims) { return {family, 1.3, Eigen::VectorXd::LinSpaced(dims, 0.4, 0.9)}; }

std::vector<double> logs(const Kernel& kernel, double noise) {
  std::vector<double> all{std::log(kernel.amplitude)};
  for (const double l : kernel.lengthscales) all.push_back(std::log(l));
  all.push_back(std::log(noise));
  return all;
}

RowMatrix noisy_covariance(const Data& data, const Kernel& kernel, double noise) {
  RowMatrix K = covariance(kernel, data.X, data.X);
  K.diagonal() += data.variances;
  K.diagonal().array() += noise * noise;
  return K;
}

// C.3 by an eigenvalue-free textbook: determinant from Eigen's Cholesky, the inverse multiplied out.
double slow_likelihood(const Data& data, const Kernel& kernel, double noise) {
  const Eigen::LLT<Eigen::MatrixXd> factor(noisy_covariance(data, kernel, noise));
  const Eigen::MatrixXd L = factor.matrixL();
  return -0.5 * data.y.dot(factor.solve(data.y)) - L.diagonal().array().log().sum() -
         0.5 * double(data.y.size()) * std::log(2 * std::numbers::pi);
}

const KernelFamily families[] = {KernelFamily::squared_exponential, KernelFamily::matern_3_2, KernelFamily::matern_5_2};

TEST(GaussianProcessLikelihood, is_c_3_for_every_kernel_size_and_dimension) {
  for (const auto family : families)
    for (const int dims : {1, 2, 5})
      for (const int count : {1, 2, 31, 32, 33, 64, 100, 200}) {
        const Data data = random_data(count, dims, unsigned(count));
        const Kernel kernel = kernel_of(family, dims);
        GaussianProcessLikelihood likelihood(data.X, data.y, data.variances, family);
        const double slow = slow_likelihood(data, kernel, 0.2);
        EXPECT_NEAR(likelihood.evaluate(logs(kernel, 0.2)), slow, 1e-9 * (1 + std::abs(slow))) << count << " " << dims;
      }
}

TEST(GaussianFactor, gives_the_same_likelihood_and_gradient_with_every_instruction_set) {
  const Data data = random_data(75, 2, 1);
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

TEST(GaussianProcessLikelihood, has_the_gradient_that_central_differences_show) {
  for (const auto family : families)
    for (const int count : {1, 40, 100}) {
      const Data data = random_data(count, 3, 7);
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
  const Data data = random_data(150, 2, 3);
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
  const Data data = random_data(100, 2, 3);
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

TEST(GaussianProcess, conditions_as_brute_force_does_for_few_and_many_queries) {
  for (const auto family : families)
    for (const int count : {1, 33, 100}) {
      const Data data = random_data(count, 2, 11);
      const Kernel kernel = kernel_of(family, 2);
      const GaussianProcess process(data.X, data.y, data.variances, kernel, 0.1);
      const Eigen::MatrixXd inverse = Eigen::MatrixXd(noisy_covariance(data, kernel, 0.1)).inverse();
      for (const int asked : {1, 4, 5, 32, 70}) {
        const RowMatrix queries = random_data(asked, 2, 12).X * 1.5;
        const Eigen::MatrixXd across = covariance(kernel, queries, data.X);
        const Eigen::VectorXd explained = (across * inverse).cwiseProduct(across).rowwise().sum();
        const auto moments = process.predict(queries);
        EXPECT_LT((moments.mean - across * inverse * data.y).cwiseAbs().maxCoeff(), 1e-10);
        EXPECT_LT((moments.variance.array() - (1.69 - explained.array())).abs().maxCoeff(), 1e-10);
        EXPECT_LT((process.predict(queries, true).variance - moments.variance).array().maxCoeff(), 0.01 + 1e-15);
      }
      EXPECT_NEAR(process.log_likelihood(), slow_likelihood(data, kernel, 0.1), 1e-9 * count);
    }
}

TEST(GaussianProcess, returns_to_the_prior_far_away_and_to_nan_for_what_is_no_place) {
  const Data data = random_data(50, 2, 2);
  for (const auto family : families) {
    const GaussianProcess process(data.X, data.y, data.variances, kernel_of(family, 2), 0.1);
    for (const int repeat : {1, 40}) {
      RowMatrix queries(3 * repeat, 2);
      for (int i = 0; i < repeat; ++i) queries.middleRows(3 * i, 3) << 1e200, -1e9, NAN, 0, 0, infinity;
      const auto moments = process.predict(queries);
      EXPECT_NEAR(moments.mean(0), 0, 1e-100);
      EXPECT_DOUBLE_EQ(moments.variance(0), 1.69);
      EXPECT_TRUE(std::isnan(moments.mean(1)) && std::isnan(moments.variance(1)));
      EXPECT_TRUE(std::isnan(moments.mean(2)) && std::isnan(moments.variance(2)));
    }
  }
}

TEST(GaussianProcess, says_which_sample_makes_the_covariance_singular) {
  RowMatrix X(3, 1);
  X << 0, 1, 1;
  const Eigen::VectorXd y = Eigen::VectorXd::Ones(3), none = Eigen::VectorXd::Zero(3);
  try {
    GaussianProcess(X, y, none, {families[0], 1, Eigen::VectorXd::Ones(1)}, 0);
    FAIL() << "a singular covariance was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("not positive definite at sample"), std::string::npos);
  }
  EXPECT_NO_THROW(GaussianProcess(X, y, none, {families[0], 1, Eigen::VectorXd::Ones(1)}, 0.01));
}

}  // namespace
}  // namespace lfdcore
