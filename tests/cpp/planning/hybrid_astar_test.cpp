#include "lfdcore/planning/hybrid_astar.hpp"

#include <gtest/gtest.h>

#include <random>

#include "../../../cpp/src/planning/clearance_map.hpp"
#include "../../../cpp/src/planning/goal_distance.hpp"

namespace lfdcore {
namespace {

ObstaclePoints scattered(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-4, 4);
  Path points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << coordinate(random), coordinate(random);
  return ObstaclePoints(points);
}

double nearest(const ObstaclePoints& obstacles, double x, double y) {
  return (obstacles.points().rowwise() - Eigen::RowVector2d(x, y)).rowwise().norm().minCoeff();
}

TEST(ClearanceMap, bounds_the_distance_to_the_nearest_point_from_both_sides) {
  ClearanceMap map(3.5);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-5, 5);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const ObstaclePoints obstacles = scattered(1 + 10 * static_cast<int>(seed), seed);
    map.build(obstacles, {0.3, -0.2});
    for (int i = 0; i < 500; ++i) {
      const double x = coordinate(random), y = coordinate(random);
      EXPECT_LE(map.at_least(x, y), nearest(obstacles, x, y));
      const int ix = map.index(x), iy = map.index(y);
      if (!map.contains(ix, iy)) continue;
      const double centre_x = 0.3 + (ix - map.cells() / 2) * ClearanceMap::resolution;
      const double centre_y = -0.2 + (iy - map.cells() / 2) * ClearanceMap::resolution;
      const double bound = map.at_most(ix, iy);
      if (bound < ClearanceMap::reach * ClearanceMap::resolution) {
        EXPECT_GE(bound, nearest(obstacles, centre_x, centre_y));
      }
    }
  }
}

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

TEST(HybridAstar, stays_usable_after_failed_searches_and_at_far_away_coordinates) {
  HybridAstar planner{Footprint{}};
  const ObstaclePoints none;
  EXPECT_THROW(planner.solve(none, {0, 0, 0}, {9, 0}), std::invalid_argument);
  Path inside(1, 2);
  inside << 0.2, 0.0;
  EXPECT_EQ(planner.solve(ObstaclePoints(inside), {}, {2, 0}).outcome, HybridAstarOutcome::start_blocked);
  EXPECT_TRUE(planner.solve(none, {}, {2, 0.5}).found);
  EXPECT_TRUE(planner.solve(none, {1e5, -1e5, 40.0}, {1e5 + 1, -1e5 + 1}).found);
}

TEST(HybridAstar, answers_alike_when_many_points_lie_outside_its_window) {
  const ObstaclePoints near = scattered(10, 5);
  Path more(near.points().rows() + 1000, 2);
  more.topRows(near.points().rows()) = near.points();
  for (int i = 0; i < 1000; ++i) more.row(near.points().rows() + i) << 30 + 0.1 * i, 1e6 * i;
  HybridAstar planner{Footprint{}};
  const auto few = planner.solve(near, {0.5, 0, 0}, {2, 1});
  const auto many = planner.solve(ObstaclePoints(more), {0.5, 0, 0}, {2, 1});
  EXPECT_EQ(few.outcome, many.outcome);
  EXPECT_EQ(few.cost, many.cost);
}

}  // namespace
}  // namespace lfdcore
