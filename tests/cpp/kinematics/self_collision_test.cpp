#include "lfdcore/kinematics/self_collision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "baxter.hpp"

namespace lfdcore {
namespace {

using test::baxter;

double slow_distance(const Capsule& a, const Capsule& b) {
  double least = 1e9;
  for (int i = 0; i <= 200; ++i)
    for (int j = 0; j <= 200; ++j)
      least = std::min(least, (a.a + i / 200.0 * (a.b - a.a) - b.a - j / 200.0 * (b.b - b.a)).norm());
  return least - a.radius - b.radius;
}

TEST(CapsuleDistance, equals_the_least_over_many_points_also_for_parallel_ones_and_spheres) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<> u(-1, 1);
  const auto point = [&] { return Eigen::Vector3d(u(generator), u(generator), u(generator)); };
  for (int i = 0; i < 60; ++i) {
    Capsule a{0, point(), point(), 0.1}, b{0, point(), point(), 0.05};
    if (i % 4 == 1) b.b = b.a + 0.7 * (a.b - a.a);
    if (i % 4 == 2) a.b = a.a;
    if (i % 4 == 3) a.b = a.a, b.b = b.a;
    EXPECT_NEAR(capsule_distance(a, b), slow_distance(a, b), 1e-3) << i;
    EXPECT_LE(capsule_distance(a, b), slow_distance(a, b) + 1e-12);
    EXPECT_NEAR(capsule_distance(a, b), capsule_distance(b, a), 1e-9);
  }
}

TEST(SelfCollision, sees_an_arm_at_the_head_and_compares_both_arms) {
  const SelfCollision robot(baxter());
  const auto& names = robot.model().link_names();
  const auto compares = [&](const std::string& a, const std::string& b) {
    return std::any_of(robot.pairs().begin(), robot.pairs().end(), [&](const auto& pair) {
      const auto &first = names[static_cast<std::size_t>(pair.first)],
                 &second = names[static_cast<std::size_t>(pair.second)];
      return (first == a && second == b) || (first == b && second == a);
    });
  };
  EXPECT_TRUE(compares("left_upper_forearm", "right_upper_forearm"));
  EXPECT_TRUE(compares("head", "left_upper_elbow"));
  EXPECT_FALSE(compares("left_upper_shoulder", "left_upper_elbow"));  // two joints apart
  Eigen::VectorXd q = Eigen::VectorXd::Zero(15);
  EXPECT_GT(robot.distance(q).distance, 0.1);
  q[robot.model().joint_indices({"left_s0"})[0]] = 0.7;  // across the chest, forearm folded back to the head
  q[robot.model().joint_indices({"left_s1"})[0]] = -1.2;
  q[robot.model().joint_indices({"left_e1"})[0]] = 2.5;
  q[robot.model().joint_indices({"left_e0"})[0]] = 1.6;
  EXPECT_LT(robot.distance(q).distance, 0.1);
}

}  // namespace
}  // namespace lfdcore
