// Exact distances along rays to the occupied cells of a grid.
#pragma once

#include <span>

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

class RayCaster {
 public:
  /// Throws std::invalid_argument unless range_max [m] is positive and finite.
  RayCaster(const OccupancyGrid& grid, double range_max);

  /// Distance [m] from the laser to the first occupied cell along `angle` [rad, laser frame]; infinity if there is none
  /// within range_max; 0 from inside an occupied cell.
  float cast(const Pose2& T_map_laser, double angle) const;

  /// The same for ranges.size() beams from angle_min on [rad].
  void cast(const Pose2& T_map_laser, double angle_min, double angle_increment, std::span<float> ranges) const;

 private:
  GridGeometry geometry_;
  Mask occupied_;
  double range_max_;
};

}  // namespace lfdcore
