#include "../../../cpp/src/planning/clearance_map.hpp"

#include <gtest/gtest.h>

#include <random>

#include "scattered_points.hpp"

namespace lfdcore {
namespace {

using test::scattered;

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

}  // namespace
}  // namespace lfdcore
