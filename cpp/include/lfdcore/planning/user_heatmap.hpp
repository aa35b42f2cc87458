// From the stick that the driver is thought to mean to a heatmap of the window (Sec. 4.4.2).
#pragma once

#include <optional>

#include "lfdcore/planning/movement_template.hpp"

namespace lfdcore {

/// Bounds of the sd of a stick's orientation [rad]. Above, a uniform one's pi / sqrt(3), beyond which 4.2 is useless
/// (ERRATA 26). Below, some 3 degrees: a cell at a look-ahead of 0.8 m spans about 9.
inline constexpr double largest_orientation_sd = pi / 1.7320508075688772, smallest_orientation_sd = 0.05;

/// A stick closer to its centre than this has no orientation [of full stick].
inline constexpr double stick_centre = 1e-6;

/// Mean [rad] and variance [rad^2] of h = arctan2(left, forward): 0 = forward, positive to the left.
struct OrientationMoments {
  double mean = 0, variance = 0;
};

/// Means and variances of a stick's axes, independent of each other [of full stick].
struct StickMoments {
  double forward = 0, left = 0, forward_variance = 0, left_variance = 0;
};

/// Eq. 4.1-4.2 as corrected (ERRATA 25), the variance kept within the bounds above; nothing for a stick at rest. Throws
/// std::invalid_argument for values that are not finite or negative variances.
std::optional<OrientationMoments> joystick_orientation(const StickMoments& stick);

struct UserHeatmap {
  FloatGrid density;  ///< (100, 100): the weights w of Eq. 4.3 [1/rad]
  FloatGrid heatmap;  ///< (100, 100): times the distance filter, divided by the maximum (F12), within [0, 1]
};

/// Eq. 4.3 with the difference of orientations wrapped (ERRATA 27); 0 where less than 2e-35 of the largest. Does not
/// allocate into a result used before. Throws std::invalid_argument for a mean that is not finite or a variance that is
/// not within 1e-6..1e6 rad^2.
void user_heatmap(const MovementTemplate& movement, const OrientationMoments& orientation, UserHeatmap& result);

/// How well a control point (x, y) [m, base_link] complies with the stick, in [0, 1]: the density at the point's exact
/// orientation relative to the peak, without distance filter (ERRATA 29). 1 at the origin, where no way is wrong.
/// Throws as user_heatmap does, and for a point that is not finite.
double compliance(const Eigen::Vector2d& control_point, const OrientationMoments& orientation,
                  const MotionLimits& limits);

}  // namespace lfdcore
