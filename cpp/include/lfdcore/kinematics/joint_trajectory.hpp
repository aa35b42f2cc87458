// A whole trajectory of the tool as a trajectory of a chain's joints.
#pragma once

#include "lfdcore/kinematics/inverse_kinematics.hpp"
#include "lfdcore/kinematics/self_collision.hpp"
#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

struct JointTrajectory {
  Eigen::VectorXd time;  ///< (T,) [s], increasing
  RowMatrix positions;   ///< (T, n) [rad or m]
  RowMatrix velocities;  ///< (T, n) [rad/s or m/s]: slopes of the parabola through each sample and its neighbours
};

struct FollowConfig {
  InverseKinematicsConfig inverse_kinematics = {.position_tolerance = 1e-4, .rotation_tolerance = 1e-4};
  double centring = 0.3;         ///< rate at which joints that the tool leaves free tend to mid-range [1/s]
  double clearance = 0.02;       ///< that links must keep from each other [m]
  double avoidance = 0.10;       ///< from this distance of links on, free joints move them apart [m]
  double avoidance_speed = 0.5;  ///< of the free joints' motion where links touch [rad/s]
  double largest_step = 0.3;     ///< of a joint from sample to sample; more counts as a jump [rad or m]
  double velocity_share = 1.0;   ///< of the velocity limits that is used
  double smoothing = 0.2;        ///< slowing down spreads this far to both sides [s]
  int starts = 8;                ///< first postures tried where none is given
};

/// Throws std::invalid_argument, naming the field, the bound and the unit.
void validate(const FollowConfig& config);

enum class FollowOutcome {
  followed,
  out_of_reach,        ///< no posture inside the limits reaches the pose
  no_continuous_path,  ///< postures reach it, but none that follows from the last one without a jump
  self_collision       ///< links come nearer than the clearance, and the free joints cannot help
};

/// The outcome's name, such as "out_of_reach".
const char* to_string(FollowOutcome outcome);

struct FollowResult {
  FollowOutcome outcome = FollowOutcome::followed;
  JointTrajectory trajectory;        ///< unless followed, only the samples before the first failure
  std::optional<int> first_failure;  ///< index of the first pose that could not be followed
  double position_error = 0;         ///< largest [m]
  double rotation_error = 0;         ///< largest [rad]
  double clearance = 0;              ///< smallest distance of links [m]; inf where it was not asked for
  double slowdown = 1;               ///< duration over the wanted duration
  SelfDistance nearest;              ///< the two links at that clearance, or at the failure by self-collision
};

/// Self-collision as one arm sees it: the other joints are where `posture` has them.
struct Surroundings {
  const SelfCollision& robot;
  const RowMatrix& posture;  ///< (1 or T, N) all of the robot's joints; those of the chain are replaced
};

/// Follows poses T_base_tool at `time` (T,) [s] sample by sample from the last posture, by damped least squares inside
/// the position limits; what the pose leaves free tends to mid-range and away from self-collision. Where a joint would
/// be faster than its limit, time is stretched there, smoothly: nothing is clipped, the path stays, it takes longer.
/// From `start` (the first pose's posture is the one found from there), or from the best of several first postures. The
/// tool is only looked at in the samples: they should lie close. Throws std::invalid_argument for fewer than 2 poses,
/// times that do not increase, other lengths, velocity limits of 0 or values that are not finite.
FollowResult follow_poses(const KinematicChain& chain, const Eigen::VectorXd& time,
                          const std::vector<Eigen::Isometry3d>& T_base_tool,
                          const std::optional<Eigen::VectorXd>& start = std::nullopt, const FollowConfig& config = {},
                          const std::optional<Surroundings>& surroundings = std::nullopt);

/// Times (T,) [s], from time[0] on, at which positions (T, n) keep inside velocity limits (n,): each interval takes as
/// long as before or, where that is too fast, longer; stretches spread smoothly over `smoothing` [s] to both sides.
/// Throws std::invalid_argument like follow_poses.
Eigen::VectorXd slow_down(const Eigen::VectorXd& time, const RowMatrix& positions, const Eigen::VectorXd& velocity,
                          double smoothing = 0.2);

/// Slopes (T, n) of the parabolas through each sample and its neighbours, of the chords at the ends; never above the
/// fastest chord. Throws std::invalid_argument like follow_poses.
RowMatrix joint_velocities(const Eigen::VectorXd& time, const RowMatrix& positions);

}  // namespace lfdcore
