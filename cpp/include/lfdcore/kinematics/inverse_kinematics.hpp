// Joint positions inside their limits that bring a chain's tool to a pose: damped least squares with restarts.
#pragma once

#include <optional>

#include "lfdcore/kinematics/kinematic_chain.hpp"

namespace lfdcore {

struct InverseKinematicsConfig {
  double position_tolerance = 1e-5;  ///< of a solution [m]
  double rotation_tolerance = 1e-5;  ///< of a solution [rad]
  int iterations = 60;               ///< at most, of one descent
  int restarts = 1500;               ///< descents at most, besides that from a seed; 0: only from the seed
  int postures = 4096;               ///< fixed ones that restarts are chosen from
  double damping = 0.01;             ///< times the squared error, of the normal equations
};

/// Throws std::invalid_argument, naming the field, the bound and the unit.
void validate(const InverseKinematicsConfig& config);

struct InverseKinematicsResult {
  bool solved = false;
  Eigen::VectorXd joints;     ///< (n,) inside the limits; unless solved, the nearest that was met
  double position_error = 0;  ///< [m]
  double rotation_error = 0;  ///< [rad]
  int restarts = 0;           ///< descents made after the first
  int iterations = 0;         ///< of all descents together
};

/// A solver for one chain. Descents are Levenberg-Marquardt's with damping in proportion to the squared error (Sugihara
/// 2011, the rule of Chan and Lawrence), joints that would leave their limits held at them and the rest solved again.
/// Restarts begin at those of a fixed set of postures (mid-range and Halton's points of the joint space, whatever the
/// pose) whose tools are nearest to the pose. Deterministic; solve() may be called from several threads at once.
class InverseKinematics {
 public:
  /// Computes the postures' poses, about 1 ms for 4096 of a 7-joint arm.
  explicit InverseKinematics(KinematicChain chain, const InverseKinematicsConfig& config = {});

  const KinematicChain& chain() const { return chain_; }
  const InverseKinematicsConfig& config() const { return config_; }

  /// From `seed` (n,) first, where one is given (brought inside the limits), then by restarts; beyond the length of the
  /// stretched arm one descent must do. Throws std::invalid_argument for a pose that is not finite or a seed of another
  /// length.
  InverseKinematicsResult solve(const Eigen::Isometry3d& T_base_tool,
                                const std::optional<Eigen::VectorXd>& seed = std::nullopt) const;

  /// One descent, from q (n,) inside the limits; unchecked.
  InverseKinematicsResult descend(const Eigen::Isometry3d& T_base_tool, const JointVector& q) const;

  /// The fixed postures whose tools are nearest to the pose, nearest first, at most `count`.
  std::vector<JointVector> postures_near(const Eigen::Isometry3d& T_base_tool, int count) const;

 private:
  class Ranking;
  JointVector posture(int index) const;

  KinematicChain chain_;
  InverseKinematicsConfig config_;
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic> postures_;  ///< (postures, n)
  Eigen::Matrix<float, Eigen::Dynamic, 12> features_;              ///< (postures, 12) of their tools' poses
};

/// One pose with a solver of its own; see InverseKinematics.
InverseKinematicsResult solve_inverse_kinematics(const KinematicChain& chain, const Eigen::Isometry3d& T_base_tool,
                                                 const InverseKinematicsConfig& config = {},
                                                 const std::optional<Eigen::VectorXd>& seed = std::nullopt);

}  // namespace lfdcore
