#include "lfdcore/planning/hybrid_astar.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scattered_points.hpp"

namespace lfdcore {
namespace {

using test::scattered;

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
