// No memory is asked for in the steady state of what runs in every tick (DPP and the rolling map: see their own tests).
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "allocation_count.hpp"
#include "lfdcore/control/dynamic_window.hpp"
#include "lfdcore/control/footprint_rollout.hpp"
#include "lfdcore/control/pure_pursuit.hpp"
#include "lfdcore/control/supervisor.hpp"
#include "lfdcore/estimation/rbf_network_bank.hpp"

namespace lfdcore {
namespace {

/// Calls of malloc in the third of three calls: the first two may grow buffers.
long allocations_of(const std::function<void()>& call) {
  call();
  call();
  const long before = test::allocation_count();
  call();
  return test::allocation_count() - before;
}

ObstaclePoints two_walls() {
  Path points(400, 2);
  for (int i = 0; i < 200; ++i) {
    points.row(2 * i) << -2.0 + 0.03 * i, 0.6;
    points.row(2 * i + 1) << -2.0 + 0.03 * i, -0.7;
  }
  return ObstaclePoints(points);
}

class SteadyState : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  }
  const ObstaclePoints obstacles = two_walls();
  const Footprint footprint;
  const MotionLimits limits;
};

TEST_F(SteadyState, of_the_supervisor_does_not_allocate) {
  Supervisor supervisor;
  EXPECT_EQ(allocations_of([&] { supervisor.filter({0.8, 0.5}, {0.7, 0.1}, obstacles); }), 0);
}

TEST_F(SteadyState, of_the_supervisor_beside_a_wall_that_touches_does_not_allocate) {
  Supervisor supervisor;
  Path points(200, 2);
  for (int i = 0; i < 200; ++i) points.row(i) << -2.0 + 0.03 * i, 0.348 + 0.001 * (i % 3);
  const ObstaclePoints wall(points);
  EXPECT_EQ(allocations_of([&] { supervisor.filter({0.1, 0}, {}, wall); }), 0);
}

TEST_F(SteadyState, of_the_dynamic_window_does_not_allocate) {
  const Eigen::Vector2d goal(0.9, 0.2);
  EXPECT_EQ(allocations_of([&] { solve_dynamic_window({0.7, 0.1}, goal, obstacles, footprint, limits); }), 0);
}

TEST_F(SteadyState, of_pure_pursuit_does_not_allocate) {
  Path path(50, 2);
  for (int i = 0; i < 50; ++i) path.row(i) << 0.05 * i, 0.002 * i * i;
  EXPECT_EQ(allocations_of([&] { pure_pursuit(path, Pose2{0.1, 0.0, 0.1}, 0.8, 0.5, 1.0); }), 0);
}

TEST_F(SteadyState, of_the_time_to_contact_does_not_allocate) {
  EXPECT_EQ(allocations_of([&] { time_to_contact({0.5, 0.3}, obstacles, footprint, 2.0); }), 0);
}

TEST_F(SteadyState, of_a_bank_of_networks_does_not_allocate) {
  RowMatrix inputs(40, 3);
  std::vector<std::int32_t> keys;
  for (int i = 0; i < 40; ++i) {
    inputs.row(i) << 0.02 * i, 1.0 - 0.02 * i, 0.5;
    keys.push_back(i / 4);
  }
  const RbfNetworkBank bank = RbfNetworkBank::fit(inputs, keys, {});
  const std::vector<double> shared = {0.3, 0.6}, own(bank.size(), 0.5);
  std::vector<double> estimates(bank.size());
  EXPECT_EQ(allocations_of([&] { bank.predict(shared, own, estimates); }), 0);
}

}  // namespace
}  // namespace lfdcore
