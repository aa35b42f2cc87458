#include "lfdcore/estimation/belief_update.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// A belief that collapses in one update may be left with a variance below 0 by rounding; there is none.
GoalMatrix without_negative_variances(const GoalMatrix& covariance) {
  const Eigen::SelfAdjointEigenSolver<GoalMatrix> eigen(covariance);
  if (eigen.eigenvalues().minCoeff() >= 0) return covariance;
  const GoalMatrix root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  return root * root.transpose();
}

// `root` is the lower Cholesky factor of the covariance that is not to be exceeded.
GoalMatrix no_wider_than(const GoalMatrix& covariance, const GoalMatrix& root) {
  const auto lower = root.triangularView<Eigen::Lower>();
  const GoalMatrix half = lower.solve(covariance);
  const GoalMatrix relative = lower.solve(half.transpose());  // 1 in a direction as wide
  const Eigen::SelfAdjointEigenSolver<GoalMatrix> eigen(0.5 * (relative + relative.transpose()));
  if (eigen.eigenvalues().maxCoeff() <= 1) return covariance;
  const GoalMatrix basis = lower * eigen.eigenvectors();
  return basis * eigen.eigenvalues().cwiseMin(1).asDiagonal() * basis.transpose();
}

}  // namespace

Belief widened(const Belief& belief, const Belief& prior, double process_noise) {
  if (process_noise == 0) return belief;
  Belief wider = belief;
  wider.covariance.diagonal().array() += process_noise;
  const Eigen::LLT<GoalMatrix> factor(prior.covariance);
  if (factor.info() == Eigen::Success) wider.covariance = no_wider_than(wider.covariance, factor.matrixL());
  return wider;
}

Belief conditioned(const Belief& belief, const ActionMoments& moments, const ActionVector& action) {
  require(action.size() == moments.mean.size(), "an action must have one value for every kernel");
  require(moments.cross_covariance.rows() == belief.mean.size(), "the moments must be of the belief's goal");
  require(action.allFinite(), "the action must be finite");
  require(action.cwiseAbs().maxCoeff() <= largest_number, "the action must lie within 1e20");
  const Eigen::LLT<ActionMatrix> factor(moments.covariance);
  require(factor.info() == Eigen::Success,
          "the action's covariance is singular or no number: give the action kernels a larger noise");
  const CrossMatrix gain = factor.solve(moments.cross_covariance.transpose()).transpose();
  const GoalMatrix covariance = belief.covariance - gain * moments.cross_covariance.transpose();  // 2.3
  const GoalMatrix symmetric = 0.5 * (covariance + covariance.transpose());
  const Belief after{belief.mean + gain * (action - moments.mean), without_negative_variances(symmetric)};  // 2.2
  validate(after, static_cast<int>(belief.mean.size()));  // no later update could go on from another one
  return after;
}

}  // namespace lfdcore
