#include "lfdcore/kinematics/kinematic_chain.hpp"

#include <algorithm>
#include <cmath>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

/// T := T * (motion of a joint about or along its z axis).
void move(Eigen::Isometry3d& T, const ChainJoint& joint, double q) {
  if (joint.prismatic) {
    T.translation() += q * T.linear().col(2);
    return;
  }
  const double c = std::cos(q), s = std::sin(q);
  const Eigen::Vector3d x = T.linear().col(0), y = T.linear().col(1);
  T.linear().col(0) = c * x + s * y;
  T.linear().col(1) = c * y - s * x;
}

}  // namespace

KinematicChain::KinematicChain(std::vector<ChainJoint> joints, const Eigen::Isometry3d& T_last_tool)
    : joints_(std::move(joints)), T_last_tool_(T_last_tool) {
  require(!joints_.empty(), "a kinematic chain needs at least one movable joint between its base and its tip");
  require(size() <= max_chain_joints, "a kinematic chain of " + std::to_string(size()) + " joints: at most " +
                                          std::to_string(max_chain_joints) + " are supported");
  lower_.resize(size());
  upper_.resize(size());
  velocity_.resize(size());
  for (int i = 0; i < size(); ++i) {
    const JointLimits& limits = joints_[static_cast<std::size_t>(i)].limits;
    lower_[i] = limits.lower;
    upper_[i] = limits.upper;
    velocity_[i] = limits.velocity;
    if (i > 0) reach_ += joints_[static_cast<std::size_t>(i)].T_last_joint.translation().norm();
    if (joints_[static_cast<std::size_t>(i)].prismatic) reach_ += std::max(-limits.lower, limits.upper);
  }
  root_ = joints_.front().T_last_joint.translation();
  reach_ += T_last_tool_.translation().norm();
}

std::vector<std::string> KinematicChain::joint_names() const {
  std::vector<std::string> names;
  for (const ChainJoint& joint : joints_) names.push_back(joint.name);
  return names;
}

void KinematicChain::require_joints(const Eigen::VectorXd& q, const std::string& name) const {
  if (q.size() != size())
    throw std::invalid_argument(name + " has " + std::to_string(q.size()) + " values, must have one for each of the " +
                                std::to_string(size()) + " joints");
  require(q.allFinite(), "a value of " + name + " is not finite");
}

Eigen::Isometry3d KinematicChain::forward(const Eigen::VectorXd& q) const {
  require_joints(q, "q");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < size(); ++i) {
    const ChainJoint& joint = joints_[static_cast<std::size_t>(i)];
    T = T * joint.T_last_joint;
    move(T, joint, q[i]);
  }
  return T * T_last_tool_;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> KinematicChain::jacobian(const Eigen::VectorXd& q) const {
  require_joints(q, "q");
  ChainJacobian found;
  evaluate(q, found);
  return found;
}

Eigen::Isometry3d KinematicChain::evaluate(const JointVector& q, ChainJacobian& jacobian) const {
  jacobian.resize(6, size());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < size(); ++i) {
    const ChainJoint& joint = joints_[static_cast<std::size_t>(i)];
    T = T * joint.T_last_joint;
    jacobian.col(i).head<3>() = T.translation();
    jacobian.col(i).tail<3>() = T.linear().col(2);
    move(T, joint, q[i]);
  }
  T = T * T_last_tool_;
  for (int i = 0; i < size(); ++i) {
    const Eigen::Vector3d axis = jacobian.col(i).tail<3>();
    if (joints_[static_cast<std::size_t>(i)].prismatic) {
      jacobian.col(i) << axis, Eigen::Vector3d::Zero();
    } else {
      const Eigen::Vector3d arm = T.translation() - jacobian.col(i).head<3>();
      jacobian.col(i).head<3>() = axis.cross(arm);
    }
  }
  return T;
}

Eigen::Isometry3d rigid_transform(const Eigen::Matrix4d& matrix, const std::string& name) {
  require(matrix.allFinite(), "a value of " + name + " is not finite");
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool orthonormal = (rotation.transpose() * rotation).isIdentity(1e-6) && rotation.determinant() > 0;
  const bool rigid = orthonormal && (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < 1e-6;
  require(rigid, name + " is no rigid transform: its rotation must be orthonormal to 1e-6, its last row 0 0 0 1");
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = rotation;
  transform.translation() = matrix.topRightCorner<3, 1>();
  return transform;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sine = 0.5 * twice_sine.norm(), cosine = 0.5 * (R.trace() - 1);
  if (cosine < -0.9) {  // near half a turn the sine says little about the axis; the quaternion's own formula does
    const Eigen::AngleAxisd turn(R);
    return turn.angle() * turn.axis();
  }
  return sine > 1e-6 ? Eigen::Vector3d(twice_sine * (0.5 * std::atan2(sine, cosine) / sine))
                     : Eigen::Vector3d(0.5 * twice_sine);
}

}  // namespace lfdcore
