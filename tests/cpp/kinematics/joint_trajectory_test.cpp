#include "lfdcore/kinematics/joint_trajectory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace lfdcore {
namespace {

TEST(SlowDown, keeps_every_chord_inside_the_limits_and_leaves_slow_ones_alone) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0, 1);
  RowMatrix positions(101, 2);
  for (int i = 0; i < 101; ++i) positions.row(i) << std::exp(-50 * (time[i] - 0.5) * (time[i] - 0.5)), 0.1 * time[i];
  const Eigen::Vector2d limits(2, 1);
  const Eigen::VectorXd slowed = slow_down(time, positions, limits, 0.05);
  const RowMatrix velocities = joint_velocities(slowed, positions);
  EXPECT_LE(velocities.col(0).cwiseAbs().maxCoeff(), 2 + 1e-9);
  EXPECT_LE(velocities.col(1).cwiseAbs().maxCoeff(), 1 + 1e-9);
  EXPECT_NEAR(slowed[1] - slowed[0], 0.01, 1e-12);
  EXPECT_GT(slowed[100], 1.1);
  EXPECT_TRUE(slow_down(time, positions, Eigen::Vector2d(100, 100), 0.05).isApprox(time));
}

TEST(SlowDown, refuses_times_that_do_not_increase_and_limits_of_zero) {
  const RowMatrix positions = RowMatrix::Zero(2, 1);
  EXPECT_THROW(slow_down(Eigen::Vector2d(1, 1), positions, Eigen::VectorXd::Ones(1)), std::invalid_argument);
  EXPECT_THROW(slow_down(Eigen::Vector2d(0, 1), positions, Eigen::VectorXd::Zero(1)), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
