// One damped step of joint positions towards a wanted motion of the tool, inside the joints' limits.
#pragma once

#include "lfdcore/kinematics/kinematic_chain.hpp"

namespace lfdcore {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Least (J dq - wanted)^2 + damping dq^2; joints that this would take past lower or upper stop there and the others
/// are solved again for what is left.
JointVector bounded_step(const ChainJacobian& J, const Vector6& wanted, double damping, const JointVector& q,
                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);

/// Translation [m] and rotation vector [rad] from `is` to `wanted`, in the base frame.
Vector6 pose_error(const Eigen::Isometry3d& wanted, const Eigen::Isometry3d& is);

}  // namespace lfdcore
