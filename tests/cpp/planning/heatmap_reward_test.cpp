#include "lfdcore/planning/heatmap_reward.hpp"

#include <gtest/gtest.h>

namespace lfdcore {
namespace {

TEST(HeatmapReward, lays_the_border_over_the_heat_and_obstacles_over_both) {
  Mask blocked = Mask::Constant(3, 4, false);
  blocked(0, 1) = blocked(1, 2) = true;
  const FloatGrid reward = heatmap_reward(FloatGrid::Constant(3, 4, 0.5f), blocked, {.obstacle = -7, .border = -3});
  FloatGrid wanted = FloatGrid::Constant(3, 4, -3.0f);
  wanted(1, 1) = 0.5f;
  wanted(0, 1) = wanted(1, 2) = -7;
  EXPECT_TRUE((reward == wanted).all());
}

}  // namespace
}  // namespace lfdcore
