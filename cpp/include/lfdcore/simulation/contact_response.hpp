// How a rectangular body moves when something is in its way: it stops, slides, turns and skids as far as it is free to.
#pragma once

#include "lfdcore/simulation/differential_drive.hpp"
#include "lfdcore/simulation/solid_map.hpp"

namespace lfdcore {

/// How the body moves: its wheels' twist, and sideways [m/s] where a contact pushes it across its wheels.
struct BodyVelocity {
  Twist2 twist;
  double skid = 0;
};

struct BodyMotion {
  Pose2 pose;             ///< after the motion, never touching anything
  BodyVelocity velocity;  ///< averaged over the motion
  double distance = 0;    ///< that the axle's centre moved [m]
  bool blocked = false;   ///< something was in the way
  Pose2 blocked_pose;     ///< where the body would have touched; only if blocked
};

/// The body's motion from `pose`, where it touches nothing, when driven for a short `duration` [s].
///
/// If the whole arc is free, that. Else the largest free part of it, and for the rest Gauss's principle of least
/// constraint: of the motions that are free, the one nearest to the driven one in the metric of kinetic energy, where
/// wheels roll (linear), turn (angular) and, pushed hard, skid sideways; slowed by Coulomb's friction. So a corner that
/// meets a wall at a slant slides along it and turns the body parallel to it, and a body that lies along a wall can
/// still turn away. A contact never adds energy.
BodyMotion move_body(const SolidMap& map, const ChairConfig& chair, const Pose2& pose, const BodyVelocity& driven,
                     double duration);

}  // namespace lfdcore
