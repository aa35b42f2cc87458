// A Gaussian over the place where the driver is going.
#pragma once

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// Goals have at most this many dimensions; so their vectors and matrices need no memory from the heap.
constexpr int most_goal_dimensions = 4;
/// Larger numbers are refused, and divisors below one over it: products of their squares would overflow.
constexpr double largest_number = 1e20;
using GoalVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_goal_dimensions, 1>;
using GoalMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_goal_dimensions, most_goal_dimensions>;

/// g ~ N(mean, covariance).
struct Belief {
  GoalVector mean;        ///< (Dg,) [m]
  GoalMatrix covariance;  ///< (Dg, Dg) [m^2], may be singular
};

/// Throws std::invalid_argument unless the mean has `dimensions` and the covariance fits, all is within +-1e20 m and
/// 1e40 m^2, and the covariance is symmetric and positive semidefinite (both up to 1e-9 of its trace).
void validate(const Belief& belief, int dimensions);

/// Goals (L, Dg) -> (L,) likelihoods that sum to 1: softmax of -d^2 / 2, d the Mahalanobis distance (ERRATA F1).
/// Standard deviations below 1e-6 of the largest, or 1 nm, count as that: a belief without spread gives all to the
/// nearest goal. Throws std::invalid_argument for no goals, other sizes and what is beyond +-1e20 m.
Eigen::VectorXd goal_likelihoods(const Belief& belief, const RowMatrix& goals);

}  // namespace lfdcore
