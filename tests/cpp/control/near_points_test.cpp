#include "lfdcore/control/near_points.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

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
  near.gather(ObstaclePoints(points), 5, {});
  EXPECT_NEAR(near.slack({}, {}, {0.03}), 0, 1e-12);
  EXPECT_NEAR(near.slack({-0.1, 0, 0}, {}, {0.03}), 0.1, 1e-12);
  EXPECT_NEAR(near.slack({0.005, 0, 0}, {}, {0.03}), -0.005, 1e-12);
}

TEST(NearPoints, each_point_keeps_its_own_distance) {
  Path points(3, 2);
  points << 0.7, 0, 0, 0.45, 0, -0.95;  // .1 m inside, .1 and .6 m beside
  NearPoints near;
  near.gather(ObstaclePoints(points, {0.5, 0.02, 0.2}), 5, {});
  EXPECT_NEAR(near.slack({}, {}, {0.03}), 0, 1e-12);
  EXPECT_NEAR(near.slack({-0.3, 0, 0}, {}, {0.03}), 0.05, 1e-12);      // the second keeps .05
  EXPECT_NEAR(near.slack({-0.3, -0.4, 0}, {}, {0.03}), -0.03, 1e-12);  // the third keeps .23
  EXPECT_NEAR(near.slack({-0.3, 0, 0}, {}, {1}), 0, 1e-12);            // none keeps more than it has
}

TEST(NearPoints, that_are_passed_keep_the_distance_at_which_they_are_passed) {
  Path points(3, 2);
  points << 1, 0.366, 1, -0.4, 1, 0.45;  // .016, .05 and .1 m beside the way
  NearPoints near;
  Sides sides;
  near.gather(ObstaclePoints(points), 5, {});
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0.016 - 0.03, 1e-12);  // none is passed yet
  near.let_pass({}, 0.015, sides);
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, infinity}), 0.016 - 0.03, 1e-12);
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0, 1e-12);
  EXPECT_NEAR(near.slack({0.5, 0.001, 0}, {}, {0.03, 0.002}), 0.001, 1e-12);
  near.let_pass({}, 0.017, sides);  // the first is too near
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0.016 - 0.03, 1e-12);
  near.gather(ObstaclePoints(points, {0, 0, 0.2}), 5, {});
  near.let_pass({}, 0.015, sides);  // the third is too unsure
  EXPECT_NEAR(near.slack({0.5, 0, 0}, {}, {0.03, 0}), 0.1 - 0.2236067977499790, 1e-12);
}

TEST(NearPoints, what_is_beside_is_passed_however_near_it_is) {
  Path points(3, 2);
  points << 0.2, 0.353, 0.3, -0.25, 0.79, -0.33;  // .003 m beside, .1 m inside, .01 m inside the nose
  NearPoints near;
  Sides sides;
  near.gather(ObstaclePoints(points, {0.02, 0, 0}), 5, {});
  EXPECT_NEAR(near.slack({0, 0.0005, 0}, {}, {0.03, 0.0005}), -0.0005, 1e-12);
  near.let_pass({}, 0.005, sides);
  EXPECT_NEAR(near.slack({0, 0.0005, 0}, {}, {0.03, 0.0005}), 0, 1e-12);
  EXPECT_NEAR(near.slack({0, 0.002, 0}, {}, {0.03, 0.002}), -0.002, 1e-12);  // more than 1 mm sideways
  EXPECT_NEAR(near.slack({0.005, 0, 0}, {}, {0.03, 0}), -0.005, 1e-12);      // deeper into the nose
}

// A wall at the right side, 4 mm inside: its next points may be as deep, those of a wall at the left may not.
TEST(NearPoints, a_wall_along_a_side_is_passed_as_near_as_it_is) {
  NearPoints near;
  for (const bool ahead : {true, false}) {
    const double sign = ahead ? 1 : -1, edge = ahead ? 0.8 : -0.35;
    for (const double next : {-0.004, -0.0045, -0.0055}) {
      Path points(4, 2);
      points << 0.1, -0.346, edge - sign * 0.1, -0.346, edge - sign * 0.8, -0.346, edge + sign * 0.02, -0.35 - next;
      for (const double side : {1, -1}) {
        Sides sides;
        Path mirrored = points;
        mirrored.col(1) *= side;
        near.gather(ObstaclePoints(mirrored), 5, {});
        near.let_pass({}, 0.005, sides);
        const double slack = near.slack({sign * 0.03, 0, 0}, {}, {0.015, 0});
        EXPECT_EQ(slack >= -1e-9, next >= -0.005) << ahead << next << side;
        mirrored(3, 1) *= -1;
        near.gather(ObstaclePoints(mirrored), 5, {});
        near.let_pass({}, 0.005, sides);
        EXPECT_LT(near.slack({sign * 0.03, 0, 0}, {}, {0.015, 0}), -0.01) << ahead << next << side;
      }
    }
  }
}

TEST(NearPoints, a_wall_that_is_clear_lets_nothing_unsure_pass_whatever_is_deep_inside) {
  Path points(4, 2);
  points << 0, 0.362, 0.7, 0.362, 0.82, 0.361, 0.4, 0.25;  // a wall, its next point, a foot
  NearPoints near;
  for (const bool touches : {false, true}) {
    Sides sides;
    near.gather(ObstaclePoints(points, {touches ? 0.0119 : 0, 0, 0.0115, 0}), 5, {});
    near.let_pass({}, 0.005, sides);
    EXPECT_EQ(near.slack({0.03, 0, 0}, {}, {0.015, 0}) >= -1e-9, touches);
  }
}

TEST(NearPoints, none_but_far_points_are_left_out_however_unsure) {
  Path points(2, 2);
  points << 3.0, 0, 3.0, 0;
  NearPoints near;
  near.gather(ObstaclePoints(points, {0, 1.5}), 2, {});
  EXPECT_EQ(near.size(), 1u);
}

}  // namespace
}  // namespace lfdcore
