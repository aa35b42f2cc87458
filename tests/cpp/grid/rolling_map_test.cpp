#include "lfdcore/grid/rolling_map.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "../allocation_count.hpp"

namespace lfdcore {
namespace {

LaserScan ring(int step) {
  LaserScan scan;
  for (int i = 0; i < 181; ++i) scan.ranges.push_back(2.0f + 0.01f * static_cast<float>((i * 7 + step * 13) % 40));
  scan.ranges[3] = std::numeric_limits<float>::infinity();
  scan.ranges[4] = std::numeric_limits<float>::quiet_NaN();
  return scan;
}

TEST(RollingMap, inserts_scans_on_a_drive_without_allocating_once_its_buffers_have_grown) {
  if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  RollingMap map({.duration = 2.0, .radius = 4.0});
  long allocations = 0;
  for (int step = 0; step < 200; ++step) {
    const LaserScan scan = ring(step);
    const Pose2 base{0.05 * step, 0.01 * step, 0.02 * step};
    const long before = test::allocation_count();
    map.insert(0.1 * step, scan, {0.70, 0, 0}, base);
    if (step >= 100) allocations += test::allocation_count() - before;
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(map.size(), 100u);
}

TEST(RollingMap, keeps_its_state_when_it_refuses_a_scan) {
  RollingMap map;
  map.insert(1.0, ring(0), {0.70, 0, 0}, {});
  const std::size_t size = map.size();
  LaserScan empty;
  EXPECT_THROW(map.insert(2.0, empty, {0.70, 0, 0}, {}), std::invalid_argument);
  EXPECT_THROW(map.insert(0.5, ring(1), {0.70, 0, 0}, {}), std::invalid_argument);
  EXPECT_EQ(map.size(), size);
}

}  // namespace
}  // namespace lfdcore
