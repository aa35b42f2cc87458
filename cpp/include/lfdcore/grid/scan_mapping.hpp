// What the ranges of a scan mean (REP-117), and what one scan tells about the cells around the robot (Sec. 3.3).
#pragma once

#include <span>

#include "lfdcore/grid/grid.hpp"
#include "lfdcore/grid/laser_scan.hpp"

namespace lfdcore {

/// What one beam saw: free up to `length` [m], and there an obstacle if `hit`. Length 0 without a hit: nothing.
struct Beam {
  double length = 0;
  bool hit = false;
};

/// A range by REP-117. A finite range in [range_min, range_max) is a hit there. +inf and whatever reaches range_max:
/// free up to range_max. -inf: something is closer than range_min; taken to be at range_min. NaN, and finite ranges
/// below range_min (sensor_msgs: to be discarded): nothing, length 0. With a range_min of 0, 0 is a hit at the laser.
/// All in [m]; the limits as require_range_limits has them. No other place decides what a range means.
Beam read_beam(double range, double range_min, double range_max);

inline Beam read_beam(const LaserScan& scan, std::size_t index) {
  return read_beam(scan.ranges[index], scan.range_min, scan.range_max);
}

/// read_beam of each of the ranges [m], of one scan or of many: into lengths [m] and hit.
/// Throws std::invalid_argument for limits that require_range_limits refuses and for spans of other lengths.
void read_beams(std::span<const float> ranges, double range_min, double range_max, std::span<double> lengths,
                std::span<bool> hit);

/// The window around base_link (100 x 100 cells of 0.05 m) as one scan shows it: the cells along a beam are free, the
/// cell at its end is occupied (which wins over free), all others stay unknown. Only the edges of obstacles are seen.
/// Beams that leave the window are cut there. T_base_laser may lie outside the window.
/// Throws std::invalid_argument for an invalid scan or a pose that is not finite.
OccupancyGrid local_grid(const LaserScan& scan, const Pose2& T_base_laser);

}  // namespace lfdcore
