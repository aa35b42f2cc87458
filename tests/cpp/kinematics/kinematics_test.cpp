#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <numbers>
#include <random>

#include "lfdcore/error.hpp"
#include "lfdcore/kinematics/joint_trajectory.hpp"

namespace lfdcore {
namespace {

RobotModel baxter() { return RobotModel::from_urdf_file(LFDCORE_URDF); }

Eigen::VectorXd random_joints(const KinematicChain& chain, std::mt19937& generator) {
  Eigen::VectorXd q(chain.size());
  for (int i = 0; i < chain.size(); ++i)
    q[i] = std::uniform_real_distribution<>(chain.lower()[i], chain.upper()[i])(generator);
  return q;
}

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

TEST(KinematicChain, ForwardEqualsKdlOnTheArmPutTogetherByHand) {
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

TEST(KinematicChain, JacobianIsTheSlopeOfForward) {
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

TEST(KinematicChain, AChainUpAndDownEqualsTheTreesPoses) {
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

TEST(RotationVector, IsRightFromNoTurnToHalfATurn) {
  for (const double angle : {0.0, 1e-9, 1e-4, 1.0, 3.0, std::numbers::pi - 1e-5, std::numbers::pi - 1e-9}) {
    const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
    const Eigen::Vector3d found = rotation_vector(Eigen::AngleAxisd(angle, axis).toRotationMatrix());
    EXPECT_LT((found - angle * axis).norm(), 1e-7) << angle;
  }
}

TEST(InverseKinematics, SolvesRandomReachablePosesInsideTheLimitsWithoutASeed) {
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

TEST(InverseKinematics, ReturnsTheNearestPostureForAPoseBeyondTheStretchedArm) {
  const InverseKinematics solver(baxter().chain("base", "left_gripper"));
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation() << 3, 0, 0;
  const auto result = solver.solve(far);
  EXPECT_FALSE(result.solved);
  EXPECT_EQ(result.restarts, 0);
  EXPECT_GT(result.position_error, 1.0);
  EXPECT_TRUE(result.joints.allFinite());
}

double slow_distance(const Capsule& a, const Capsule& b) {
  double least = 1e9;
  for (int i = 0; i <= 200; ++i)
    for (int j = 0; j <= 200; ++j)
      least = std::min(least, (a.a + i / 200.0 * (a.b - a.a) - b.a - j / 200.0 * (b.b - b.a)).norm());
  return least - a.radius - b.radius;
}

TEST(CapsuleDistance, EqualsTheLeastOverManyPointsAlsoForParallelOnesAndSpheres) {
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

TEST(SelfCollision, SeesAnArmAtTheHeadAndComparesBothArms) {
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

TEST(SlowDown, KeepsEveryChordInsideTheLimitsAndLeavesSlowOnesAlone) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0, 1);
  RowMatrix positions(101, 2);
  for (int i = 0; i < 101; ++i) positions.row(i) << std::exp(-50 * (time[i] - 0.5) * (time[i] - 0.5)), 0.1 * time[i];
  const Eigen::Vector2d limits(2, 1);
  const Eigen::VectorXd slowed = slow_down(time, positions, limits, 0.05);
  const RowMatrix velocities = joint_velocities(slowed, positions);
  EXPECT_LE(velocities.col(0).cwiseAbs().maxCoeff(), 2 + 1e-9);
  EXPECT_LE(velocities.col(1).cwiseAbs().maxCoeff(), 1 + 1e-9);
  EXPECT_NEAR(slowed[1] - slowed[0], 0.01, 1e-12);
  EXPECT_GT(slowed[100], 1.1);
  EXPECT_TRUE(slow_down(time, positions, Eigen::Vector2d(100, 100), 0.05).isApprox(time));
}

TEST(SlowDown, RefusesTimesThatDoNotIncreaseAndLimitsOfZero) {
  const RowMatrix positions = RowMatrix::Zero(2, 1);
  EXPECT_THROW(slow_down(Eigen::Vector2d(1, 1), positions, Eigen::VectorXd::Ones(1)), std::invalid_argument);
  EXPECT_THROW(slow_down(Eigen::Vector2d(0, 1), positions, Eigen::VectorXd::Zero(1)), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
