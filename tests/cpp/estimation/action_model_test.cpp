#include "lfdcore/estimation/action_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "../../../cpp/src/estimation/packed_triangle.hpp"
#include "../allocation_count.hpp"
#include "lfdcore/estimation/intention_filter.hpp"
#include "lfdcore/estimation/kernel.hpp"
#include "lfdcore/estimation/sparse_subset.hpp"

namespace lfdcore {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Data {
  RowMatrix states, goals, actions;
  std::vector<ActionKernel> kernels;
};

VectorXd values(std::initializer_list<double> list) {
  return Eigen::Map<const VectorXd>(list.begin(), static_cast<Eigen::Index>(list.size()));
}

// `jitter` moves each sample's goal by so much: 0 leaves four goals.
Data random_data(int count, double jitter = 0) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto draw = [&] { return uniform(generator); };
  const RowMatrix places = RowMatrix::NullaryExpr(4, 2, draw) * 3;
  Data data{RowMatrix::NullaryExpr(count, 3, draw), RowMatrix(count, 2), RowMatrix(count, 2), {}};
  for (int n = 0; n < count; ++n)
    data.goals.row(n) = places.row((n * 7) % 4) + jitter * RowMatrix::NullaryExpr(1, 2, draw);
  data.actions.col(0) = (data.states.col(0) + data.goals.col(0)).array().sin() + 0.1 * draw();
  data.actions.col(1) = (data.states.col(1).cwiseProduct(data.goals.col(1))).array().cos() + 0.1 * draw();
  data.kernels = {{1.2, values({0.7, 0.8, 0.9}), values({1.5, 2}), 0.2},
                  {0.8, values({0.5, 1, 0.9}), values({2, 1.1}), 0.3}};
  return data;
}

Belief belief() {
  Belief made{GoalVector(2), GoalMatrix(2, 2)};
  made.mean << 0.3, -0.4;
  made.covariance << 1, 0.3, 0.3, 0.5;
  return made;
}

const std::vector<double> state = {0.1, 0.2, -0.3};

ActionMoments moments(const ActionModel& model, const Belief& of = belief()) {
  std::vector<double> scratch(model.scratch_size());
  return model.moments(state, of, scratch);
}

// The section's formulas as printed, with ERRATA 1, 2 and 4, element by element.
ActionMoments literal_moments(const Data& data, const Belief& of) {
  const Eigen::Index N = data.states.rows();
  const Eigen::Map<const Eigen::RowVectorXd> x(state.data(), 3);
  const MatrixXd Sigma = of.covariance, I = MatrixXd::Identity(2, 2);
  const VectorXd mu = of.mean;
  std::vector<MatrixXd> inverse, H;
  std::vector<VectorXd> beta, k;
  ActionMoments made{ActionVector(2), ActionMatrix(2, 2), CrossMatrix(2, 2)};
  for (int a = 0; a < 2; ++a) {
    const ActionKernel& kernel = data.kernels[std::size_t(a)];
    const double variance = kernel.amplitude * kernel.amplitude;
    MatrixXd K(N, N);
    VectorXd near(N);
    for (Eigen::Index i = 0; i < N; ++i) {
      const auto distance = [&](const Eigen::RowVectorXd& other) {
        return (data.states.row(i) - other).cwiseQuotient(kernel.state_lengthscales.transpose()).squaredNorm();
      };
      near(i) = std::exp(-0.5 * distance(x));
      for (Eigen::Index j = 0; j < N; ++j)
        K(i, j) = variance * std::exp(-0.5 * distance(data.states.row(j)) -
                                      0.5 * (data.goals.row(i) - data.goals.row(j))
                                                .cwiseQuotient(kernel.goal_lengthscales.transpose())
                                                .squaredNorm());
    }
    K.diagonal().array() += kernel.noise * kernel.noise;
    inverse.push_back(K.inverse());
    H.push_back(kernel.goal_lengthscales.cwiseAbs2().asDiagonal());
    beta.push_back(inverse.back() * data.actions.col(a));
    k.push_back(near);
    double m = 0;
    VectorXd pull = VectorXd::Zero(2);
    for (Eigen::Index i = 0; i < N; ++i) {
      const VectorXd u = data.goals.row(i).transpose() - mu;
      const double q = variance / std::sqrt((Sigma * H[a].inverse() + I).determinant()) * near(i) *
                       std::exp(-0.5 * u.dot((Sigma + H[a]).inverse() * u));
      m += beta[a](i) * q;
      pull += beta[a](i) * q * u;
    }
    made.mean(a) = m;
    made.cross_covariance.col(a) = Sigma * (Sigma + H[a]).inverse() * pull;
  }
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) {
      const MatrixXd both = (H[a] + H[b]).inverse(), harmonic = (H[a].inverse() + H[b].inverse()).inverse();
      const MatrixXd R = (harmonic + Sigma).inverse();
      const double alpha = data.kernels[a].amplitude * data.kernels[b].amplitude;
      const double scale = alpha * alpha / std::sqrt((harmonic.inverse() * Sigma + I).determinant());
      double sum = 0, trace = 0;
      for (Eigen::Index i = 0; i < N; ++i)
        for (Eigen::Index j = 0; j < N; ++j) {
          const VectorXd gi = data.goals.row(i), gj = data.goals.row(j);
          const VectorXd apart = gi - gj, middle = H[b] * both * gi + H[a] * both * gj - mu;
          const double Q =
              scale * k[a](i) * k[b](j) * std::exp(-0.5 * apart.dot(both * apart) - 0.5 * middle.dot(R * middle));
          sum += beta[a](i) * Q * beta[b](j);
          trace += inverse[a](i, j) * Q;
        }
      made.covariance(a, b) = sum - made.mean(a) * made.mean(b);
      if (a == b) made.covariance(a, a) += alpha - trace + std::pow(data.kernels[a].noise, 2);
    }
  return made;
}

double difference(const ActionMoments& a, const ActionMoments& b) {
  return std::max({(a.mean - b.mean).cwiseAbs().maxCoeff(), (a.covariance - b.covariance).cwiseAbs().maxCoeff(),
                   (a.cross_covariance - b.cross_covariance).cwiseAbs().maxCoeff()});
}

TEST(ActionModel, has_the_sections_moments_with_shared_and_with_own_goals) {
  for (const double jitter : {0.0, 0.3})
    for (const int count : {1, 5, 32, 33, 100, 170}) {
      const Data data = random_data(count, jitter);
      const ActionModel model(data.states, data.goals, data.actions, data.kernels);
      EXPECT_LT(difference(moments(model), literal_moments(data, belief())), 1e-11) << count << " " << jitter;
    }
}

TEST(ActionModel, takes_the_fast_path_where_goals_are_shared_and_agrees_with_the_general_one) {
  const Data shared = random_data(200), apart = random_data(200, 1e-13);
  const ActionModel fast(shared.states, shared.goals, shared.actions, shared.kernels);
  const ActionModel general(apart.states, apart.goals, shared.actions, apart.kernels);
  EXPECT_EQ(fast.shared_goals(), 4);
  EXPECT_EQ(general.shared_goals(), 0);
  EXPECT_LT(difference(moments(fast), moments(general)), 1e-10);
}

TEST(ActionModel, projected_on_all_samples_is_the_full_one_on_both_paths) {
  for (const double jitter : {0.0, 0.3}) {
    const Data data = random_data(80, jitter);
    std::vector<std::int64_t> all(80);
    std::iota(all.rbegin(), all.rend(), 0);
    const ActionModel full(data.states, data.goals, data.actions, data.kernels);
    for (const bool projected : {true, false}) {
      const ActionModel same(data.states, data.goals, data.actions, data.kernels, &all, projected);
      EXPECT_LT(difference(moments(full), moments(same)), 1e-8) << jitter << " " << projected;
    }
  }
}

TEST(ActionModel, leaves_unread_what_is_too_far_away_to_matter) {
  Data data = random_data(320);
  for (int n = 0; n < 320; ++n) data.states(n, 0) += n;  // most of the samples are far from any one state
  const ActionModel model(data.states, data.goals, data.actions, data.kernels);
  EXPECT_LT(difference(moments(model), literal_moments(data, belief())), 1e-11);
}

TEST(IntentionFilter, does_not_allocate) {
  if (!test::counts_allocations) GTEST_SKIP() << "malloc is the sanitizer's";
  for (const double jitter : {0.0, 0.3}) {
    const Data data = random_data(100, jitter);
    IntentionFilter filter(ActionModel(data.states, data.goals, data.actions, data.kernels), belief(), 0.01);
    const std::vector<double> action = {0.3, 0.2};
    filter.update(state, action);
    const long before = test::allocation_count();
    filter.update(state, action);
    filter.reset();
    filter.update(state, action);
    EXPECT_EQ(test::allocation_count(), before) << jitter;
  }
}

TEST(PackedTriangle, is_factorised_and_inverted_as_eigen_does) {
  const auto kernels = detail::block_kernels_of_this_cpu().back();
  for (const int blocks : {1, 3, 4, 5, 9}) {
    const int N = blocks * detail::lanes;
    std::mt19937 generator(3);
    std::normal_distribution<double> normal;
    const MatrixXd half = MatrixXd::NullaryExpr(N, N, [&] { return normal(generator); });
    const MatrixXd A = half * half.transpose() / N + MatrixXd::Identity(N, N);
    detail::PackedTriangle triangle(blocks);
    using Block = Eigen::Map<Eigen::Matrix<double, detail::lanes, detail::lanes>>;
    const auto fill = [&](const MatrixXd& from) {
      for (int row = 0; row < blocks; ++row)
        for (int column = 0; column <= row; ++column)
          Block(triangle.block(row, column)) = from.block<32, 32>(row * 32, column * 32);
    };
    const auto error = [&](const MatrixXd& to) {
      double largest = 0;
      for (int row = 0; row < blocks; ++row)
        for (int column = 0; column <= row; ++column) {
          const MatrixXd apart = Block(triangle.block(row, column)) - to.block<32, 32>(row * 32, column * 32);
          largest = std::max(largest, apart.cwiseAbs().maxCoeff());
        }
      return largest;
    };
    fill(A);
    const MatrixXd L = A.llt().matrixL();
    EXPECT_EQ(detail::factor(triangle, kernels), -1);
    EXPECT_LT(error(L), 1e-12);
    detail::invert(triangle, kernels);
    detail::transpose_blocks(triangle);
    EXPECT_LT(error(L.inverse()), 1e-12);
    detail::transpose_blocks(triangle);
    detail::gram(triangle, kernels);
    EXPECT_LT(error(A.inverse()), 1e-12);
    MatrixXd singular = A;
    singular.row(N - 1) = singular.row(0);
    singular.col(N - 1) = singular.col(0);
    fill(singular);
    EXPECT_EQ(detail::factor(triangle, kernels), N - 1);
  }
}

// The argument that makes the selection incremental, on A itself.
void expect_largest_gains(const Data& data, int size) {
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
  expect_largest_gains(random_data(230), 210);
}

TEST(SelectSubset, leaves_out_only_what_is_too_far_away_to_matter) {
  Data data = random_data(230);
  for (int n = 0; n < 230; ++n) data.states(n, 0) += 0.1 * n;  // 32 samples are as wide as a few length-scales
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  data.actions = RowMatrix::NullaryExpr(230, 2, [&] { return normal(generator); });  // so that all samples gain
  expect_largest_gains(data, 210);
}

}  // namespace
}  // namespace lfdcore
