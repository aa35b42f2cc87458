#include "lfdcore/grid/laser_scan.hpp"

#include <algorithm>

#include "lfdcore/error.hpp"

namespace lfdcore {

void require_range_limits(double range_min, double range_max) {
  require_between("scan range_min", range_min, 0, 1e3, "m");
  require_positive("scan range_max", range_max, "m");
  if (range_max > range_min) return;
  throw std::invalid_argument("scan range_max is " + std::to_string(range_max) + " m, must exceed range_min, " +
                              std::to_string(range_min) + " m");
}

void validate(const LaserScan& scan) {
  require_finite("scan angle_min", scan.angle_min, "rad");
  require_finite("scan angle_increment", scan.angle_increment, "rad");
  require(scan.angle_increment != 0, "scan angle_increment is 0 rad, must not be 0");
  require_finite("angle of the scan's last beam", scan.angle(std::max<std::size_t>(scan.ranges.size(), 1) - 1), "rad");
  require_range_limits(scan.range_min, scan.range_max);
}

}  // namespace lfdcore
