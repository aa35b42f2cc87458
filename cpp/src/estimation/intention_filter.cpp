#include "lfdcore/estimation/intention_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <utility>

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

// The covariance, but in no direction wider than the prior's: what is known of the goals is not forgotten. `root` is
// the lower Cholesky factor of the prior's covariance.
GoalMatrix no_wider_than(const GoalMatrix& covariance, const GoalMatrix& root) {
  const auto lower = root.triangularView<Eigen::Lower>();
  const GoalMatrix half = lower.solve(covariance);
  const GoalMatrix relative = lower.solve(half.transpose());  // 1 in a direction as wide as the prior
  const Eigen::SelfAdjointEigenSolver<GoalMatrix> eigen(0.5 * (relative + relative.transpose()));
  if (eigen.eigenvalues().maxCoeff() <= 1) return covariance;
  const GoalMatrix basis = lower * eigen.eigenvectors();
  return basis * eigen.eigenvalues().cwiseMin(1).asDiagonal() * basis.transpose();
}

}  // namespace

IntentionFilter::IntentionFilter(ActionModel model, Belief prior, double process_noise)
    : model_(std::move(model)),
      prior_(std::move(prior)),
      belief_(prior_),
      process_noise_(process_noise),
      scratch_(model_.scratch_size()) {
  validate(prior_, model_.goal_dimensions());
  const Eigen::LLT<GoalMatrix> factor(prior_.covariance);
  if (factor.info() == Eigen::Success) prior_root_ = factor.matrixL();
  require_between("process_noise", process_noise, 0, largest_number * largest_number, "m^2");
}

const Belief& IntentionFilter::update(std::span<const double> state, std::span<const double> action) {
  require(action.size() == static_cast<std::size_t>(model_.actions()),
          "an action must have one value for every kernel");
  const ActionVector y = Eigen::Map<const ActionVector>(action.data(), static_cast<Eigen::Index>(action.size()));
  require(y.allFinite(), "the action must be finite");
  require(y.cwiseAbs().maxCoeff() <= largest_number, "the action must lie within 1e20");
  Belief belief = belief_;
  if (process_noise_ > 0) {
    belief.covariance.diagonal().array() += process_noise_;
    if (prior_root_.size() > 0) belief.covariance = no_wider_than(belief.covariance, prior_root_);
  }
  const ActionMoments moments = model_.moments(state, belief, scratch_);
  const Eigen::LLT<ActionMatrix> factor(moments.covariance);
  require(factor.info() == Eigen::Success,
          "the action's covariance is singular or no number: give the action kernels a larger noise");
  const ActionVector surprise = y - moments.mean;
  const CrossMatrix gain = factor.solve(moments.cross_covariance.transpose()).transpose();
  belief.mean += gain * surprise;                                    // 2.2
  belief.covariance -= gain * moments.cross_covariance.transpose();  // 2.3
  const GoalMatrix symmetric = 0.5 * (belief.covariance + belief.covariance.transpose());
  belief.covariance = without_negative_variances(symmetric);
  validate(belief, model_.goal_dimensions());  // what no later update could go on from is not kept
  belief_ = belief;
  return belief_;
}

void IntentionFilter::reset() { belief_ = prior_; }

}  // namespace lfdcore
