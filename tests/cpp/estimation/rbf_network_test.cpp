#include "lfdcore/estimation/rbf_network.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>
#include <stdexcept>
#include <vector>

#include "lfdcore/estimation/rbf_network_bank.hpp"

namespace lfdcore {
namespace {

RowMatrix random_inputs(int rows, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return RowMatrix::NullaryExpr(rows, columns, [&] { return uniform(generator); });
}

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

RbfNetworkBank example_bank() {
  const RowMatrix X = random_inputs(3000, 3, 3);
  std::vector<std::int32_t> keys(3000);
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = static_cast<std::int32_t>((i * 7919) % 701) * 3;
  return RbfNetworkBank::fit(X, keys, {});
}

TEST(RbfNetworkBank, agrees_with_its_networks_asked_one_by_one) {
  const auto bank = example_bank();
  const RowMatrix own = random_inputs(static_cast<int>(bank.size()), 1, 4);
  const std::vector<double> shared{0.2, -0.4};
  std::vector<double> all(bank.size());
  bank.predict(shared, {own.data(), bank.size()}, all);
  for (std::size_t c = 0; c < bank.size(); ++c) {
    const int from = bank.offsets()[c], count = bank.offsets()[c + 1] - from;
    const RbfNetwork one{bank.centres().middleRows(from, count), bank.weights().segment(from, count), bank.sigma()};
    const RowMatrix input = (RowMatrix(1, 3) << shared[0], shared[1], own(c, 0)).finished();
    ASSERT_NEAR(all[c], one.predict(input)(0), 1e-12);
  }
}

TEST(RbfNetworkBank, gives_0_to_a_network_whose_own_input_is_unknown) {
  const auto bank = example_bank();
  std::vector<double> own(bank.size(), 0.0), all(bank.size());
  own[5] = std::nan("");
  own[6] = INFINITY;
  bank.predict(std::vector<double>{0, 0}, own, all);
  EXPECT_EQ(all[5], 0.0);
  EXPECT_EQ(all[6], 0.0);
}

TEST(RbfNetworkBank, refuses_arrays_that_do_not_fit) {
  const RowMatrix centres = RowMatrix::Zero(2, 3);
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(2);
  EXPECT_NO_THROW(RbfNetworkBank({4, 9}, {0, 1, 2}, centres, weights, 0.3));
  EXPECT_THROW(RbfNetworkBank({9, 4}, {0, 1, 2}, centres, weights, 0.3), std::invalid_argument);
  EXPECT_THROW(RbfNetworkBank({4, 9}, {0, 3, 2}, centres, weights, 0.3), std::invalid_argument);
  EXPECT_THROW(RbfNetworkBank({4, 9}, {0, 1}, centres, weights, 0.3), std::invalid_argument);
  EXPECT_THROW(RbfNetworkBank({4, 9}, {0, 1, 2}, centres, Eigen::VectorXd::Ones(3), 0.3), std::invalid_argument);
  EXPECT_THROW(RbfNetworkBank({4, 9}, {0, 1, 2}, centres, weights, 0.0), std::invalid_argument);
}

TEST(RbfNetworkBank, refuses_queries_of_the_wrong_size_and_a_shared_nan) {
  const auto bank = example_bank();
  std::vector<double> own(bank.size(), 0.0), all(bank.size());
  EXPECT_THROW(bank.predict(std::vector<double>{0}, own, all), std::invalid_argument);
  EXPECT_THROW(bank.predict(std::vector<double>{0, 0, 0, 0}, own, all), std::invalid_argument);
  EXPECT_THROW(bank.predict(std::vector<double>{0, std::nan("")}, own, all), std::invalid_argument);
  EXPECT_THROW(bank.predict(std::vector<double>{0, 0}, own, std::span(all).first(3)), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
