#include "../../../cpp/src/planning/orientation_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lfdcore {
namespace {

TEST(OrientationKernel, leaves_exact_zeros_far_from_the_peak) {
  float weights[] = {0, 1, 79, 81, 1e30f}, filter[] = {1, 2, 1, 1, 1}, filtered[5];
  detail::weigh_squares(weights, 0, 1, filter, filtered, 5);
  EXPECT_NEAR(weights[1], std::exp(-1.0), 1e-6);
  EXPECT_NEAR(filtered[1], 2 * std::exp(-1.0), 1e-6);
  EXPECT_GT(weights[2], 0);
  EXPECT_EQ(weights[3], 0);
  EXPECT_EQ(weights[4], 0);
}

}  // namespace
}  // namespace lfdcore
