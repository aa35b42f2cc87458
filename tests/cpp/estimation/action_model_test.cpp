#include "lfdcore/estimation/action_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "random_actions.hpp"

namespace lfdcore {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::ActionData;
using test::random_actions;
using test::state_on_the_way;
using test::uncertain_goal;

ActionMoments moments(const ActionModel& model, const Belief& of = uncertain_goal()) {
  std::vector<double> scratch(model.scratch_size());
  return model.moments(state_on_the_way, of, scratch);
}

// The section's formulas as printed, with ERRATA 1, 2 and 4, element by element.
ActionMoments literal_moments(const ActionData& data, const Belief& of) {
  const Eigen::Index N = data.states.rows();
  const Eigen::Map<const Eigen::RowVectorXd> x(state_on_the_way.data(), 3);
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
      const ActionData data = random_actions(count, jitter);
      const ActionModel model(data.states, data.goals, data.actions, data.kernels);
      EXPECT_LT(difference(moments(model), literal_moments(data, uncertain_goal())), 1e-11) << count << " " << jitter;
    }
}

TEST(ActionModel, takes_the_fast_path_where_goals_are_shared_and_agrees_with_the_general_one) {
  const ActionData shared = random_actions(200), apart = random_actions(200, 1e-13);
  const ActionModel fast(shared.states, shared.goals, shared.actions, shared.kernels);
  const ActionModel general(apart.states, apart.goals, shared.actions, apart.kernels);
  EXPECT_EQ(fast.shared_goals(), 4);
  EXPECT_EQ(general.shared_goals(), 0);
  EXPECT_LT(difference(moments(fast), moments(general)), 1e-10);
}

TEST(ActionModel, projected_on_all_samples_is_the_full_one_on_both_paths) {
  for (const double jitter : {0.0, 0.3}) {
    const ActionData data = random_actions(80, jitter);
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
  ActionData data = random_actions(320);
  for (int n = 0; n < 320; ++n) data.states(n, 0) += n;  // most of the samples are far from any one state
  const ActionModel model(data.states, data.goals, data.actions, data.kernels);
  EXPECT_LT(difference(moments(model), literal_moments(data, uncertain_goal())), 1e-11);
}

}  // namespace
}  // namespace lfdcore
