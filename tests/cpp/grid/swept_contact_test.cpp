#include "lfdcore/grid/swept_contact.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

TEST(Swept, rectangle_in_the_middle_pose_holds_every_corner_all_along_the_motion) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Footprint body;
  for (int i = 0; i < 500; ++i) {
    const Twist2 motion{0.5 * unit(random), unit(random)};
    const Footprint held = swept(body, motion.linear, motion.angular);
    const Pose2 to_middle = integrate({}, motion, 0.5).inverse();
    for (int step = 0; step <= 20; ++step) {
      const Pose2 pose = to_middle * integrate({}, motion, step / 20.0);
      for (const Eigen::Vector2d& corner : body.corners()) {
        const Eigen::Vector2d p = pose * corner;
        EXPECT_LE(p.x(), held.front + 1e-12);
        EXPECT_GE(p.x(), -held.rear - 1e-12);
        EXPECT_LE(std::abs(p.y()), held.half_width + 1e-12);
      }
    }
  }
}

TEST(FirstContact, is_now_for_a_body_that_holds_a_point_and_never_without_points) {
  Path inside(1, 2);
  inside << 0.1, 0.1;
  EXPECT_EQ(first_contact(ObstaclePoints(inside), {}, {}, {0.5, 0.2}, 2.0).value(), 0.0);
  EXPECT_FALSE(first_contact(ObstaclePoints(), {}, {}, {0.5, 0.2}, 2.0).has_value());
}

TEST(FirstContact, sees_a_point_that_two_poses_far_apart_would_step_over) {
  Path post(1, 2);
  post << 3.0, 0.0;
  const auto hit = first_contact(ObstaclePoints(post), {}, {}, {5.0, 0.0}, 2.0);  // 0 m and 10 m: both free
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(*hit, (3.0 - 0.8) / 5.0, 0.01);
  EXPECT_LE(*hit, (3.0 - 0.8) / 5.0);
}

}  // namespace
}  // namespace lfdcore
