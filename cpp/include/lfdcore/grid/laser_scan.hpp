// One sweep of a planar LIDAR, as sensor_msgs/LaserScan.
#pragma once

#include <vector>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

/// Ranges as REP-117 has them: +inf = nothing within range_max, -inf = closer than range_min, NaN = no measurement.
/// A scan without beams is one in which nothing was measured, as a broken scanner gives it.
struct LaserScan {
  std::vector<float> ranges;          ///< [m]
  double angle_min = -pi / 2;         ///< of beam 0, in the laser's frame [rad]
  double angle_increment = pi / 180;  ///< [rad]
  double range_min = 0.0;             ///< [m]
  double range_max = 30.0;            ///< [m]

  double angle(std::size_t beam) const { return angle_min + static_cast<double>(beam) * angle_increment; }
};

/// Throws std::invalid_argument unless 0 <= range_min <= 1000 m and range_min < range_max, which is finite.
void require_range_limits(double range_min, double range_max);

/// Throws std::invalid_argument for a scan with a zero or non-finite increment, or range limits that
/// require_range_limits refuses.
void validate(const LaserScan& scan);

}  // namespace lfdcore
