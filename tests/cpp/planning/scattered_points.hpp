// Obstacles to plan among.
#pragma once

#include <random>

#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore::test {

/// Points in the square of 8 m around the origin.
inline ObstaclePoints scattered(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-4, 4);
  Path points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << coordinate(random), coordinate(random);
  return ObstaclePoints(points);
}

}  // namespace lfdcore::test
