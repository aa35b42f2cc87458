// Pure Pursuit (Coulter 1990; App. E.1, Alg. 7, F10): steer an arc through a point of the path that lies ahead.
#pragma once

#include "lfdcore/geometry.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

struct PurePursuitResult {
  Eigen::Vector2d control_point = Eigen::Vector2d::Zero();  ///< g of Alg. 7, in the robot's frame [m]
  Twist2 twist;                                             ///< [m/s, rad/s]
  double arc_length = 0;                                    ///< of the control point along the path [m]
  bool at_end = false;                                      ///< the control point is the path's end, within look_ahead
};

/// Follows a path (N, 2) [m] given in the robot's frame.
///
/// Control point: where the path, after its point closest to the robot, first leaves the circle of radius `look_ahead`
/// [m]; the path's end if it does not leave it. If the whole path lies farther away than that, its closest point (so
/// that the control point does not jump when the robot drifts off the path).
/// Twist: `linear` [m/s] >= 0 along the arc of curvature 2 g_y / |g|^2 (with the true |g|); where that would turn
/// faster than `max_angular` [rad/s], both are reduced and the arc kept. A control point behind (g_x < 0) is turned to
/// in place at max_angular (unless linear is 0); at the control point the twist is 0.
///
/// Throws std::invalid_argument for an empty or non-finite path, look_ahead or max_angular that are not positive, or a
/// negative or non-finite `linear`.
PurePursuitResult pure_pursuit(const Path& path, double look_ahead, double linear, double max_angular);

/// The same for a robot at `pose` in the path's frame.
PurePursuitResult pure_pursuit(const Path& path, const Pose2& pose, double look_ahead, double linear,
                               double max_angular);

}  // namespace lfdcore
