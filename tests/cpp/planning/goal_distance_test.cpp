#include "../../../cpp/src/planning/goal_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lfdcore {
namespace {

TEST(GoalDistance, is_a_close_bound_from_below_on_the_straight_way_in_the_open) {
  ClearanceMap map(3.5);
  map.build(ObstaclePoints(), {0, 0});
  GoalDistance distance(map);
  ASSERT_TRUE(distance.build(map, {1.0, -0.5}, 0.15, {0.35, 0.04, 2.0, 0.3}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-3.4, 3.4);
  for (int i = 0; i < 1000; ++i) {
    const double x = coordinate(random), y = coordinate(random);
    const double way = std::hypot(x - 1.0, y + 0.5) - 0.15;
    EXPECT_LE(distance.at(x, y), std::max(way, 0.0) + 1e-9);
    EXPECT_GE(distance.at(x, y), 0.9 * way - 0.2);
  }
}

TEST(GoalDistance, is_infinite_behind_a_wall_without_a_gap_for_the_disc) {
  Path wall(200, 2);
  for (int i = 0; i < 200; ++i) wall.row(i) << 0.5, -4 + 0.04 * i;
  ClearanceMap map(3.5);
  map.build(ObstaclePoints(wall), {0, 0});
  GoalDistance distance(map);
  ASSERT_TRUE(distance.build(map, {2.0, 0.0}, 0.15, {0.35, 0.04, 2.0, 0.3}));
  EXPECT_FALSE(std::isfinite(distance.at(-0.5, 0)));
  EXPECT_TRUE(std::isfinite(distance.at(1.5, 1.0)));
}

}  // namespace
}  // namespace lfdcore
