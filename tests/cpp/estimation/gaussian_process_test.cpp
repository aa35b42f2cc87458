#include "lfdcore/estimation/gaussian_process.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "random_regression.hpp"

namespace lfdcore {
namespace {

using test::families;
using test::kernel_of;
using test::noisy_covariance;
using test::random_regression;
using test::RegressionData;
using test::slow_likelihood;

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(GaussianProcess, conditions_as_brute_force_does_for_few_and_many_queries) {
  for (const auto family : families)
    for (const int count : {1, 33, 100}) {
      const RegressionData data = random_regression(count, 2, 11);
      const Kernel kernel = kernel_of(family, 2);
      const GaussianProcess process(data.X, data.y, data.variances, kernel, 0.1);
      const Eigen::MatrixXd inverse = Eigen::MatrixXd(noisy_covariance(data, kernel, 0.1)).inverse();
      for (const int asked : {1, 4, 5, 32, 70}) {
        const RowMatrix queries = random_regression(asked, 2, 12).X * 1.5;
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
  const RegressionData data = random_regression(50, 2, 2);
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
