// What one scan tells about the cells around the robot (Sec. 3.3).
#pragma once

#include "lfdcore/grid/grid.hpp"
#include "lfdcore/grid/laser_scan.hpp"

namespace lfdcore {

/// What one beam saw: free up to `length` [m], and there an obstacle if `hit`.
struct Beam {
  double length = 0;
  bool hit = false;
};

/// A range by REP-117. A finite range in [range_min, range_max) is a hit there. +inf and whatever reaches range_max:
/// free up to range_max. -inf: something is closer than range_min; taken to be at range_min. NaN, and finite ranges
/// below range_min (sensor_msgs: to be discarded): nothing, length 0.
Beam read_beam(const LaserScan& scan, std::size_t index);

/// The window around base_link (100 x 100 cells of 0.05 m) as one scan shows it: the cells along a beam are free, the
/// cell at its end is occupied (which wins over free), all others stay unknown. Only the edges of obstacles are seen.
/// Beams that leave the window are cut there. T_base_laser may lie outside the window.
/// Throws std::invalid_argument for an invalid scan or a pose that is not finite.
OccupancyGrid local_grid(const LaserScan& scan, const Pose2& T_base_laser);

}  // namespace lfdcore
