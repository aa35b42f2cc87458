#include "lfdcore/estimation/rbf_network_bank.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <stdexcept>
#include <vector>

#include "random_inputs.hpp"

namespace lfdcore {
namespace {

using test::random_inputs;

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
