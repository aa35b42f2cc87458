#include "lfdcore/simulation/driving_world.hpp"

#include <gtest/gtest.h>

namespace lfdcore {
namespace {

OccupancyGrid room() {
  OccupancyGrid grid({160, 100, 0.05, 0, 0}, occupied_cell);
  grid.data.block(1, 1, 98, 158) = free_cell;
  return grid;
}

TEST(DrivingWorld, drives_into_a_wall_once_and_reverses_out) {
  DrivingWorld world(room(), {}, {}, 1);
  world.reset({6, 2.5, 0});
  int started = 0;
  for (int i = 0; i < 40; ++i) started += world.step({0.8, 0.1}).collision_started;
  EXPECT_EQ(started, 1);
  EXPECT_TRUE(world.state().in_contact);
  for (int i = 0; i < 20; ++i) world.step({-0.4, 0});
  EXPECT_FALSE(world.state().in_contact);
  EXPECT_EQ(world.state().collisions, 1);
}

TEST(DrivingWorld, scans_into_given_memory_what_it_scans_into_new) {
  DrivingWorld world(room(), {}, {}, 1);
  world.reset({3, 2.5, 0.3});
  LaserScan given = world.scan();
  for (int i = 0; i < 5; ++i) world.step({0.5, 0.2});
  const float* memory = given.ranges.data();
  world.scan(given);
  EXPECT_EQ(given.ranges.data(), memory);
  EXPECT_EQ(given.ranges, world.scan().ranges);
  given.ranges.pop_back();
  EXPECT_THROW(world.scan(given), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
