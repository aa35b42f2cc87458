// The robot that kinematics is tested on, and joint positions of its arms.
#pragma once

#include <random>

#include "lfdcore/kinematics/kinematic_chain.hpp"
#include "lfdcore/kinematics/robot_model.hpp"

namespace lfdcore::test {

inline RobotModel baxter() { return RobotModel::from_urdf_file(LFDCORE_URDF); }

inline Eigen::VectorXd random_joints(const KinematicChain& chain, std::mt19937& generator) {
  Eigen::VectorXd q(chain.size());
  for (int i = 0; i < chain.size(); ++i)
    q[i] = std::uniform_real_distribution<>(chain.lower()[i], chain.upper()[i])(generator);
  return q;
}

}  // namespace lfdcore::test
