#include "lfdcore/planning/movement_template.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lfdcore {
namespace {

TEST(ArcOrientation, is_the_stick_that_drives_through_the_point) {
  const MotionLimits limits{.max_linear = 0.9, .max_reverse = 0.3, .max_angular = 1.4};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> orientation(-3.1, 3.1), share(0.05, 0.95);
  for (int i = 0; i < 200; ++i) {
    const double h = orientation(random), forward = std::cos(h), left = std::sin(h);
    const Twist2 twist{forward * (forward < 0 ? limits.max_reverse : limits.max_linear), left * limits.max_angular};
    const Pose2 pose = integrate({}, twist, share(random) * pi / std::max(std::abs(twist.angular), 0.1));
    EXPECT_NEAR(arc_orientation({pose.x, pose.y}, limits), h, 1e-9);
  }
}

}  // namespace
}  // namespace lfdcore
