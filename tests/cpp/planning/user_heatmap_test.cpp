#include "lfdcore/planning/user_heatmap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../allocation_count.hpp"

namespace lfdcore {
namespace {

TEST(UserHeatmap, equals_the_printed_density_with_wrapped_differences) {
  const MovementTemplate movement;
  UserHeatmap result;
  for (const double mean : {0.0, -1.2, 3.0}) {
    const OrientationMoments orientation{mean, 0.09};
    user_heatmap(movement, orientation, result);
    double highest = 0;
    for (int i = 0; i < result.density.size(); ++i) {
      const double error = wrap_angle(mean - movement.orientation().data()[i]);
      const double wanted = std::exp(-error * error / 0.18) / std::sqrt(2 * pi * 0.09);
      EXPECT_NEAR(result.density.data()[i], wanted, 1e-5);
      highest = std::max(highest, wanted * movement.distance_filter().data()[i]);
    }
    for (int i = 0; i < result.density.size(); ++i) {
      const double filtered = result.density.data()[i] * movement.distance_filter().data()[i];
      EXPECT_NEAR(result.heatmap.data()[i], filtered / highest, 1e-5);
    }
    EXPECT_EQ(result.heatmap.maxCoeff(), 1.0f);
  }
}

TEST(UserHeatmap, does_not_allocate_into_a_used_result) {
  const MovementTemplate movement;
  UserHeatmap result;
  const long at_start = test::allocation_count();
  user_heatmap(movement, {0.1, 0.2}, result);
  const long before = test::allocation_count();
  user_heatmap(movement, {-0.4, 0.1}, result);
  EXPECT_EQ(test::allocation_count(), before);
  if (test::counts_allocations) EXPECT_GT(before, at_start);
}

TEST(UserHeatmap, has_a_maximum_also_where_every_density_underflows) {
  const MovementTemplate straight({.max_linear = 1e-4, .max_reverse = 1e-4, .max_angular = 1});
  UserHeatmap result;
  user_heatmap(straight, {pi / 2, 1e-6}, result);
  EXPECT_EQ(result.density.maxCoeff(), 0.0f);
  EXPECT_EQ(result.heatmap.maxCoeff(), 1.0f);
}

}  // namespace
}  // namespace lfdcore
