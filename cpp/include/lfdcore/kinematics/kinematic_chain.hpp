// A serial chain of joints: forward kinematics and Jacobian without allocation.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace lfdcore {

/// A chain's joints fit on the stack up to this number.
inline constexpr int max_chain_joints = 32;
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_chain_joints, 1>;
using ChainJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, max_chain_joints>;

/// Position [rad or m] and speed [rad/s or m/s]; a continuous joint's position bounds are -inf and inf, and so is the
/// speed of one whose description says none.
struct JointLimits {
  double lower = 0;
  double upper = 0;
  double velocity = 0;
};

/// One movable joint: it turns about (or slides along) the z axis of its own frame.
struct ChainJoint {
  std::string name;
  JointLimits limits;
  bool prismatic = false;
  Eigen::Isometry3d T_last_joint;  ///< from the last joint's moved frame (the base for the first) to this joint at 0
};

/// Joints from a base link to a tool.
class KinematicChain {
 public:
  /// T_last_tool: the tool in the last joint's moved frame. Throws std::invalid_argument for no or more than
  /// max_chain_joints joints.
  KinematicChain(std::vector<ChainJoint> joints, const Eigen::Isometry3d& T_last_tool);

  int size() const { return static_cast<int>(joints_.size()); }
  std::vector<std::string> joint_names() const;
  const Eigen::VectorXd& lower() const { return lower_; }        ///< (n,) [rad or m]
  const Eigen::VectorXd& upper() const { return upper_; }        ///< (n,) [rad or m]
  const Eigen::VectorXd& velocity() const { return velocity_; }  ///< (n,) [rad/s or m/s]

  /// Where the first joint sits in the base frame, and the farthest that the tool can be from there [m]: a bound, not
  /// always reached.
  const Eigen::Vector3d& root() const { return root_; }
  double reach() const { return reach_; }

  /// T_base_tool at q (n,). Positions outside the limits are computed too. Throws std::invalid_argument for another
  /// length or values that are not finite.
  Eigen::Isometry3d forward(const Eigen::VectorXd& q) const;

  /// (6, n): linear [m/s] then angular [rad/s] velocity of the tool's origin in the base frame by joint velocity.
  /// Throws like forward().
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(const Eigen::VectorXd& q) const;

  /// Both at once and unchecked, for solvers.
  Eigen::Isometry3d evaluate(const JointVector& q, ChainJacobian& jacobian) const;

  /// Throws std::invalid_argument naming `name` unless q is (n,) and finite.
  void require_joints(const Eigen::VectorXd& q, const std::string& name) const;

 private:
  std::vector<ChainJoint> joints_;
  Eigen::Isometry3d T_last_tool_;
  Eigen::VectorXd lower_, upper_, velocity_;
  Eigen::Vector3d root_;
  double reach_ = 0;
};

/// The rigid transform that a (4, 4) matrix stands for. Throws std::invalid_argument naming `name` unless it is finite,
/// its last row 0 0 0 1 and its rotation orthonormal and right-handed to 1e-6.
Eigen::Isometry3d rigid_transform(const Eigen::Matrix4d& matrix, const std::string& name);

/// The rotation vector (axis times angle in [0, pi]) [rad] of a rotation matrix.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);

}  // namespace lfdcore
