#include "lfdcore/geometry.hpp"

#include <gtest/gtest.h>

namespace lfdcore {
namespace {

TEST(WrapAngle, lies_in_minus_pi_exclusive_to_pi_inclusive) {
  EXPECT_DOUBLE_EQ(wrap_angle(pi), pi);
  EXPECT_DOUBLE_EQ(wrap_angle(-pi), pi);
  EXPECT_NEAR(wrap_angle(3 * pi / 2), -pi / 2, 1e-15);
}

TEST(Pose2, times_its_inverse_is_the_identity) {
  const Pose2 T{1.5, -2.0, 2.5};
  const Pose2 I = T * T.inverse();
  EXPECT_NEAR(I.x, 0, 1e-15);
  EXPECT_NEAR(I.y, 0, 1e-15);
  EXPECT_NEAR(I.yaw, 0, 1e-15);
}

TEST(Integrate, agrees_with_ten_thousand_small_euler_midpoint_steps) {
  const Twist2 twist{0.7, -1.3};
  Pose2 slow;
  for (int i = 0; i < 10000; ++i) {
    const double mid = slow.yaw + twist.angular * 0.5e-4;
    slow = {slow.x + twist.linear * 1e-4 * std::cos(mid), slow.y + twist.linear * 1e-4 * std::sin(mid),
            wrap_angle(slow.yaw + twist.angular * 1e-4)};
  }
  const Pose2 exact = integrate({}, twist, 1.0);
  EXPECT_NEAR(exact.x, slow.x, 1e-8);
  EXPECT_NEAR(exact.y, slow.y, 1e-8);
  EXPECT_NEAR(exact.yaw, slow.yaw, 1e-10);
}

TEST(Integrate, is_a_straight_line_without_rotation) {
  const Pose2 end = integrate({1, 2, pi / 2}, {0.5, 0}, 2.0);
  EXPECT_NEAR(end.x, 1, 1e-15);
  EXPECT_NEAR(end.y, 3, 1e-15);
}

}  // namespace
}  // namespace lfdcore
