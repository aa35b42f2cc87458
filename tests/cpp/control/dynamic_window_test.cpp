#include "lfdcore/control/dynamic_window.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace lfdcore {
namespace {

Path random_points(std::mt19937& random, int count, double half_size) {
  std::uniform_real_distribution<double> at(-half_size, half_size);
  Path points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << at(random), at(random);
  return points;
}

// Alg. 8 as printed (ERRATA 47: as a cost, without an initial best): every twist, every step, every point.
DynamicWindowResult slow_dynamic_window(const Twist2& current, const Eigen::Vector2d& goal, const ObstaclePoints& z,
                                        const Footprint& footprint, const MotionLimits& limits,
                                        const DynamicWindowConfig& config, double period) {
  DynamicWindowResult best;
  best.cost = std::numeric_limits<double>::infinity();
  const Twist2 low = approach(current, {-limits.max_reverse, -limits.max_angular}, limits, period);
  const Twist2 high = approach(current, {limits.max_linear, limits.max_angular}, limits, period);
  for (int i = 0; i < config.linear_samples; ++i) {
    for (int j = 0; j < config.angular_samples; ++j) {
      const Twist2 twist{low.linear + (high.linear - low.linear) * i / (config.linear_samples - 1),
                         low.angular + (high.angular - low.angular) * j / (config.angular_samples - 1)};
      bool hit = false;
      for (int k = 1; k * config.step < config.horizon + 1e-9; ++k) {
        hit = hit || z.collides(integrate({}, twist, k * config.step), footprint);
      }
      const Pose2 end = integrate({}, twist, config.horizon);
      const double cost = std::hypot(end.x - goal.x(), end.y - goal.y());
      if (!hit && cost < best.cost - 1e-12) best = {twist, true, {end.x, end.y}, cost};
    }
  }
  return best;
}

TEST(DynamicWindow, agrees_with_trying_every_twist_step_and_point) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int infeasible = 0, detours = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const ObstaclePoints z(random_points(random, 1 + trial % 20, 3));
    const Twist2 current{0.3 + 0.7 * unit(random), unit(random)};
    const Eigen::Vector2d goal(1 + 2 * unit(random), 2 * unit(random));
    const double period = 0.05 * (1 + trial % 4);
    const auto fast = solve_dynamic_window(current, goal, z, {}, {}, {}, {}, period);
    const auto slow = slow_dynamic_window(current, goal, z, {}, {}, {}, period);
    ASSERT_EQ(fast.feasible, slow.feasible);
    infeasible += !fast.feasible;
    detours += fast.feasible && fast.cost > solve_dynamic_window(current, goal, {}, {}, {}, {}, {}, period).cost + 1e-9;
    if (!fast.feasible) continue;
    EXPECT_NEAR(fast.cost, slow.cost, 1e-9);
    EXPECT_NEAR((fast.end_point - slow.end_point).norm(), 0, 1e-6);
  }
  EXPECT_GT(infeasible, 10);
  EXPECT_GT(detours, 10);
}

TEST(DynamicWindow, drives_straight_at_a_free_goal_ahead_and_stays_in_the_window) {
  const auto result = solve_dynamic_window({0.5, 0}, {3, 0}, {}, {}, {});
  EXPECT_NEAR(result.twist.linear, 0.58, 1e-12);  // .8 m/s^2 for .1 s
  EXPECT_NEAR(result.twist.angular, 0, 1e-12);
  EXPECT_TRUE(result.feasible);
  EXPECT_NEAR(result.end_point.x(), 1.16, 1e-12);
}

TEST(DynamicWindow, brakes_at_the_limit_when_every_twist_collides) {
  Path wall(41, 2);
  for (int i = 0; i < 41; ++i) wall.row(i) << 0.9, -1 + 0.05 * i;
  const auto result = solve_dynamic_window({0.8, 0.5}, {3, 0}, ObstaclePoints(wall), {}, {});
  EXPECT_FALSE(result.feasible);
  EXPECT_NEAR(result.twist.linear, 0.65, 1e-12);  // 1.5 m/s^2 for .1 s
  EXPECT_NEAR(result.twist.angular, 0.25, 1e-12);
  EXPECT_TRUE(std::isinf(result.cost));
}

TEST(DynamicWindow, does_not_keep_a_current_twist_that_collides) {  // ERRATA 47
  Path point(1, 2);
  point << 1.5, 0.0;
  const auto result = solve_dynamic_window({0.6, 0}, {1.2, 0}, ObstaclePoints(point), {}, {});
  const ObstaclePoints z(point);
  for (int k = 1; k <= 20; ++k) EXPECT_FALSE(z.collides(integrate({}, result.twist, 0.1 * k), {}));
}

TEST(DynamicWindow, a_longer_horizon_stops_it_farther_from_the_table) {  // Sec. 3.5.1: docking is prohibitive
  Path table(61, 2);
  for (int i = 0; i < 61; ++i) table.row(i) << 2.0, -1.5 + 0.05 * i;
  double reached[2];
  for (int run = 0; run < 2; ++run) {
    DynamicWindowConfig config;
    config.horizon = run == 0 ? 1.0 : 2.5;
    Pose2 pose;
    Twist2 twist;
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d goal(1.0, 0);  // the driver keeps asking for straight on, 1 s ahead
      const ObstaclePoints seen(transform(pose.inverse(), table));
      twist = solve_dynamic_window(twist, goal, seen, {}, {}, config).twist;
      pose = integrate(pose, twist, 0.1);
    }
    reached[run] = pose.x;
  }
  EXPECT_GT(reached[0], reached[1]);
}

TEST(DynamicWindow, refuses_bad_input) {
  EXPECT_THROW(solve_dynamic_window({NAN, 0}, {1, 0}, {}, {}, {}), std::invalid_argument);
  EXPECT_THROW(solve_dynamic_window({}, {NAN, 0}, {}, {}, {}), std::invalid_argument);
  EXPECT_THROW(solve_dynamic_window({}, {1, 0}, {}, {}, {}, {}, {}, 0), std::invalid_argument);
  DynamicWindowConfig config;
  config.step = 3;
  EXPECT_THROW(solve_dynamic_window({}, {1, 0}, {}, {}, {}, config), std::invalid_argument);
  config = {};
  config.linear_samples = 0;
  EXPECT_THROW(solve_dynamic_window({}, {1, 0}, {}, {}, {}, config), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
