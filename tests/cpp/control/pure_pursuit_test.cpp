#include "lfdcore/control/pure_pursuit.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

Path make_path(std::initializer_list<std::pair<double, double>> points) {
  Path path(static_cast<Eigen::Index>(points.size()), 2);
  Eigen::Index i = 0;
  for (const auto& [x, y] : points) path.row(i++) << x, y;
  return path;
}

Path wavy_path(std::mt19937& random) {
  std::uniform_real_distribution<double> turn(-0.5, 0.5);
  Path path(30, 2);
  path.row(0).setZero();
  for (double yaw = 0, i = 1; i < 30; ++i) {
    yaw += turn(random);
    path.row(static_cast<int>(i)) << path(static_cast<int>(i) - 1, 0) + 0.1 * std::cos(yaw),
        path(static_cast<int>(i) - 1, 1) + 0.1 * std::sin(yaw);
  }
  return path;
}

// Walks the path in 0.1 mm steps: closest point, then the first point out of the circle.
Eigen::Vector2d slow_control_point(const Path& path, const Eigen::Vector2d& robot, double look_ahead) {
  const Path fine = resample(path, 30001);
  Eigen::Index nearest = 0;
  (fine.rowwise() - robot.transpose()).rowwise().norm().minCoeff(&nearest);
  for (Eigen::Index i = nearest; i < fine.rows(); ++i) {
    if ((fine.row(i).transpose() - robot).norm() >= look_ahead) return fine.row(i).transpose();
  }
  return fine.row(fine.rows() - 1).transpose();
}

TEST(PurePursuit, control_point_agrees_with_walking_the_path_in_tiny_steps) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 30; ++trial) {
    const Path path = wavy_path(random);
    const Pose2 pose{0.5 + 0.3 * unit(random), 0.2 * unit(random), pi * unit(random)};
    const auto result = pure_pursuit(path, pose, 0.6, 0.5, 1.0);
    const Eigen::Vector2d slow = slow_control_point(path, {pose.x, pose.y}, 0.6);
    EXPECT_NEAR((pose * result.control_point - slow).norm(), 0, 3e-4);
  }
}

TEST(PurePursuit, the_arc_of_its_twist_passes_through_the_control_point) {
  std::mt19937 random(2);
  int tried = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const auto result = pure_pursuit(wavy_path(random), 0.8, 0.7, 1.0);
    const Eigen::Vector2d g = result.control_point;
    if (g.x() <= 0) continue;
    ++tried;
    const double angle = 2 * std::atan2(g.y(), g.x());  // turned when the arc reaches g
    const double time = std::abs(angle) > 1e-9 ? angle / result.twist.angular : g.x() / result.twist.linear;
    const Pose2 end = integrate({}, result.twist, time);
    EXPECT_NEAR(end.x, g.x(), 1e-9);
    EXPECT_NEAR(end.y, g.y(), 1e-9);
  }
  EXPECT_GT(tried, 30);
}

TEST(PurePursuit, drives_straight_along_a_straight_path) {
  const auto result = pure_pursuit(make_path({{-1, 0}, {3, 0}}), 0.8, 0.5, 1.0);
  EXPECT_DOUBLE_EQ(result.control_point.x(), 0.8);
  EXPECT_DOUBLE_EQ(result.twist.linear, 0.5);
  EXPECT_DOUBLE_EQ(result.twist.angular, 0);
  EXPECT_DOUBLE_EQ(result.arc_length, 1.8);
  EXPECT_FALSE(result.at_end);
}

TEST(PurePursuit, reduces_the_speed_and_keeps_the_arc_where_it_would_turn_too_fast) {
  const Path path = make_path({{0, 0}, {0.1, 2}});
  const auto free = pure_pursuit(path, 0.5, 1.0, 100.0), limited = pure_pursuit(path, 0.5, 1.0, 1.0);
  EXPECT_GT(free.twist.angular, 1.0);
  EXPECT_DOUBLE_EQ(limited.twist.angular, 1.0);
  EXPECT_NEAR(limited.twist.angular / limited.twist.linear, free.twist.angular / free.twist.linear, 1e-12);
}

TEST(PurePursuit, turns_in_place_towards_a_control_point_behind) {
  const auto left = pure_pursuit(make_path({{0, 0}, {-2, 0.1}}), 0.5, 0.4, 0.7);
  EXPECT_EQ(left.twist.linear, 0);
  EXPECT_EQ(left.twist.angular, 0.7);
  EXPECT_EQ(pure_pursuit(make_path({{0, 0}, {-2, -0.1}}), 0.5, 0.4, 0.7).twist.angular, -0.7);
}

TEST(PurePursuit, takes_the_end_point_when_the_path_ends_within_the_circle) {
  const auto result = pure_pursuit(make_path({{-1, 0}, {0.3, 0.1}}), 0.8, 0.5, 1.0);
  EXPECT_TRUE(result.at_end);
  EXPECT_EQ(result.control_point, Eigen::Vector2d(0.3, 0.1));
  EXPECT_NEAR(result.twist.angular, 2 * 0.5 * 0.1 / 0.1, 1e-12);  // the true |g|^2 = .1, not .8^2
}

TEST(PurePursuit, does_not_jump_where_the_robot_drifts_out_of_reach_of_the_path) {
  const Path path = make_path({{-1, 0}, {3, 0}});
  const auto within = pure_pursuit(path, {0, 0.7999999, 0}, 0.8, 0.5, 1.0);
  const auto beyond = pure_pursuit(path, {0, 0.8000001, 0}, 0.8, 0.5, 1.0);
  EXPECT_LT((within.control_point - beyond.control_point).norm(), 1e-3);
  EXPECT_FALSE(beyond.at_end);
}

TEST(PurePursuit, is_at_rest_without_speed_and_at_the_end) {
  EXPECT_EQ(pure_pursuit(make_path({{0, 0}, {-1, 1}}), 0.8, 0.0, 1.0).twist.angular, 0);
  const auto arrived = pure_pursuit(make_path({{0, 0}}), 0.8, 0.5, 1.0);
  EXPECT_TRUE(arrived.at_end);
  EXPECT_EQ(arrived.twist.linear, 0);
}

TEST(PurePursuit, follows_a_bend_to_its_end_within_a_tenth_of_its_look_ahead) {
  Path path(40, 2);
  for (int i = 0; i < 40; ++i) path.row(i) << 2 * std::sin(i * 0.04), 2 - 2 * std::cos(i * 0.04);
  Pose2 pose;
  double farthest = 0;
  for (int i = 0; i < 120; ++i) {
    const auto result = pure_pursuit(path, pose, 0.4, 0.3, 1.0);
    if (result.at_end && result.control_point.norm() < 0.05) break;
    pose = integrate(pose, result.twist, 0.1);
    farthest = std::max(farthest, std::abs(std::hypot(pose.x, pose.y - 2) - 2));
  }
  EXPECT_LT(farthest, 0.04);
  EXPECT_NEAR(std::hypot(pose.x - path(39, 0), pose.y - path(39, 1)), 0, 0.06);
}

TEST(PurePursuit, survives_repeated_points) {
  const auto result = pure_pursuit(make_path({{0, 0}, {0, 0}, {1, 0}, {1, 0}, {1, 0}}), 0.8, 0.5, 1.0);
  EXPECT_NEAR(result.control_point.x(), 0.8, 1e-12);
  EXPECT_NEAR(pure_pursuit(make_path({{1, 0}, {1, 0}, {1, 0}}), 0.8, 0.5, 1.0).control_point.x(), 1, 1e-12);
}

TEST(PurePursuit, refuses_what_cannot_be_followed) {
  const Path path = make_path({{0, 0}, {1, 0}});
  EXPECT_THROW(pure_pursuit(Path(0, 2), 0.8, 0.5, 1.0), std::invalid_argument);
  EXPECT_THROW(pure_pursuit(make_path({{0, 0}, {NAN, 0}}), 0.8, 0.5, 1.0), std::invalid_argument);
  EXPECT_THROW(pure_pursuit(path, 0, 0.5, 1.0), std::invalid_argument);
  EXPECT_THROW(pure_pursuit(path, 0.8, NAN, 1.0), std::invalid_argument);
  EXPECT_THROW(pure_pursuit(path, 0.8, -0.5, 1.0), std::invalid_argument);
  EXPECT_THROW(pure_pursuit(path, 0.8, 0.5, 0), std::invalid_argument);
  EXPECT_THROW(pure_pursuit(path, {NAN, 0, 0}, 0.8, 0.5, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
