// What would happen: the chair's body followed ahead in time, along a pursued path or under a constant command.
#pragma once

#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/motion.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

struct FootprintRolloutConfig {
  double look_ahead = 0.8;  ///< of the pursuit [m] (Sec. 3.4.3)
  double linear = 0.5;      ///< speed wanted along the path [m/s]
  double duration = 8.0;    ///< how far ahead in time [s]
  double step = 0.1;        ///< between commands [s]
};

/// Throws std::invalid_argument, naming the field, for values that are not positive or more than 10000 steps.
void validate(const FootprintRolloutConfig& config);

struct FootprintRollout {
  PosePath poses;          ///< (T, 3) x, y [m], yaw [rad] each step from the start on, in the start's base_link
  double time_to_contact;  ///< [s], infinity if there is none
  double min_clearance;    ///< least distance [m] of the footprint at these poses from a point, 0 at a contact
  bool reached_end;        ///< the chair came to the path's end
};

/// Follows a path (N, 2) [m] in base_link from its origin by pure pursuit (App. E.1), the speeds changing as `limits`
/// allow from `twist` on, braking so as to stop at the path's end. Ends at a contact (the last pose is the one before
/// it), at the path's end or after `duration`. The contact test is conservative between steps (first_contact).
/// Throws std::invalid_argument for a path that is empty or not finite and for bad limits or config.
FootprintRollout rollout_pursuit(const Path& path, const ObstaclePoints& obstacles, const Footprint& footprint,
                                 const MotionLimits& limits, const Twist2& twist,
                                 const FootprintRolloutConfig& config = {});

/// Time [s] until a body that keeps `twist` from base_link's origin touches a point, infinity if not within `horizon`
/// [s]; never later than the true contact. Throws std::invalid_argument for a bad twist or horizon.
double time_to_contact(const Twist2& twist, const ObstaclePoints& obstacles, const Footprint& footprint,
                       double horizon);

}  // namespace lfdcore
