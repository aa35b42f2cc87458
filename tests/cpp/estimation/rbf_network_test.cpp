#include "lfdcore/estimation/rbf_network.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "random_inputs.hpp"

namespace lfdcore {
namespace {

using test::random_inputs;

// Alg. 5 with ERRATA 45, every fit from scratch; an input that is a centre already is passed over.
RbfNetwork slow_fit(const RowMatrix& X, const Eigen::VectorXd& Y, const RbfNetworkConfig& config) {
  std::vector<Eigen::Index> picked;
  Eigen::VectorXd estimate = Eigen::VectorXd::Zero(Y.size()), weights;
  Eigen::MatrixXd A(Y.size(), 0);
  while (static_cast<int>(picked.size()) < config.max_centres) {
    Eigen::ArrayXd error = (estimate - Y).array().square();
    if (error.maxCoeff() < config.threshold) break;
    for (const auto i : picked) error(i) = -1;
    Eigen::Index worst = 0;
    error.maxCoeff(&worst);
    picked.push_back(worst);
    A.conservativeResize(Eigen::NoChange, A.cols() + 1);
    for (Eigen::Index i = 0; i < Y.size(); ++i)
      A(i, A.cols() - 1) = std::exp(-(X.row(i) - X.row(worst)).squaredNorm() / (2 * config.sigma * config.sigma));
    weights = A.colPivHouseholderQr().solve(Y);
    estimate = A * weights;
  }
  RbfNetwork network{RowMatrix(picked.size(), X.cols()), weights, config.sigma};
  for (std::size_t j = 0; j < picked.size(); ++j) network.centres.row(j) = X.row(picked[j]);
  return network;
}

TEST(FitRbfNetwork, agrees_with_alg_5_solved_from_scratch_at_every_step) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RowMatrix X = random_inputs(60, 2, seed);
    const Eigen::VectorXd Y = (X.col(0).array() * 3).sin() * 0.5 + X.col(1).array() * 0.5;
    const RbfNetworkConfig config{0.4, 0.01, 12};
    const auto fast = fit_rbf_network(X, Y, config), slow = slow_fit(X, Y, config);
    ASSERT_EQ(fast.centres, slow.centres) << "seed " << seed;
    EXPECT_LT((fast.weights - slow.weights).cwiseAbs().maxCoeff(), 1e-6 * slow.weights.cwiseAbs().maxCoeff());
  }
}

TEST(FitRbfNetwork, leaves_no_squared_residual_above_the_threshold_if_centres_suffice) {
  const RowMatrix X = random_inputs(200, 3, 7);
  const auto network = fit_rbf_network(X, Eigen::VectorXd::Ones(200), {0.3, 0.01, 200});
  EXPECT_GE(network.predict(X).minCoeff(), 0.9);
}

TEST(FitRbfNetwork, takes_the_threshold_as_a_square_from_the_first_step_on) {
  const RowMatrix X = RowMatrix::Zero(1, 1);
  const Eigen::VectorXd Y = Eigen::VectorXd::Constant(1, 0.5);  // sup|Y| = .5 but its square is .25
  EXPECT_EQ(fit_rbf_network(X, Y, {0.3, 0.3, 20}).weights.size(), 0);
  EXPECT_EQ(fit_rbf_network(X, Y, {0.3, 0.2, 20}).weights.size(), 1);
}

TEST(FitRbfNetwork, skips_duplicates_with_contradicting_targets_and_ends) {
  RowMatrix X = RowMatrix::Zero(6, 2);
  X.row(5) << 1, 1;
  Eigen::VectorXd Y(6);
  Y << 0, 1, 0, 1, 0, 1;
  const auto network = fit_rbf_network(X, Y, {0.3, 0.01, 20});
  EXPECT_EQ(network.weights.size(), 2);
  EXPECT_TRUE(network.weights.allFinite());
  EXPECT_NEAR(network.predict(RowMatrix::Zero(1, 2))(0), 0.4, 1e-3);  // least squares: their mean
}

TEST(FitRbfNetwork, has_a_zero_prior_and_stays_in_0_to_1) {
  const auto network = fit_rbf_network(random_inputs(50, 2, 1), Eigen::VectorXd::Ones(50), {0.3, 0.01, 20});
  const Eigen::VectorXd near = network.predict(random_inputs(2000, 2, 2) * 1.5);
  EXPECT_GE(near.minCoeff(), 0.0);
  EXPECT_LE(near.maxCoeff(), 1.0);
  EXPECT_LT(network.predict(RowMatrix::Constant(1, 2, 5.0))(0), 1e-12);
}

TEST(FitRbfNetwork, refuses_no_data_nan_and_bad_configs) {
  const RowMatrix X = RowMatrix::Zero(2, 2);
  const Eigen::VectorXd Y = Eigen::VectorXd::Ones(2);
  EXPECT_THROW(fit_rbf_network(RowMatrix(0, 2), Eigen::VectorXd(0), {}), std::invalid_argument);
  EXPECT_THROW(fit_rbf_network(X, Eigen::VectorXd::Ones(3), {}), std::invalid_argument);
  EXPECT_THROW(fit_rbf_network(RowMatrix::Constant(2, 2, std::nan("")), Y, {}), std::invalid_argument);
  EXPECT_THROW(fit_rbf_network(X, Y, {0.0, 0.01, 20}), std::invalid_argument);
  EXPECT_THROW(fit_rbf_network(X, Y, {0.3, std::nan(""), 20}), std::invalid_argument);
  EXPECT_THROW(fit_rbf_network(X, Y, {0.3, 0.01, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
