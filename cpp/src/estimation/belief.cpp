#include "lfdcore/estimation/belief.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore {

void validate(const Belief& belief, int dimensions) {
  const GoalMatrix& covariance = belief.covariance;
  require(belief.mean.size() == dimensions && covariance.rows() == dimensions && covariance.cols() == dimensions,
          "the belief's mean and covariance must have as many dimensions as the goals");
  require(belief.mean.allFinite() && covariance.allFinite(), "the belief must be finite");
  require(belief.mean.cwiseAbs().maxCoeff() <= largest_number &&
              covariance.cwiseAbs().maxCoeff() <= largest_number * largest_number,
          "the belief must lie within 1e20 m, its covariance within 1e40 m^2");
  const double trace = covariance.trace(), slack = 1e-9 * trace;
  require(trace >= 0 && (covariance - covariance.transpose()).cwiseAbs().maxCoeff() <= slack,
          "the belief's covariance must be symmetric, with no negative variance");
  if (trace == 0) return require(covariance.isZero(0), "the belief's covariance must be positive semidefinite");
  GoalMatrix raised = covariance;
  raised.diagonal().array() += slack;
  const Eigen::LLT<GoalMatrix> factor(raised);
  require(factor.info() == Eigen::Success, "the belief's covariance must be positive semidefinite");
}

Eigen::VectorXd goal_likelihoods(const Belief& belief, const RowMatrix& goals) {
  require(goals.rows() > 0, "likelihoods of no goals");
  require(goals.cols() <= most_goal_dimensions, "goals have more than " + std::to_string(most_goal_dimensions) +
                                                    " dimensions: " + std::to_string(goals.cols()));
  require(goals.allFinite(), "goals must be finite");
  require(goals.cwiseAbs().maxCoeff() <= largest_number, "goals must lie within 1e20 m");
  validate(belief, static_cast<int>(goals.cols()));
  const Eigen::SelfAdjointEigenSolver<GoalMatrix> eigen(belief.covariance);
  const double least = std::max(1e-12 * eigen.eigenvalues().maxCoeff(), 1e-18);  // [m^2]
  const GoalVector weights = eigen.eigenvalues().cwiseMax(least).cwiseInverse();
  const Eigen::MatrixXd offsets = (goals.rowwise() - belief.mean.transpose()) * eigen.eigenvectors();
  const Eigen::VectorXd distances = offsets.cwiseAbs2() * weights;
  const Eigen::VectorXd odds = (-0.5 * (distances.array() - distances.minCoeff())).exp();
  return odds / odds.sum();
}

}  // namespace lfdcore
