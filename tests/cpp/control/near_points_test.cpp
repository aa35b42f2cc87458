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
  near.gather(ObstaclePoints(points), 5);
  near.keep(0.03, {});
  EXPECT_NEAR(near.slack({}, {}), 0, 1e-12);
  EXPECT_NEAR(near.slack({-0.1, 0, 0}, {}), 0.1, 1e-12);
  EXPECT_NEAR(near.slack({0.005, 0, 0}, {}), -0.005, 1e-12);
}

}  // namespace
}  // namespace lfdcore
