// Exact distances along rays to the occupied cells of a grid.
#pragma once

#include <span>

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

class RayCaster {
 public:
  /// Throws std::invalid_argument unless range_max [m] is positive and finite.
  RayCaster(const OccupancyGrid& grid, double range_max);

  /// For each angle [rad], in the laser's frame, the distance [m] to the first occupied cell; 0 from inside one;
  /// infinity if there is none within range_max or before the map's end.
  void cast(const Pose2& T_map_laser, std::span<const double> angles, std::span<float> ranges) const;

 private:
  float cast_one(const Pose2& T_map_laser, double angle) const;

  GridGeometry geometry_;
  Mask occupied_;
  double range_max_;
};

}  // namespace lfdcore
