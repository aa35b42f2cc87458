// Pure pursuit of a path (App. E.1).
#pragma once

#include "lfdcore/geometry.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

/// The point that is steered for, and the command that leads there along an arc.
struct PurePursuitResult {
  Eigen::Vector2d control_point;  ///< in the robot's frame [m]
  Twist2 twist;
  double arc_length;  ///< of the control point along the path [m]
  bool at_end;        ///< the control point is the path's end
};

/// Path (N, 2) in base_link. Throws std::invalid_argument for an empty path or one that is not finite.
PurePursuitResult pure_pursuit(const Path& path, double look_ahead, double linear, double max_angular);

/// The same with the robot at `pose` in the path's frame.
PurePursuitResult pure_pursuit(const Path& path, const Pose2& pose, double look_ahead, double linear,
                               double max_angular);

}  // namespace lfdcore
