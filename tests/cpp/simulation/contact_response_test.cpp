#include "lfdcore/simulation/contact_response.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

/// 6 x 6 m of free floor within walls, with blocks if asked.
SolidMap room(std::mt19937* blocks = nullptr) {
  OccupancyGrid grid({120, 120, 0.05, 0, 0}, occupied_cell);
  grid.data.block(1, 1, 118, 118) = free_cell;
  for (int i = 0; blocks && i < 12; ++i) {
    std::uniform_int_distribution<int> where(1, 100), size(1, 15);
    grid.data.block(where(*blocks), where(*blocks), size(*blocks), size(*blocks)) = occupied_cell;
  }
  return SolidMap(grid, true);
}

double energy(const BodyVelocity& v, const ContactConfig& contact) {
  return v.twist.linear * v.twist.linear + contact.skid_resistance * v.skid * v.skid +
         std::pow(contact.gyration_radius * v.twist.angular, 2);
}

BodyMotion drive(const SolidMap& map, BodyMotion motion, const BodyVelocity& velocity, int sub_steps) {
  for (int i = 0; i < sub_steps; ++i) motion = move_body(map, {}, motion.pose, velocity, 0.02);
  return motion;
}

TEST(MoveBody, follows_the_exact_arc_where_nothing_is_in_the_way) {
  const BodyMotion motion = move_body(room(), {}, {3, 3, 0.4}, {{0.7, -0.5}, 0}, 0.02);
  const Pose2 arc = integrate({3, 3, 0.4}, {0.7, -0.5}, 0.02);
  EXPECT_EQ(motion.pose.x, arc.x);
  EXPECT_EQ(motion.pose.y, arc.y);
  EXPECT_EQ(motion.pose.yaw, arc.yaw);
  EXPECT_FALSE(motion.blocked);
  EXPECT_NEAR(motion.distance, 0.014, 1e-15);
}

TEST(MoveBody, stops_with_its_nose_at_a_wall_met_head_on) {
  const BodyMotion end = drive(room(), {{4.9, 3, 0}, {}}, {{1, 0}, 0}, 30);
  EXPECT_TRUE(end.blocked);
  EXPECT_NEAR(end.pose.x + 0.80, 5.95, 1e-4);
  EXPECT_NEAR(end.pose.y, 3, 1e-12);
  EXPECT_NEAR(end.pose.yaw, 0, 1e-12);
  EXPECT_NEAR(end.velocity.twist.linear, 0, 1e-3);
}

TEST(MoveBody, slides_along_a_wall_met_at_a_slant_and_turns_parallel_to_it) {
  const BodyMotion end = drive(room(), {{2, 5.2, 0.3}, {}}, {{0.8, 0}, 0}, 125);
  EXPECT_GT(end.pose.x, 3.5);
  EXPECT_LT(std::abs(end.pose.yaw), 0.1);
  EXPECT_LT(5.95 - end.pose.y - 0.35, 0.1);
}

TEST(MoveBody, is_slowed_more_by_a_rougher_wall) {
  ChairConfig smooth, rough;
  smooth.contact.friction = 0;
  rough.contact.friction = 0.8;
  const SolidMap map = room();
  BodyMotion at_wall{{3, 5.2, 0.3}, {}};
  while (!at_wall.blocked) at_wall = move_body(map, smooth, at_wall.pose, {{0.8, 0}, 0}, 0.02);
  const double smooth_speed = move_body(map, smooth, at_wall.pose, {{0.8, 0}, 0}, 0.02).velocity.twist.linear;
  const double rough_speed = move_body(map, rough, at_wall.pose, {{0.8, 0}, 0}, 0.02).velocity.twist.linear;
  EXPECT_GT(rough_speed, 0.2);
  EXPECT_LT(rough_speed, smooth_speed - 0.02);
}

TEST(MoveBody, never_ends_touching_and_never_gains_energy) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0.5, 5.5), yaw(-pi, pi), linear(-0.6, 1.2), angular(-1.5, 1.5);
  std::normal_distribution<double> skid(0, 0.1);
  int blocked = 0;
  for (int trial = 0; trial < 160; ++trial) {
    const SolidMap map = room(&random);
    Pose2 pose{x(random), x(random), yaw(random)};
    if (map.touches(pose, {})) continue;
    BodyVelocity driven{{linear(random), angular(random)}, skid(random)};
    for (int i = 0; i < 100; ++i) {
      if (i % 25 == 0) driven = {{linear(random), angular(random)}, skid(random)};
      const BodyMotion motion = move_body(map, {}, pose, driven, 0.02);
      ASSERT_FALSE(map.touches(motion.pose, {}));
      EXPECT_LE(energy(motion.velocity, {}), energy(driven, {}) * (1 + 1e-9));
      blocked += motion.blocked;
      pose = motion.pose;
    }
  }
  EXPECT_GT(blocked, 200);
}

TEST(MoveBody, leaves_a_wall_on_the_left_as_one_on_the_right) {
  const SolidMap map = room();
  const BodyMotion left = drive(map, {{2, 5.2, 0.3}, {}}, {{0.8, 0}, 0}, 60);
  const BodyMotion right = drive(map, {{2, 0.8, -0.3}, {}}, {{0.8, 0}, 0}, 60);
  EXPECT_NEAR(left.pose.x, right.pose.x, 0.02);
  EXPECT_NEAR(left.pose.y, 6 - right.pose.y, 0.02);
  EXPECT_NEAR(left.pose.yaw, -right.pose.yaw, 0.02);
}

}  // namespace
}  // namespace lfdcore
