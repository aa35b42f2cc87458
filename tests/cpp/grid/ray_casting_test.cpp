#include "lfdcore/grid/ray_casting.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lfdcore/grid/cell_walk.hpp"

namespace lfdcore {
namespace {

// The oracle: from cell to cell; where the first occupied one is entered follows from its corners alone.
float range_by_walking(const OccupancyGrid& grid, const CellRay& ray, double reach) {
  double range = std::numeric_limits<double>::infinity();
  walk_cells(ray, grid.geometry.width, grid.geometry.height, reach, [&](Cell cell) {
    if (!grid.occupied(cell) || std::isfinite(range)) return;
    range = std::max(0.0, clip({ray.x - cell.ix, ray.y - cell.iy, ray.dx, ray.dy}, 1, 1, reach).from);
  });
  return static_cast<float>(range * grid.geometry.resolution);
}

class RayCasterIn : public testing::TestWithParam<double> {};

TEST_P(RayCasterIn, a_random_map_returns_what_a_walk_from_cell_to_cell_returns) {
  std::mt19937 random(11);
  std::bernoulli_distribution occupied(GetParam());
  OccupancyGrid grid({150, 110, 0.1, -3, 2}, free_cell);
  for (auto& value : grid.data.reshaped()) value = occupied(random) ? occupied_cell : unknown_cell;
  const RayCaster caster(grid, 10.0);
  std::uniform_real_distribution<double> x(-10, 160), y(-10, 120), yaw(-pi, pi);
  for (int i = 0; i < 300; ++i) {
    const Pose2 laser{-3 + 0.1 * x(random), 2 + 0.1 * y(random), 0};
    std::vector<double> angles(1 + i % 37);
    for (double& angle : angles) angle = yaw(random);
    std::vector<float> ranges(angles.size());
    caster.cast(laser, angles, ranges);
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const CellRay ray{(laser.x + 3) / 0.1, (laser.y - 2) / 0.1, std::cos(angles[k]), std::sin(angles[k])};
      const float expected = range_by_walking(grid, ray, 100);
      if (std::isinf(expected)) {
        ASSERT_TRUE(std::isinf(ranges[k]));
      } else {
        ASSERT_NEAR(ranges[k], expected, 1e-5);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Densities, RayCasterIn, testing::Values(0.0, 0.003, 0.05, 0.5));

TEST(RayCaster, refuses_a_place_for_fewer_ranges_than_angles) {
  const RayCaster caster(OccupancyGrid({3, 3, 1, 0, 0}, free_cell), 5);
  const std::vector<double> angles(3);
  std::vector<float> ranges(2);
  EXPECT_THROW(caster.cast({}, angles, ranges), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
