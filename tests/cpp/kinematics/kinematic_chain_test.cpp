#include "lfdcore/kinematics/kinematic_chain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <numbers>
#include <random>

#include "baxter.hpp"

namespace lfdcore {
namespace {

using test::baxter;
using test::random_joints;

/// Baxter's left arm put together by hand from the published numbers, with KDL's own types.
KDL::Chain left_arm_by_hand() {
  constexpr double half = std::numbers::pi / 2;
  const auto segment = [](double x, double y, double z, double roll, double pitch, double yaw, bool moves) {
    const KDL::Frame F(KDL::Rotation::RPY(roll, pitch, yaw), KDL::Vector(x, y, z));
    const KDL::Joint joint =
        moves ? KDL::Joint("j", F.p, F.M * KDL::Vector(0, 0, 1), KDL::Joint::RotAxis) : KDL::Joint(KDL::Joint::Fixed);
    return KDL::Segment(joint, F);
  };
  KDL::Chain chain;
  chain.addSegment(segment(0.024645, 0.219645, 0.118588, 0, 0, 0.7854, false));
  chain.addSegment(segment(0.055695, 0, 0.011038, 0, 0, 0, true));
  chain.addSegment(segment(0.069, 0, 0.27035, -half, 0, 0, true));
  chain.addSegment(segment(0.102, 0, 0, half, 0, half, true));
  chain.addSegment(segment(0.069, 0, 0.26242, -half, -half, 0, true));
  chain.addSegment(segment(0.10359, 0, 0, half, 0, half, true));
  chain.addSegment(segment(0.01, 0, 0.2707, -half, -half, 0, true));
  chain.addSegment(segment(0.115975, 0, 0, half, 0, half, true));
  chain.addSegment(segment(0, 0, 0.11355 + 0.025 + 0.1327, 0, 0, 0, false));
  return chain;
}

TEST(KinematicChain, forward_equals_kdl_on_the_arm_put_together_by_hand) {
  const KinematicChain chain = baxter().chain("base", "left_gripper");
  const KDL::Chain by_hand = left_arm_by_hand();
  KDL::ChainFkSolverPos_recursive solver(by_hand);
  std::mt19937 generator(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::VectorXd q = random_joints(chain, generator);
    KDL::JntArray joints(7);
    joints.data = q;
    KDL::Frame wanted;
    solver.JntToCart(joints, wanted);
    const Eigen::Isometry3d T = chain.forward(q);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(T(row, 3), wanted.p(row), 1e-9);
      for (int column = 0; column < 3; ++column) EXPECT_NEAR(T(row, column), wanted.M(row, column), 1e-9);
    }
  }
}

TEST(KinematicChain, its_jacobian_is_the_slope_of_forward) {
  const KinematicChain chain = baxter().chain("left_gripper", "right_gripper");  // up one arm and down the other
  ASSERT_EQ(chain.size(), 14);
  std::mt19937 generator(2);
  const Eigen::VectorXd q = random_joints(chain, generator);
  const auto J = chain.jacobian(q);
  constexpr double h = 1e-6;
  for (int i = 0; i < chain.size(); ++i) {
    Eigen::VectorXd up = q, down = q;
    up[i] += h;
    down[i] -= h;
    const Eigen::Isometry3d a = chain.forward(up), b = chain.forward(down);
    const Eigen::Vector3d turn = rotation_vector(a.linear() * b.linear().transpose()) / (2 * h);
    EXPECT_LT((J.col(i).head<3>() - (a.translation() - b.translation()) / (2 * h)).norm(), 1e-8);
    EXPECT_LT((J.col(i).tail<3>() - turn).norm(), 1e-8);
  }
}

TEST(KinematicChain, up_one_arm_and_down_the_other_equals_the_trees_poses) {
  const RobotModel model = baxter();
  const KinematicChain chain = model.chain("left_gripper", "right_gripper");
  std::mt19937 generator(3);
  const Eigen::VectorXd q = random_joints(chain, generator);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(15);
  const auto indices = model.joint_indices(chain.joint_names());
  for (int i = 0; i < 14; ++i) all[indices[static_cast<std::size_t>(i)]] = q[i];
  const auto poses = model.forward(all);
  const auto at = [&](const char* name) {
    const auto& names = model.link_names();
    return poses[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
  };
  EXPECT_LT((chain.forward(q).matrix() - (at("left_gripper").inverse() * at("right_gripper")).matrix()).norm(), 1e-12);
}

TEST(RotationVector, is_right_from_no_turn_to_half_a_turn) {
  for (const double angle : {0.0, 1e-9, 1e-4, 1.0, 3.0, std::numbers::pi - 1e-5, std::numbers::pi - 1e-9}) {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
    const Eigen::Vector3d found = rotation_vector(Eigen::AngleAxisd(angle, axis).toRotationMatrix());
    EXPECT_LT((found - angle * axis).norm(), 1e-7) << angle;
  }
}

}  // namespace
}  // namespace lfdcore
