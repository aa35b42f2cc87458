#include "lfdcore/kinematics/inverse_kinematics.hpp"

#include <gtest/gtest.h>

#include <random>

#include "baxter.hpp"

namespace lfdcore {
namespace {

using test::baxter;
using test::random_joints;

TEST(InverseKinematics, solves_random_reachable_poses_inside_the_limits_without_a_seed) {
  for (const char* tip : {"left_gripper", "right_gripper"}) {
    const InverseKinematics solver(baxter().chain("base", tip));
    const KinematicChain& chain = solver.chain();
    std::mt19937 generator(4);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Isometry3d wanted = chain.forward(random_joints(chain, generator));
      const auto result = solver.solve(wanted);
      ASSERT_TRUE(result.solved) << tip << i;
      EXPECT_TRUE((result.joints.array() >= chain.lower().array()).all());
      EXPECT_TRUE((result.joints.array() <= chain.upper().array()).all());
      const Eigen::Isometry3d reached = chain.forward(result.joints);
      EXPECT_LT((reached.translation() - wanted.translation()).norm(), 1.1e-5);
      EXPECT_LT(Eigen::AngleAxisd(reached.linear().transpose() * wanted.linear()).angle(), 1.1e-5);
    }
  }
}

TEST(InverseKinematics, returns_the_nearest_posture_for_a_pose_beyond_the_stretched_arm) {
  const InverseKinematics solver(baxter().chain("base", "left_gripper"));
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation() << 3, 0, 0;
  const auto result = solver.solve(far);
  EXPECT_FALSE(result.solved);
  EXPECT_EQ(result.restarts, 0);
  EXPECT_GT(result.position_error, 1.0);
  EXPECT_TRUE(result.joints.allFinite());
}

}  // namespace
}  // namespace lfdcore
