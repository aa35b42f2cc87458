#include "lfdcore/estimation/sparse_subset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "lfdcore/estimation/kernel.hpp"
#include "random_actions.hpp"

namespace lfdcore {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::ActionData;
using test::random_actions;

// The argument that makes the selection incremental, on A itself.
void expect_largest_gains(const ActionData& data, int size) {
  const int N = static_cast<int>(data.states.rows());
  const auto selected = select_subset(data.states, data.goals, data.actions, data.kernels, size, N);
  std::vector<bool> taken(N, false);
  std::vector<MatrixXd> A;
  std::vector<VectorXd> b;
  std::vector<double> weights;
  for (int a = 0; a < 2; ++a) {
    const ActionKernel& kernel = data.kernels[a];
    RowMatrix inputs(N, 5);
    inputs << data.states, data.goals;
    VectorXd scales(5);
    scales << kernel.state_lengthscales, kernel.goal_lengthscales;
    const MatrixXd K = covariance({KernelFamily::squared_exponential, kernel.amplitude, scales}, inputs, inputs);
    A.push_back(kernel.noise * kernel.noise * K + K * K);
    b.push_back(K * data.actions.col(a));
    weights.push_back(1 / (data.actions.col(a).array() - data.actions.col(a).mean()).square().mean());
  }
  for (int round = 0; round < size; ++round) {
    VectorXd gain = VectorXd::Zero(N);
    for (int a = 0; a < 2; ++a) {
      VectorXd left = A[a].diagonal();
      for (int i = 0; i < N; ++i)
        if (!taken[i] && left(i) > 0) gain(i) += weights[a] * b[a](i) * b[a](i) / (2 * left(i));
    }
    const double best = gain.maxCoeff();
    const auto i = selected[round];
    ASSERT_FALSE(taken[i]);
    if (best < 1e-7) {        // rounding decides from here on
      EXPECT_GT(round, 100);  // by now samples have been settled
      break;
    }
    ASSERT_GT(gain(i), best * (1 - 1e-6)) << "round " << round;
    taken[i] = true;
    for (int a = 0; a < 2; ++a) {  // eliminate the sample
      const VectorXd column = A[a].col(i) / std::sqrt(A[a](i, i));
      b[a] -= column * (b[a](i) / std::sqrt(A[a](i, i)));
      A[a] -= column * column.transpose();
    }
  }
}

TEST(SelectSubset, picks_the_largest_gain_of_all_samples_through_several_settlings) {
  expect_largest_gains(random_actions(230), 210);
}

TEST(SelectSubset, leaves_out_only_what_is_too_far_away_to_matter) {
  ActionData data = random_actions(230);
  for (int n = 0; n < 230; ++n) data.states(n, 0) += 0.1 * n;  // 32 samples are as wide as a few length-scales
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  data.actions = RowMatrix::NullaryExpr(230, 2, [&] { return normal(generator); });  // so that all samples gain
  expect_largest_gains(data, 210);
}

}  // namespace
}  // namespace lfdcore
