#include "lfdcore/control/near_points.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

TEST(NearPoints, clearance_agrees_with_obstacle_points_and_ignores_only_far_points) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  NearPoints near;
  for (int count = 0; count < 60; ++count) {
    Path points(count, 2);
    for (int i = 0; i < count; ++i) points.row(i) << 4 * unit(random), 4 * unit(random);
    const ObstaclePoints all(points);
    near.gather(all, 100);
    EXPECT_EQ(near.size(), static_cast<std::size_t>(count));
    const Pose2 pose{unit(random), unit(random), pi * unit(random)};
    const double expected = all.clearance(pose, {});
    if (count == 0) EXPECT_EQ(near.slack(pose, {}), expected);
    if (expected > 0 && count > 0) EXPECT_NEAR(near.slack(pose, {}), expected, 1e-12);
    if (expected == 0) EXPECT_LE(near.slack(pose, {}), 0);
    near.gather(all, 2);
    if (expected > 0) EXPECT_GE(near.slack(pose, {}), expected - 1e-12);
  }
}

TEST(NearPoints, a_point_too_near_already_must_only_not_come_nearer) {
  Path points(2, 2);
  points << 0.81, 0, 2.0, 0;
  NearPoints near;
  near.gather(ObstaclePoints(points), 5, {}, 0.015);
  EXPECT_NEAR(near.slack({}, {}, {0.03}), 0, 1e-12);
  EXPECT_NEAR(near.slack({-0.1, 0, 0}, {}, {0.03}), 0.1, 1e-12);
  EXPECT_NEAR(near.slack({0.005, 0, 0}, {}, {0.03}), -0.005, 1e-12);
}

TEST(NearPoints, each_point_keeps_its_own_distance) {
  Path points(3, 2);
  points << 0.7, 0, 0, 0.45, 0, -0.95;  // .1 m inside, .1 and .6 m beside
  NearPoints near;
  near.gather(ObstaclePoints(points, {0.5, 0.02, 0.2}), 5, {}, 0.015);
  EXPECT_NEAR(near.slack({}, {}, {0.03}), 0, 1e-12);
  EXPECT_NEAR(near.slack({-0.3, 0, 0}, {}, {0.03}), 0.05, 1e-12);      // the second keeps .05
  EXPECT_NEAR(near.slack({-0.3, -0.4, 0}, {}, {0.03}), -0.03, 1e-12);  // the third keeps .23
  EXPECT_NEAR(near.slack({-0.3, 0, 0}, {}, {1}), 0, 1e-12);            // none keeps more than it has
}

TEST(NearPoints, that_are_passed_keep_the_distance_at_which_they_are_passed) {
  Path points(4, 2);
  points << 0, 0.355, 1, 0.36, 1, -0.354, 1, 0.45;  // the first is nearest: .005 m
  NearPoints near;
  near.gather(ObstaclePoints(points), 5, {}, 0.015);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, infinity}), 0.004 - 0.03, 1e-12);
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0.004 - 0.03, 1e-12);  // the third: nearer than the nearest
  Path other = points;
  other.row(2) << 1, -0.4;
  near.gather(ObstaclePoints(other, {0, 0, 0, 0.2}), 5, {}, 0.015);
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0.1 - 0.2236067977499790, 1e-12);  // the fourth: too unsure
  near.gather(ObstaclePoints(other), 5, {}, 0.015);
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0, 1e-12);
  EXPECT_NEAR(near.slack({0.5, 0.001, 0}, {}, {0.03, 0.002}), 0.001, 1e-12);
}

TEST(NearPoints, none_but_far_points_are_left_out_however_unsure) {
  Path points(2, 2);
  points << 3.0, 0, 3.0, 0;
  NearPoints near;
  near.gather(ObstaclePoints(points, {0, 1.5}), 2, {}, 0.015);
  EXPECT_EQ(near.size(), 1u);
}

}  // namespace
}  // namespace lfdcore
