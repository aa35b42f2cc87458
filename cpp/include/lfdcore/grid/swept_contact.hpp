// Contact of a moving rectangular body with obstacle points, checked so that nothing is skipped between poses.
#pragma once

#include <optional>

#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore {

/// Gaps below this count as contact [m]: where the bisection of a motion ends.
inline constexpr double sweep_tolerance = 0.005;

/// The rectangle, in the frame of a motion's middle pose, that holds the footprint all along an arc of `distance` [m]
/// turning by `turn` [rad]. Half a motion moves a body point (x, y) by at most distance/2 + |y| turn/2 ahead and
/// |x| turn/2 + distance/2 * turn/4 sideways (sin a <= a).
Footprint swept(const Footprint& footprint, double distance, double turn);

/// Earliest time [s] within `duration` at which a body that follows `twist` from `pose` touches a point; none if it
/// does not. Conservative: never later than the true contact, and a gap below `sweep_tolerance` may count as contact.
std::optional<double> first_contact(const ObstaclePoints& obstacles, const Footprint& footprint, const Pose2& pose,
                                    const Twist2& twist, double duration);

}  // namespace lfdcore
