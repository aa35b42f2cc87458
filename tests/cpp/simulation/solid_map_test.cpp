#include "lfdcore/simulation/solid_map.hpp"

#include <gtest/gtest.h>

#include <random>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

OccupancyGrid random_grid(std::mt19937& random, double share) {
  OccupancyGrid grid({57, 43, 0.05, -1.0, 0.5}, free_cell);
  std::bernoulli_distribution solid(share);
  for (auto& cell : grid.data.reshaped()) cell = solid(random) ? occupied_cell : free_cell;
  return grid;
}

/// Separating axes: the widest gap between the rectangle and a square, negative if they overlap.
double gap(const Pose2& pose, const Footprint& footprint, const Eigen::Vector2d& centre, double half) {
  const auto corners = footprint.corners();
  double widest = -1e9;
  for (const double angle : {0.0, pi / 2, pose.yaw, pose.yaw + pi / 2}) {
    const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
    double low = 1e9, high = -1e9;
    for (const auto& corner : corners) {
      const double along = axis.dot(pose * corner);
      low = std::min(low, along);
      high = std::max(high, along);
    }
    const double middle = axis.dot(centre), reach = half * (std::abs(axis.x()) + std::abs(axis.y()));
    widest = std::max({widest, low - middle - reach, middle - reach - high});
  }
  return widest;
}

double smallest_gap(const OccupancyGrid& grid, const Pose2& pose, const Footprint& footprint) {
  double smallest = 1e9;
  for (int iy = 0; iy < grid.geometry.height; ++iy)
    for (int ix = 0; ix < grid.geometry.width; ++ix)
      if (grid.occupied({ix, iy}))
        smallest =
            std::min(smallest, gap(pose, footprint, grid.geometry.centre({ix, iy}), grid.geometry.resolution / 2));
  return smallest;
}

TEST(SolidMap, agrees_with_separating_axes_over_every_cell) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(-1.5, 2.3), y(0, 3.2), yaw(-pi, pi), size(0.05, 0.9);
  int touching = 0, trials = 0;
  for (int map = 0; map < 12; ++map) {
    const OccupancyGrid grid = random_grid(random, map % 3 == 0 ? 0.05 : 0.003);
    const SolidMap solid(grid, false);
    for (int i = 0; i < 150; ++i) {
      const Footprint footprint = i % 2 ? Footprint{} : Footprint{size(random), size(random), size(random)};
      const Pose2 pose{x(random), y(random), i % 10 ? yaw(random) : std::round(yaw(random)) * pi / 2};
      const double truth = smallest_gap(grid, pose, footprint);
      if (std::abs(truth) < 1e-9) continue;
      EXPECT_EQ(solid.touches(pose, footprint), truth < 0) << pose.x << ' ' << pose.y << ' ' << pose.yaw;
      touching += truth < 0;
      ++trials;
    }
  }
  EXPECT_GT(touching, 300);
  EXPECT_GT(trials - touching, 300);
}

TEST(SolidMap, finds_a_single_cell_inside_the_body) {
  OccupancyGrid grid({100, 100, 0.05, 0, 0}, free_cell);
  grid.data(50, 50) = occupied_cell;
  EXPECT_TRUE(SolidMap(grid, true).touches({2.3, 2.52, 0.2}, {}));
}

TEST(SolidMap, takes_unknown_cells_and_the_outside_as_given) {
  OccupancyGrid grid({100, 100, 0.05, 0, 0}, free_cell);
  grid.data(50, 50) = unknown_cell;
  for (const bool is_solid : {true, false}) {
    const SolidMap map(grid, is_solid);
    EXPECT_EQ(map.touches({2.3, 2.52, 0.2}, {}), is_solid);
    EXPECT_EQ(map.touches({0.3, 1.5, 0}, {}), is_solid) << "half outside";
    EXPECT_EQ(map.touches({-50, 1.5, 0}, {}), is_solid) << "wholly outside";
    EXPECT_FALSE(map.touches({0.5, 0.5, 0}, {}));
  }
}

TEST(SolidMap, names_the_touched_cell_nearest_to_the_axle) {
  OccupancyGrid grid({100, 100, 0.05, 0, 0}, free_cell);
  grid.data(50, 60) = grid.data(50, 63) = occupied_cell;
  const auto point = SolidMap(grid, true).contact_point({2.5, 2.5, 0}, {});
  ASSERT_TRUE(point);
  EXPECT_NEAR(point->x(), 3.025, 1e-12);
  EXPECT_NEAR(point->y(), 2.525, 1e-12);
  EXPECT_FALSE(SolidMap(grid, true).contact_point({1.0, 1.0, 0}, {}));
}

TEST(SolidMap, refuses_a_resolution_that_no_body_can_be_tested_on) {
  EXPECT_THROW(SolidMap(OccupancyGrid({4, 4, 1e-6, 0, 0}, free_cell), true), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
